#include "coordinator/report/theta_json.h"

#include <cstddef>
#include <string>

namespace knap {

std::vector<double> TakeDesign(const ParameterSpec& parameters, const std::vector<double>& theta) {
  return {theta.begin(), theta.end() - static_cast<std::ptrdiff_t>(parameters.controls)};
}

nlohmann::ordered_json MakeBoundsJson(const ParameterSpec& parameters) {
  const std::size_t d = parameters.names.size() - parameters.controls;
  std::vector<std::string> units;
  for (std::size_t i = 0; i < d; ++i) units.push_back(parameters.GetUnit(i));
  return {{"names", std::vector<std::string>(parameters.names.begin(),
                                             parameters.names.begin() + static_cast<std::ptrdiff_t>(d))},
          {"kinds", units},
          {"lower", TakeDesign(parameters, parameters.lower)},
          {"upper", TakeDesign(parameters, parameters.upper)}};
}

}  // namespace knap
