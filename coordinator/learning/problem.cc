#include "coordinator/learning/problem.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <set>
#include <sstream>
#include <stdexcept>

#include "coordinator/learning/variation_draws.h"

namespace knap {
namespace {

template <typename... Parts>
[[noreturn]] void Refuse(const Parts&... parts) {
  std::ostringstream text;
  text.precision(17);
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}

void CheckNames(const std::string& field, const std::vector<std::string>& names) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) Refuse(field, ": a name is empty");
    if (!seen.insert(name).second) Refuse(field, ": the name \"", name, "\" occurs twice");
  }
}

void CheckParameters(const ParameterSpec& spec) {
  const std::size_t d = spec.names.size();
  if (d == 0) Refuse("parameters: at least one is needed");
  if (spec.lower.size() != d || spec.upper.size() != d || spec.initial.size() != d) {
    Refuse("parameters: ", d, " names, ", spec.lower.size(), " lower, ", spec.upper.size(), " upper and ",
           spec.initial.size(), " initial values; expected equal numbers");
  }
  if ((!spec.units.empty() && spec.units.size() != d) || (!spec.fixed.empty() && spec.fixed.size() != d) ||
      spec.controls > d) {
    Refuse("parameters: ", d, " names, ", spec.units.size(), " units, ", spec.fixed.size(), " marks of fixed ones and ",
           spec.controls, " controls");
  }
  CheckNames("parameters", spec.names);
  for (std::size_t i = 0; i < d; ++i) {
    if (!(std::isfinite(spec.lower[i]) && std::isfinite(spec.upper[i]) && spec.lower[i] < spec.upper[i])) {
      Refuse("parameter ", spec.names[i], ": bounds [", spec.lower[i], ", ", spec.upper[i],
             "]; expected finite values with lower < upper");
    }
    if (!(spec.lower[i] <= spec.initial[i] && spec.initial[i] <= spec.upper[i])) {
      Refuse("parameter ", spec.names[i], ": initial value ", spec.initial[i], " is outside [", spec.lower[i], ", ",
             spec.upper[i], "]");
    }
  }
}

}  // namespace

std::string FormatParameter(const ParameterSpec& parameters, std::size_t i, double value) {
  const std::string unit = parameters.GetUnit(i);
  if (unit == "m") return fmt::format("{} {:.2f} mm", parameters.names[i], 1e3 * value);
  return fmt::format("{} {:.4g}{}{}", parameters.names[i], value, unit.empty() ? "" : " ", unit);
}

void CheckProblem(const Problem& problem) {
  CheckParameters(problem.parameters);
  for (const VariationKeys& keys : problem.variations) {
    if (keys.names.empty()) Refuse("variations: an entry without a name");
    const std::string fault = FindDrawFault(keys);
    if (!fault.empty()) Refuse(fault);
  }
  CheckNames("variations", ListNames(problem.variations));
}

std::vector<double> SampleVariation(const VariationSpec& spec, std::uint64_t seed, RandomStream stream,
                                    std::uint64_t index) {
  CounterRandom random(seed, stream, index);
  std::vector<double> values;
  for (const VariationKeys& keys : spec) DrawVariation(keys, random, &values);
  return values;
}

std::vector<std::string> ListNames(const VariationSpec& spec) {
  std::vector<std::string> names;
  for (const VariationKeys& keys : spec) names.insert(names.end(), keys.names.begin(), keys.names.end());
  return names;
}

std::vector<DrawRange> ListDrawRanges(const VariationSpec& spec) {
  std::vector<DrawRange> ranges;
  for (const VariationKeys& keys : spec) AddDrawRanges(keys, &ranges);
  return ranges;
}

std::vector<double> SampleTheta(const ParameterSpec& spec, std::uint64_t seed, std::uint64_t index) {
  CounterRandom random(seed, RandomStream::kRandomThetas, index);
  std::vector<double> theta(spec.names.size());
  for (std::size_t i = 0; i < theta.size(); ++i) theta[i] = random.DrawUniform(spec.lower[i], spec.upper[i]);
  return theta;
}

}  // namespace knap
