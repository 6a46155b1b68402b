#include "coordinator/cli/theta_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "coordinator/cli/exit_codes.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr std::string_view kRandomPrefix = "random:";
constexpr std::int64_t kMostRandom = 100000;

void Assign(std::string_view assignment, const ParameterSpec& parameters, std::vector<double>* theta) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw UsageError(fmt::format("--theta: '{}': expected initial, learned, random:K or NAME=VALUE,...", assignment));
  }
  const std::string name(assignment.substr(0, equals));
  const auto found = std::find(parameters.names.begin(), parameters.names.end(), name);
  if (found == parameters.names.end()) {
    throw UsageError(fmt::format("--theta: no parameter '{}'; there are {}", name, fmt::join(parameters.names, ", ")));
  }
  const std::string_view value = assignment.substr(equals + 1);
  const std::optional<Quantity> quantity = ParseQuantity(value);
  if (!quantity || !(quantity->dimension == kLength)) {
    throw UsageError(fmt::format("--theta: {}: value '{}': expected {}", name, value, DescribeQuantity(kLength)));
  }
  (*theta)[static_cast<std::size_t>(found - parameters.names.begin())] = quantity->value;
}

std::vector<std::vector<double>> SampleThetas(std::string_view count_text, const ParameterSpec& parameters,
                                              std::uint64_t seed) {
  const std::optional<std::int64_t> count = ParseInteger(count_text);
  if (!count || *count < 1 || *count > kMostRandom) {
    throw UsageError(fmt::format("--theta: random:{}: expected a number from 1 to {}", count_text, kMostRandom));
  }
  std::vector<std::vector<double>> thetas;
  for (std::int64_t i = 0; i < *count; ++i) {
    thetas.push_back(SampleTheta(parameters, seed, static_cast<std::uint64_t>(i)));
  }
  return thetas;
}

}  // namespace

std::vector<std::vector<double>> ChooseThetas(const std::string& text, const ParameterSpec& parameters,
                                              std::uint64_t seed,
                                              const std::function<std::vector<double>()>& read_learned) {
  if (text == "initial") return {parameters.initial};
  if (text == "learned") return {read_learned()};
  if (text.rfind(kRandomPrefix, 0) == 0) {
    return SampleThetas(std::string_view(text).substr(kRandomPrefix.size()), parameters, seed);
  }
  std::vector<double> theta = parameters.initial;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    Assign(std::string_view(text).substr(begin, end - begin), parameters, &theta);
    begin = end + 1;
  }
  return {theta};
}

}  // namespace knap
