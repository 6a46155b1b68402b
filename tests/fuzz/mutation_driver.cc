// NAME_fuzz [ITERATIONS [SEED]]: mutates a target's seeds and feeds them to it, the same way for the same seed.
//
// Not guided by coverage as libFuzzer is; it runs where only GCC is at hand. A failing input is printed in hexadecimal
// before the sanitizers end the process.
#include <sanitizer/common_interface_defs.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_target.h"

// An abort and an allocation larger than any message explains are findings, with the input that led to them.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "handle_abort=1:max_allocation_size_mb=64"; }

namespace {

std::string g_input;  // the present one, for the report

void PrintInput() {
  std::fprintf(stderr, "input:");
  for (const char c : g_input) std::fprintf(stderr, " %02x", static_cast<unsigned char>(c));
  std::fprintf(stderr, "\n");
}

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::size_t Draw(std::size_t below) { return static_cast<std::size_t>(random_() % below); }

  // Small changes as damage makes them, and interesting numbers as an attacker would choose them.
  std::string Mutate(std::string bytes, const std::string& other) {
    for (std::size_t changes = 1 + Draw(6); changes > 0; --changes) {
      const std::size_t at = bytes.empty() ? 0 : Draw(bytes.size());
      switch (Draw(7)) {
        case 0:
          if (!bytes.empty()) bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ (1U << Draw(8)));
          break;
        case 1:
          if (!bytes.empty()) bytes[at] = static_cast<char>(random_());
          break;
        case 2:
          bytes.insert(at, 1 + Draw(8), static_cast<char>(random_()));
          break;
        case 3:
          bytes.erase(at, 1 + Draw(16));
          break;
        case 4:
          bytes.resize(Draw(bytes.size() + 1));
          break;
        case 5: {
          static constexpr std::uint32_t kNumbers[] = {0,      1,          0x7f,       0x80,       0xff,      0x7fff,
                                                       0xffff, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff};
          const std::uint32_t number = kNumbers[Draw(std::size(kNumbers))];
          for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i) {
            bytes[at + i] = static_cast<char>((number >> (24 - 8 * i)) & 0xff);
          }
          break;
        }
        default:
          bytes = bytes.substr(0, at) + other.substr(std::min(at, other.size()));
          break;
      }
    }
    return bytes;
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace

int main(int argc, char** argv) {
  const long iterations = argc > 1 ? std::atol(argv[1]) : 100'000;
  Mutator mutator(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
  __sanitizer_set_death_callback(PrintInput);
  std::vector<std::string> pool = MakeSeeds();
  const std::size_t seeds = pool.size();
  for (long i = 0; i < iterations; ++i) {
    g_input = i < static_cast<long>(seeds)
                  ? pool[static_cast<std::size_t>(i)]
                  : mutator.Mutate(pool[mutator.Draw(pool.size())], pool[mutator.Draw(pool.size())]);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(g_input.data()), g_input.size());
    // Some mutants live on, so that changes pile up.
    if (mutator.Draw(8) == 0 && g_input.size() < 4096) {
      if (pool.size() < seeds + 256) {
        pool.push_back(g_input);
      } else {
        pool[seeds + mutator.Draw(256)] = g_input;
      }
    }
  }
  std::printf("%ld inputs\n", iterations);
}
