#include "coordinator/run/initial_weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <variant>

#include "coordinator/random/counter_random.h"
#include "sim/policy/weights_file.h"
#include "sim/rollout/build_policy.h"

namespace knap {
namespace {

constexpr double kTruncateAt = 3.0;  // standard deviations

}  // namespace

std::vector<double> MakeInitialWeights(const Policy& policy, const std::map<std::string, std::string>& files) {
  const Network network = MakeNetwork(policy);
  if (const auto* from = std::get_if<WeightsFile>(&policy.initial)) {
    const auto file = files.find(from->file);
    if (file == files.end()) {
      throw std::runtime_error(fmt::format("policy.initial.file: there is no file '{}'", from->file));
    }
    const Eigen::VectorXd weights =
        ParseWeights(file->second, from->file, network.num_weights(), policy.lower, policy.upper);
    return {weights.begin(), weights.end()};
  }
  const auto& random = std::get<RandomWeights>(policy.initial);
  const std::vector<int> fan_ins = network.ListFanIns();
  std::vector<double> weights(fan_ins.size(), 0.0);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (fan_ins[i] == 0) continue;
    CounterRandom draws(static_cast<std::uint64_t>(random.seed), RandomStream::kPolicyWeights, i);
    const double value = random.scale / std::sqrt(fan_ins[i]) * draws.DrawTruncatedNormal(kTruncateAt);
    weights[i] = std::clamp(value, policy.lower, policy.upper);
  }
  return weights;
}

}  // namespace knap
