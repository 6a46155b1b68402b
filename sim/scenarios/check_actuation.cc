#include "sim/scenarios/check_actuation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

const JointActuator* FindActuator(const Body& body) {
  return std::visit(
      [](const auto& joint) -> const JointActuator* {
        if constexpr (requires { joint.actuator; }) {
          return joint.actuator ? &*joint.actuator : nullptr;
        } else {
          return nullptr;
        }
      },
      body.joint.kind);
}

class ActuationChecker {
 public:
  ActuationChecker(const Scene& scene, FieldLog& log) : scene_(scene), log_(log) {}

  void Check() {
    const bool right = !scene_.controls || CheckControls(*scene_.controls);
    if (scene_.policy) CheckPolicy(*scene_.policy, right);
    if (scene_.controls && right) CheckControlCount(*scene_.controls);
    CheckLearnedParts();
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  // Null when the body's joint is wrong by itself, which has been reported.
  const Body* FindSoundBody(const std::string& name) const {
    return log_.HasFailedNear("bodies." + name + ".joint") ? nullptr : FindBody(scene_, name);
  }

  // Whether the interval is right.
  bool CheckDriven(const std::vector<std::string>& actuators, double interval, const std::string& section) {
    if (HasRepeats(actuators)) Report({section + ".actuators"}, "names an actuator twice");
    for (std::size_t i = 0; i < actuators.size(); ++i) {
      const Body* body = FindSoundBody(actuators[i]);
      if (body == nullptr || FindActuator(*body) != nullptr) continue;
      Report({fmt::format("{}.actuators[{}]", section, i), "bodies." + body->name + ".joint.type"},
             "the joint of this body has no actuator");
    }
    const std::string path = section + ".interval";
    if (!IsWholeMultiple(interval, scene_.rollout.step)) {
      Report({path, "rollout.step"},
             fmt::format("must be a whole number of steps of {}", FormatQuantity(scene_.rollout.step, kTime)));
      return false;
    }
    if (IsWholeMultiple(scene_.rollout.horizon, scene_.rollout.step) &&
        !IsWholeMultiple(scene_.rollout.horizon, interval)) {
      Report({path, "rollout.horizon"}, fmt::format("the horizon, {}, must be a whole number of intervals",
                                                    FormatQuantity(scene_.rollout.horizon, kTime)));
      return false;
    }
    return true;
  }

  // Whether their interval is right.
  bool CheckControls(const Controls& controls) {
    const bool right = CheckDriven(controls.actuators, controls.interval, "controls");
    if (controls.lower >= controls.upper) {
      Report({"controls.lower", "controls.upper"}, fmt::format("must be less than upper, {}", controls.upper));
    } else if (controls.initial < controls.lower || controls.initial > controls.upper) {
      Report({"controls.initial", "controls.lower", "controls.upper"},
             fmt::format("must lie from lower, {}, to upper, {}", controls.lower, controls.upper));
    }
    if (controls.squash == Squash::kNone && (controls.lower < -1.0 || controls.upper > 1.0)) {
      Report({controls.lower < -1.0 ? "controls.lower" : "controls.upper", "controls.squash"},
             "commands lie from -1 to 1, and so must controls that are not squashed");
    }
    return right;
  }

  // Counted as a real number: whether it fits an integer is what is asked.
  void CheckControlCount(const Controls& controls) {
    const double count =
        std::round(scene_.rollout.horizon / controls.interval) * static_cast<double>(controls.actuators.size());
    const std::int64_t weights = scene_.policy ? CountPolicyWeights(*scene_.policy) : 0;
    if (count + static_cast<double>(weights) <= static_cast<double>(kMostWeights)) return;
    // A horizon or a network that is too large by itself is reported as such.
    if (weights > kMostWeights || scene_.rollout.horizon / scene_.rollout.step > kMostSteps) return;
    Report({"controls.interval", "rollout.horizon"},
           fmt::format("these are {:.0f} controls{}, at most {} are allowed", count,
                       weights > 0 ? fmt::format(" beside the {} weights of the policy", weights) : "", kMostWeights));
  }

  void CheckPolicy(const Policy& policy, bool controls_have_right_interval) {
    const bool right = CheckDriven(policy.actuators, policy.interval, "policy") && controls_have_right_interval;
    for (std::size_t i = 0; i < policy.actuators.size(); ++i) {
      const std::string path = fmt::format("policy.actuators[{}]", i);
      const std::string& name = policy.actuators[i];
      if (scene_.controls &&
          std::count(scene_.controls->actuators.begin(), scene_.controls->actuators.end(), name) > 0) {
        Report({path, "controls.actuators"}, "open-loop controls drive this actuator already");
      }
      const Body* body = FindSoundBody(name);
      const JointActuator* actuator = body == nullptr ? nullptr : FindActuator(*body);
      if (policy.squash == Squash::kNone && actuator != nullptr && std::holds_alternative<ForceActuator>(*actuator)) {
        Report({"policy.squash", path, "bodies." + name + ".joint.actuator.type"},
               fmt::format("outputs that are not squashed have no bounds, and the force actuator of {} has no limit of "
                           "its own: squash them with tanh",
                           name));
      }
    }
    if (right && scene_.controls && scene_.controls->interval != policy.interval) {
      Report({"policy.interval", "controls.interval"},
             fmt::format("must be that of the controls, {}", FormatQuantity(scene_.controls->interval, kTime)));
    }
    if (policy.lower >= policy.upper) {
      Report({"policy.lower", "policy.upper"}, fmt::format("must be less than upper, {}", policy.upper));
    } else if (std::holds_alternative<RandomWeights>(policy.initial) && (policy.lower > 0.0 || policy.upper < 0.0)) {
      Report({policy.lower > 0.0 ? "policy.lower" : "policy.upper", "policy.initial.type"},
             "random weights lie around 0, and biases begin there: the bounds must enclose it");
    }
    const std::int64_t weights = CountPolicyWeights(policy);
    if (weights > kMostWeights) {
      Report({"policy.hidden", "policy"},
             fmt::format("the network has {} weights, at most {} are allowed", weights, kMostWeights));
    }
  }

  void CheckLearnedParts() {
    const Learning& learning = scene_.learning;
    if (HasRepeats(learning.optimize)) Report({"learning.optimize"}, "names something twice");
    for (std::size_t i = 0; i < learning.optimize.size(); ++i) {
      const std::string path = fmt::format("learning.optimize[{}]", i);
      const LearnedPart part = learning.optimize[i];
      if (part == LearnedPart::kDesign) {
        // A scene with none of the three is valid: it can be simulated, and nothing can be learned from it.
        if (!scene_.design && scene_.IsDriven()) {
          Report({path, scene_.controls ? "controls" : "policy"},
                 fmt::format("the scenario has no section design; write optimize: [{}]",
                             scene_.controls ? "control" : "policy"));
        }
        continue;
      }
      const bool is_policy = part == LearnedPart::kPolicy;
      if (is_policy ? !scene_.policy : !scene_.controls) {
        Report({path}, fmt::format("the scenario has no section {}", is_policy ? "policy" : "controls"));
      }
      if (learning.method == SceneLearningMethod::kOurs) {
        Report({path, "learning.method"},
               fmt::format("method ours chooses among design parameters alone; diffhand and simple_continual move {}",
                           is_policy ? "policies" : "controls"));
      }
    }
  }

  const Scene& scene_;
  FieldLog& log_;
};

}  // namespace

std::int64_t CountPolicyWeights(const Policy& policy) {
  std::int64_t count = 0;
  auto inputs = static_cast<std::int64_t>(policy.observations.size());
  const auto add_layer = [&](std::int64_t units) {
    count += units * (inputs + 1);
    inputs = units;
  };
  for (const std::int64_t units : policy.hidden) add_layer(units);
  add_layer(static_cast<std::int64_t>(policy.actuators.size()));
  return count;
}

void CheckActuation(const Scene& scene, FieldLog& log) { ActuationChecker(scene, log).Check(); }

}  // namespace knap
