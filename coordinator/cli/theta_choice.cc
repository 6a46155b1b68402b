#include "coordinator/cli/theta_choice.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/usage_error.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr std::string_view kRandomPrefix = "random:";
constexpr std::int64_t kMostRandom = 100000;

std::vector<std::vector<double>> SampleThetas(std::string_view count_text, const ParameterSpec& parameters,
                                              std::uint64_t seed) {
  const std::optional<std::int64_t> count = ParseInteger(count_text);
  if (!count || *count < 1 || *count > kMostRandom) {
    throw UsageError(fmt::format("--theta: random:{}: expected a number from 1 to {}", count_text, kMostRandom));
  }
  CheckRequestVolume(fmt::format("--theta: random:{}", count_text), {static_cast<double>(*count)},
                     parameters.names.size());
  std::vector<std::vector<double>> thetas;
  for (std::int64_t i = 0; i < *count; ++i) {
    thetas.push_back(SampleTheta(parameters, seed, static_cast<std::uint64_t>(i)));
  }
  return thetas;
}

}  // namespace

std::vector<double> ChooseTheta(const std::string& text, const ParameterSpec& parameters, const NamedDesigns& named) {
  const auto get = [&](const std::string& name) {
    return name == "learned" ? named.read_learned() : parameters.initial;
  };
  if (text.empty()) return get(named.by_default);
  if (text == "learned") return get(text);
  const bool is_partial = text.find('=') != std::string::npos;
  return ParseTheta(text, "--theta", parameters, is_partial ? get(named.by_default) : parameters.initial);
}

std::vector<std::vector<double>> ChooseThetas(const std::string& text, const ParameterSpec& parameters,
                                              std::uint64_t seed, const NamedDesigns& named) {
  if (text.rfind(kRandomPrefix, 0) == 0) {
    return SampleThetas(std::string_view(text).substr(kRandomPrefix.size()), parameters, seed);
  }
  return {ChooseTheta(text, parameters, named)};
}

}  // namespace knap
