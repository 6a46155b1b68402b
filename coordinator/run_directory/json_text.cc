#include "coordinator/run_directory/json_text.h"

#include <cmath>
#include <stdexcept>

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

void CheckFinite(const Json& json, const std::string& path) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    throw std::runtime_error("JSON cannot hold the value of " + (path.empty() ? "/" : path) + ": it is not finite");
  }
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) CheckFinite(value, path + "/" + key);
}

}  // namespace

Json MakeJsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(); }

std::string MakeJsonText(const Json& json, int indent) {
  CheckFinite(json, "");
  return json.dump(indent);
}

}  // namespace knap
