#include "coordinator/run/policy_training.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <variant>

#include "coordinator/run/initial_weights.h"
#include "sim/math/check.h"
#include "sim/rollout/control_commands.h"
#include "sim/scenarios/dump_scene.h"

namespace knap {
namespace {

using Eigen::VectorXd;

VectorXd MakeVector(std::span<const double> values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// The state at which an interval begins. Times are sums of steps, so that they may be off by some units of rounding.
std::size_t FindState(const Recording& recording, double time) {
  constexpr double kSlack = 1e-9;  // [s]
  const auto at = std::lower_bound(recording.time.begin(), recording.time.end(), time - kSlack);
  KNAP_CHECK(at != recording.time.end() && *at < time + kSlack, "no state at {} s", time);
  return static_cast<std::size_t>(at - recording.time.begin());
}

const Recording::Signal& FindSignal(const Recording& recording, const std::string& name) {
  return *std::find_if(recording.signals.begin(), recording.signals.end(),
                       [&](const Recording::Signal& signal) { return signal.name == name; });
}

}  // namespace

LoadedScenario MakeOpenLoopScenario(const LoadedScenario& scenario) {
  LoadedScenario open_loop = scenario;
  Scene& scene = open_loop.parsed.scene;
  if (!scene.policy) throw std::invalid_argument("the scenario has no section policy: there is nothing to train");
  if (scene.controls) {
    throw std::invalid_argument(
        "the scenario has open-loop controls beside its policy: training such a policy is not "
        "supported");
  }
  if (const auto* file = std::get_if<WeightsFile>(&scene.policy->initial)) open_loop.files.erase(file->file);
  scene.controls.emplace();
  scene.controls->actuators = scene.policy->actuators;
  scene.controls->interval = scene.policy->interval;
  scene.policy.reset();
  scene.learning.method = SceneLearningMethod::kDiffHand;
  scene.learning.optimize = {LearnedPart::kControl};
  if (scene.design) scene.learning.optimize.insert(scene.learning.optimize.begin(), LearnedPart::kDesign);
  open_loop.files[kScenarioFileName] = DumpScene(scene);
  scene = ParseScenarioFiles(open_loop.files);  // as any other scenario is checked
  return open_loop;
}

Examples CollectExamples(const Policy& policy, RolloutModel& open_loop, std::span<const Demonstration> demonstrations) {
  Examples examples;
  for (const Demonstration& demonstration : demonstrations) {
    if (!demonstration.success) continue;
    const VectorXd theta = MakeVector(demonstration.theta);
    RolloutInput input;
    input.theta = theta.head(open_loop.num_parameters());
    input.controls = theta.tail(open_loop.num_controls());
    input.variation = demonstration.variation;
    input.want_gradient = false;
    const Recording recording = open_loop.Record(input, 0.0).recording;
    const Eigen::MatrixXd commands = CalcCommands(*open_loop.scene().controls, input.controls);
    for (Eigen::Index k = 0; k < commands.cols(); ++k) {
      const std::size_t state = FindState(recording, static_cast<double>(k) * policy.interval);
      VectorXd& seen = examples.seen.emplace_back(static_cast<Eigen::Index>(policy.observations.size()));
      for (std::size_t i = 0; i < policy.observations.size(); ++i) {
        const Observation& o = policy.observations[i];
        const double value = FindSignal(recording, o.signal).values[state];
        seen(static_cast<Eigen::Index>(i)) = (value - o.offset) / o.scale;
      }
      examples.wanted.push_back(commands.col(k));
    }
  }
  return examples;
}

std::vector<double> MakeImitationStart(const Policy& policy, std::uint64_t seed) {
  Policy random = policy;
  random.initial = RandomWeights{.seed = static_cast<std::int64_t>(seed)};
  return MakeInitialWeights(random, {});
}

PolicyTrial TryPolicy(RolloutModel& closed_loop, std::span<const double> weights, std::span<const double> design,
                      std::span<const double> variation) {
  RolloutInput input;
  input.theta = MakeVector(design);
  input.controls = MakeVector(weights);
  input.variation.assign(variation.begin(), variation.end());
  input.want_gradient = false;
  const RolloutOutput out = closed_loop.Run(input, {});
  return {.loss = out.loss, .success = out.success};
}

}  // namespace knap
