#include "coordinator/report/packed_numbers.h"

#include <sodium.h>

#include <bit>
#include <vector>

namespace knap {
namespace {

std::string Encode(const std::vector<unsigned char>& bytes) {
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // the terminating zero
  return text;
}

void Append(std::uint32_t word, std::vector<unsigned char>* bytes) {
  for (int shift = 0; shift < 32; shift += 8) bytes->push_back(static_cast<unsigned char>(word >> shift));
}

}  // namespace

std::string PackSingles(std::span<const float> numbers) {
  std::vector<unsigned char> bytes;
  bytes.reserve(4 * numbers.size());
  for (const float x : numbers) Append(std::bit_cast<std::uint32_t>(x), &bytes);
  return Encode(bytes);
}

std::string PackIntegers(std::span<const std::uint32_t> numbers) {
  std::vector<unsigned char> bytes;
  bytes.reserve(4 * numbers.size());
  for (const std::uint32_t x : numbers) Append(x, &bytes);
  return Encode(bytes);
}

}  // namespace knap
