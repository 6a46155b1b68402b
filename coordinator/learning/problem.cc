#include "coordinator/learning/problem.h"

#include <cmath>
#include <cstddef>
#include <set>
#include <sstream>
#include <stdexcept>

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

void CheckDistribution(const std::string& name, const UniformDraw& uniform) {
  if (!(std::isfinite(uniform.lower) && std::isfinite(uniform.upper) && uniform.lower <= uniform.upper)) {
    Refuse("variation ", name, ": uniform on [", uniform.lower, ", ", uniform.upper,
           "]; expected finite values with lower <= upper");
  }
}

void CheckDistribution(const std::string& name, const NormalDraw& normal) {
  if (!(std::isfinite(normal.mean) && std::isfinite(normal.standard_deviation) && normal.standard_deviation >= 0.0)) {
    Refuse("variation ", name, ": normal with mean ", normal.mean, " and standard deviation ",
           normal.standard_deviation, "; expected finite values and a standard deviation >= 0");
  }
  if (!(normal.truncate_at > 0.0)) {
    Refuse("variation ", name, ": normal truncated at ", normal.truncate_at, " standard deviations; expected > 0");
  }
}

double Draw(const UniformDraw& uniform, CounterRandom& random) {
  return random.DrawUniform(uniform.lower, uniform.upper);
}

double Draw(const NormalDraw& normal, CounterRandom& random) {
  return normal.mean + normal.standard_deviation * random.DrawTruncatedNormal(normal.truncate_at);
}

}  // namespace

void CheckProblem(const Problem& problem) {
  CheckParameters(problem.parameters);
  std::vector<std::string> names;
  for (const VariationKey& key : problem.variations) {
    names.push_back(key.name);
    std::visit([&key](const auto& distribution) { CheckDistribution(key.name, distribution); }, key.distribution);
  }
  CheckNames("variations", names);
}

std::vector<double> SampleVariation(const VariationSpec& spec, std::uint64_t seed, RandomStream stream,
                                    std::uint64_t index) {
  CounterRandom random(seed, stream, index);
  std::vector<double> values;
  values.reserve(spec.size());
  for (const VariationKey& key : spec) {
    values.push_back(
        std::visit([&random](const auto& distribution) { return Draw(distribution, random); }, key.distribution));
  }
  return values;
}

std::vector<double> SampleTheta(const ParameterSpec& spec, std::uint64_t seed, std::uint64_t index) {
  CounterRandom random(seed, RandomStream::kRandomThetas, index);
  std::vector<double> theta(spec.names.size());
  for (std::size_t i = 0; i < theta.size(); ++i) theta[i] = random.DrawUniform(spec.lower[i], spec.upper[i]);
  return theta;
}

}  // namespace knap
