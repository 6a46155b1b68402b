// Series of numbers as the page reads them: little-endian IEEE 754 singles or 32-bit integers in base64, a third of
// what they take in decimals.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace knap {

std::string PackSingles(std::span<const float> numbers);
std::string PackIntegers(std::span<const std::uint32_t> numbers);

}  // namespace knap
