// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected, initial value and final xor 0xFFFFFFFF), as in RFC 3720 §12.1.
#pragma once

#include <cstdint>
#include <string_view>

namespace knap {

// The checksum of `bytes`, or of the bytes before them and these when given the checksum of those before.
std::uint32_t CalcCrc32c(std::string_view bytes, std::uint32_t before = 0);

}  // namespace knap
