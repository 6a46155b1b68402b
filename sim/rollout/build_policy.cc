#include "sim/rollout/build_policy.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sim/math/check.h"
#include "sim/rollout/control_commands.h"
#include "sim/scenarios/check_actuation.h"

namespace knap {

Network MakeNetwork(const Policy& policy) {
  return Network(static_cast<int>(policy.observations.size()),
                 std::vector<int>(policy.hidden.begin(), policy.hidden.end()),
                 static_cast<int>(policy.actuators.size()), policy.squash == Squash::kTanh);
}

int CountWeights(const World& world) { return world.policy ? static_cast<int>(CountPolicyWeights(*world.policy)) : 0; }

ClosedLoop MakeClosedLoop(const Scene& scene, const SignalSet& signals, const SceneModel& model,
                          const Eigen::VectorXd& weights) {
  const Policy& policy = *scene.policy;
  std::vector<PolicyInput> inputs;
  for (const Observation& o : policy.observations) inputs.push_back({signals.Find(o.signal), o.offset, o.scale});
  std::vector<PolicyOutput> outputs;
  for (const std::string& body : policy.actuators) {
    const auto found = std::find_if(model.actuators.begin(), model.actuators.end(),
                                    [&](const ActuatorCommand& actuator) { return actuator.body == body; });
    KNAP_CHECK(found != model.actuators.end(), "no actuator '{}'", body);
    outputs.push_back({static_cast<int>(found - model.actuators.begin()), found->center, found->half});
  }
  return ClosedLoop(MakeNetwork(policy), std::move(inputs), std::move(outputs), weights,
                    CountIntervals(policy.interval, scene.rollout), static_cast<int>(signals.points().size()));
}

}  // namespace knap
