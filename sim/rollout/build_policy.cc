#include "sim/rollout/build_policy.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "sim/math/check.h"
#include "sim/math/overloaded.h"
#include "sim/rollout/control_commands.h"
#include "sim/scenarios/check_actuation.h"
#include "sim/scenarios/numeric_keys.h"

namespace knap {
namespace {

using Eigen::Vector3d;

Vector3d MakeUnit(Axis axis) { return Vector3d::Unit(static_cast<int>(axis)); }

// Of the tree. Bodies and joints exist and fit: the scene has been checked.
class ObservationBuilder {
 public:
  // Observed numbers are those of `scene`.
  ObservationBuilder(Scene scene, const SceneModel& model) : model_(model) {
    std::vector<std::string> keys;
    for (const PolicyObservation& observation : scene.policy->observations) {
      if (const auto* number = std::get_if<NumberObservation>(&observation)) keys.push_back(number->key);
    }
    if (keys.empty()) return;
    const std::vector<double*> values = FindNumericKeys(scene, keys);
    for (std::size_t i = 0; i < keys.size(); ++i) numbers_[keys[i]] = *values[i];
  }

  Observation Make(const PolicyObservation& observation) {
    Observation out = std::visit(Overloaded{[&](const AngleObservation& o) { return MakeCoordinate(o.joint); },
                                            [&](const DisplacementObservation& o) { return MakeCoordinate(o.joint); },
                                            [&](const RateObservation& o) { return MakeRate(o.joint); },
                                            [&](const SpeedObservation& o) { return MakeRate(o.joint); },
                                            [&](const PositionObservation& o) {
                                              Observation made = MakeOfBody(ObservationKind::kPosition, o.body, o.axis);
                                              made.point = o.point;
                                              made.in = FindFrame(o.in);
                                              return made;
                                            },
                                            [&](const VelocityObservation& o) {
                                              Observation made = MakeOfBody(ObservationKind::kVelocity, o.body, o.axis);
                                              made.point = o.point;
                                              return made;
                                            },
                                            [&](const DirectionObservation& o) {
                                              Observation made =
                                                  MakeOfBody(ObservationKind::kDirection, o.body, o.axis);
                                              made.in = FindFrame(o.in);
                                              made.of_axis = MakeUnit(o.of);
                                              return made;
                                            },
                                            [&](const AngularVelocityObservation& o) {
                                              return MakeOfBody(ObservationKind::kAngularVelocity, o.body, o.axis);
                                            },
                                            [&](const TimeObservation&) {
                                              Observation made;
                                              made.kind = ObservationKind::kElapsedTime;
                                              return made;
                                            },
                                            [&](const NumberObservation& o) {
                                              Observation made;
                                              made.kind = ObservationKind::kConstant;
                                              made.constant = numbers_.at(o.key);
                                              return made;
                                            }},
                                 observation);
    std::visit(
        [&](const auto& o) {
          out.offset = o.offset;
          out.scale = o.scale;
        },
        observation);
    return out;
  }

 private:
  const TreeBody& GetJoint(const std::string& name) const {
    return model_.tree.bodies()[static_cast<std::size_t>(model_.body_index.at(name))];
  }

  Observation MakeCoordinate(const std::string& joint) const {
    Observation made;
    made.kind = ObservationKind::kCoordinate;
    made.index = GetJoint(joint).q_start;
    made.rate = GetJoint(joint).v_start;
    return made;
  }

  Observation MakeRate(const std::string& joint) const {
    Observation made;
    made.kind = ObservationKind::kRate;
    made.index = GetJoint(joint).v_start;
    return made;
  }

  Observation MakeOfBody(ObservationKind kind, const std::string& body, Axis axis) const {
    Observation made;
    made.kind = kind;
    made.body = model_.body_index.at(body);
    made.axis = MakeUnit(axis);
    return made;
  }

  int FindFrame(const std::string& name) const { return name == kWorldName ? -1 : model_.body_index.at(name); }

  const SceneModel& model_;
  std::map<std::string, double> numbers_;  // by their keys
};

}  // namespace

Network MakeNetwork(const Policy& policy) {
  return Network(static_cast<int>(policy.observations.size()),
                 std::vector<int>(policy.hidden.begin(), policy.hidden.end()),
                 static_cast<int>(policy.actuators.size()), policy.squash == Squash::kTanh);
}

int CountWeights(const Scene& scene) { return scene.policy ? static_cast<int>(CountPolicyWeights(*scene.policy)) : 0; }

ClosedLoop MakeClosedLoop(const Scene& scene, const Scene& moved, const SceneModel& model,
                          const Eigen::VectorXd& weights) {
  const Policy& policy = *moved.policy;
  ObservationBuilder builder(scene, model);
  std::vector<Observation> observations;
  for (const PolicyObservation& observation : policy.observations) observations.push_back(builder.Make(observation));
  std::vector<PolicyOutput> outputs;
  for (const std::string& body : policy.actuators) {
    const auto found = std::find_if(model.actuators.begin(), model.actuators.end(),
                                    [&](const ActuatorCommand& actuator) { return actuator.body == body; });
    KNAP_CHECK(found != model.actuators.end(), "no actuator '{}'", body);
    outputs.push_back({static_cast<int>(found - model.actuators.begin()), found->center, found->half});
  }
  return ClosedLoop(MakeNetwork(policy), std::move(observations), std::move(outputs), weights,
                    CountIntervals(policy.interval, moved.rollout));
}

std::vector<PointCotangent> ListObservedPoints(const Policy& policy, const std::vector<Vector3d>& bar_points) {
  std::vector<PointCotangent> out;
  for (std::size_t i = 0; i < policy.observations.size(); ++i) {
    std::visit(
        [&](const auto& observation) {
          if constexpr (requires { observation.point; }) {
            out.push_back({observation.body, observation.point, bar_points[i]});
          }
        },
        policy.observations[i]);
  }
  return out;
}

}  // namespace knap
