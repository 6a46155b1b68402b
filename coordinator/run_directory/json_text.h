// Numbers and documents as JSON, which has neither NaN nor infinity.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace knap {

// Null where `value` is not finite.
nlohmann::ordered_json MakeJsonNumber(double value);

// The text of `json`, with an indent of so many spaces or in one line (-1). Doubles read back to the same bits. The
// library would write null for a number that is not finite: throws std::runtime_error with the path of such a number.
std::string MakeJsonText(const nlohmann::ordered_json& json, int indent);

}  // namespace knap
