// Lengths on the command line.
#pragma once

#include <string>
#include <string_view>

namespace knap {

// A length of more than 0 [m]: "0.4 mm", "1 cm"; a number alone counts in millimetres. Throws UsageError that begins
// with `option` and says what is expected.
double ParseLength(std::string_view text, const std::string& option);

}  // namespace knap
