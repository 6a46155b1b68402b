#include "coordinator/cli/rollout_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <string_view>

#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/usage_error.h"
#include "sim/scenarios/field_visitor.h"
#include "sim/scenarios/nearest_name.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr std::size_t kMostNamesShown = 20;

// Of parameter i: the unit that the problem names it with stands for it.
Dimension GetDimension(const ParameterSpec& parameters, std::size_t i) {
  const std::string unit = parameters.GetUnit(i);
  return unit.empty() ? kDimensionless : ParseQuantity("1 " + unit).value().dimension;
}

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(',', begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

double ParseValue(const std::string& text, const Dimension& dimension, const std::string& where) {
  const auto quantity = ParseQuantity(text);
  if (!quantity || (quantity->dimension != dimension && quantity->dimension != kDimensionless)) {
    const std::string unit = UnitName(dimension);
    throw UsageError(fmt::format("{}: value '{}': expected a number{}", where, text,
                                 unit.empty() ? "" : fmt::format(" in {} or with its unit", unit)));
  }
  return quantity->value;
}

void CheckCount(std::size_t got, std::size_t expected, const std::string& what, const std::string& option) {
  if (got == expected) return;
  throw UsageError(fmt::format("{}: {} values; the scenario has {} {}", option, got, expected, what));
}

}  // namespace

std::size_t FindParameter(const std::string& name, const std::string& option, const ParameterSpec& parameters) {
  const std::vector<std::string>& names = parameters.names;
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const std::string nearest = FindNearestName(name, names);
  const auto shown_end = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), kMostNamesShown));
  throw UsageError(fmt::format("{}: no parameter '{}'; {}", option, name,
                               nearest.empty()
                                   ? fmt::format("there are {}{}", fmt::join(names.begin(), shown_end, ", "),
                                                 shown_end == names.end() ? "" : ", …")
                                   : fmt::format("did you mean {}?", nearest)));
}

std::vector<double> ParseTheta(const std::string& text, const std::string& option, const ParameterSpec& parameters,
                               const std::vector<double>& others) {
  const std::vector<std::string>& names = parameters.names;
  if (text == "initial") return parameters.initial;
  std::vector<double> theta = others;
  const std::vector<std::string> parts = Split(text);
  if (text.find('=') == std::string::npos) {
    if (!ParseQuantity(parts.front())) {
      throw UsageError(
          fmt::format("{}: '{}': expected initial, NAME=VALUE,… or all {} values", option, text, names.size()));
    }
    CheckCount(parts.size(), names.size(), "parameters", option);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      theta[i] = ParseValue(parts[i], GetDimension(parameters, i), fmt::format("{}: {}", option, names[i]));
    }
    return theta;
  }
  std::vector<bool> given(names.size(), false);
  for (const std::string& part : parts) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) throw UsageError(fmt::format("{}: '{}': expected NAME=VALUE", option, part));
    const std::string name = part.substr(0, equals);
    const std::size_t i = FindParameter(name, option, parameters);
    if (given[i]) throw UsageError(fmt::format("{}: {} is given twice", option, name));
    given[i] = true;
    // A person writes this: as in files, 30 must not stand for metres unnoticed.
    const std::string value = part.substr(equals + 1);
    const auto quantity = ParseQuantity(value);
    const Dimension dimension = GetDimension(parameters, i);
    if (!quantity || quantity->dimension != dimension) {
      throw UsageError(
          fmt::format("{}: {}: value '{}': expected {}", option, name, value, DescribeQuantity(dimension)));
    }
    theta[i] = quantity->value;
  }
  return theta;
}

std::vector<double> ParseVariationValues(const std::string& text, const std::string& option, Scene scene) {
  const std::vector<std::string> parts = Split(text);
  const std::vector<std::string> varied = ListVariedKeys(scene.variation);
  CheckCount(parts.size(), varied.size(), "varied keys", option);
  std::map<std::string, NumericKey> keys;
  for (const NumericKey& key : ListNumericKeys(scene)) keys[key.path] = key;
  std::vector<double> values;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const NumericKey& key = keys.at(varied[i]);
    const std::string where = fmt::format("{}: {}", option, key.path);
    values.push_back(ParseValue(parts[i], key.dimension, where));
    if (!key.range.Contains(values.back())) {
      throw UsageError(
          fmt::format("{}: value '{}': must be {}", where, parts[i], DescribeRange(key.range, key.dimension)));
    }
  }
  return values;
}

std::vector<double> ReadNominalVariation(Scene scene) {
  const std::vector<std::string> paths = ListVariedKeys(scene.variation);
  std::vector<double> values;
  for (const double* value : FindNumericKeys(scene, paths)) values.push_back(*value);
  return values;
}

std::vector<double> SampleTestVariation(const LoadedScenario& scenario, std::optional<std::uint64_t> seed,
                                        std::uint64_t number) {
  const Scene& scene = scenario.parsed.scene;
  return SampleVariation(MakeProblem(scene, scenario.files).variations,
                         seed.value_or(static_cast<std::uint64_t>(scene.evaluation.seed)),
                         RandomStream::kTestVariations, number);
}

void SplitControls(const std::vector<double>& values, std::size_t count, Eigen::VectorXd* design,
                   Eigen::VectorXd* controls) {
  const Eigen::Map<const Eigen::VectorXd> all(values.data(), static_cast<Eigen::Index>(values.size()));
  const auto n = static_cast<Eigen::Index>(count);
  *design = all.head(all.size() - n);
  *controls = all.tail(n);
}

std::string QuoteForShell(const std::string& text) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace knap
