// What a fuzz target is: libFuzzer's entry point, and seeds for the driver that takes libFuzzer's place under GCC.
//
// A target throws nothing and aborts when a property does not hold; the sanitizers watch over the rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// Inputs that reach far into the decoder, to be mutated.
std::vector<std::string> MakeSeeds();

// Aborts with the text unless the property holds.
inline void Require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "property violated: %s\n", property);
  std::abort();
}
