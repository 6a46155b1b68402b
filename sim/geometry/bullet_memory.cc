#include "sim/geometry/bullet_memory.h"

#include <LinearMath/btAlignedAllocator.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace knap {
namespace {

void* AllocateOrThrow(std::size_t size, int alignment) {
  void* memory = nullptr;
  if (posix_memalign(&memory, static_cast<std::size_t>(alignment), size) != 0) throw std::bad_alloc();
  return memory;
}

}  // namespace

void UseThrowingBulletAllocator() {
  [[maybe_unused]] static const bool once = [] {
    btAlignedAllocSetCustomAligned(&AllocateOrThrow, &std::free);
    return true;
  }();
}

}  // namespace knap
