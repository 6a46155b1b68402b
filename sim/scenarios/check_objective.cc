#include "sim/scenarios/check_objective.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/signal_fields.h"

namespace knap {
namespace {

// Calls visit(path, within) for every condition that has signals, in the order of the file.
template <class Visit>
void VisitConditions(const Condition& condition, const std::string& path, const Visit& visit) {
  std::visit(
      [&](const auto& kind) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, Within>) {
          visit(path, kind);
        } else {
          for (std::size_t i = 0; i < kind.of.size(); ++i) {
            VisitConditions(kind.of[i], fmt::format("{}.of[{}]", path, i), visit);
          }
        }
      },
      condition.kind);
}

// Calls visit(path, term) for every term.
template <class Visit>
void VisitTerms(const Loss& loss, const Visit& visit) {
  for (std::size_t i = 0; i < loss.task.size(); ++i) visit(fmt::format("loss.task[{}]", i), loss.task[i]);
  for (std::size_t i = 0; i < loss.distillation.size(); ++i) {
    visit(fmt::format("loss.distillation[{}]", i), loss.distillation[i]);
  }
}

class ObjectiveChecker {
 public:
  ObjectiveChecker(Scene& scene, FieldLog& log) : scene_(scene), log_(log), dimensions_(scene) {}

  void Check() {
    for (const Signal& signal : scene_.signals) {
      if (!signal.name.empty()) CheckSignal(signal);
    }
    VisitTerms(scene_.loss, [&](const std::string& path, const Term& term) { CheckTerm(term, path); });
    if (scene_.success) {
      VisitConditions(*scene_.success, "success", [&](const std::string& path, const Within& within) {
        CheckSignals(within.signals, path + ".signals");
      });
    }
    if (!scene_.policy) return;
    for (std::size_t i = 0; i < scene_.policy->observations.size(); ++i) {
      CheckObservation(scene_.policy->observations[i], fmt::format("policy.observations[{}]", i));
    }
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  void CheckSignal(const Signal& signal) {
    const std::string path = "signals." + signal.name;
    std::visit(Overloaded{[&](const AngleSignal& s) { CheckJoint<RevoluteJoint>(s.joint, "revolute", path); },
                          [&](const RateSignal& s) { CheckJoint<RevoluteJoint>(s.joint, "revolute", path); },
                          [&](const DisplacementSignal& s) { CheckJoint<PrismaticJoint>(s.joint, "prismatic", path); },
                          [&](const SpeedSignal& s) { CheckJoint<PrismaticJoint>(s.joint, "prismatic", path); },
                          [&](const PositionSignal& s) { CheckFrame(s.in, s.body, path); },
                          [&](const DirectionSignal& s) { CheckFrame(s.in, s.body, path); },
                          [&](const DistanceSignal& s) { CheckFrame(s.in, s.body, path); },
                          [&](const CenterOfMassSignal& s) { CheckGroup(s.of, path); },
                          [&](const HeightSignal& s) { CheckGroup(s.of, path); },
                          [&](const DriftSignal& s) { CheckGroup(s.of, path); },
                          [&](const DepthSignal& s) { CheckPair(s.bodies, path); },
                          [&](const ForceSignal& s) { CheckPair(s.bodies, path); },
                          [&](const VolumeSignal& s) { CheckDesigned(s.body, path); },
                          [&](const ExtentSignal& s) { CheckDesigned(s.body, path); },
                          [&](const ThicknessSignal& s) { CheckDesigned(s.body, path); },
                          [&](const CommandSignal& s) { CheckCommand(s, path); },
                          [&](const DifferenceSignal& s) {
                            if (s.of.size() > 2) Report({path + ".of"}, "a difference is of two signals");
                            CheckParts(s.of, signal.name, path);
                          },
                          [&](const NormSignal& s) { CheckParts(s.of, signal.name, path); },
                          [&](const LeastSignal& s) { CheckParts(s.of, signal.name, path); },
                          [&](const LargestSignal& s) { CheckParts(s.of, signal.name, path); },
                          [](const auto&) {}},
               signal.kind);
  }

  template <class Wanted>
  void CheckJoint(const std::string& name, const char* wanted, const std::string& path) {
    if (log_.HasFailedNear("bodies." + name + ".joint")) return;
    const Body* body = FindBody(scene_, name);
    if (body == nullptr || std::holds_alternative<Wanted>(body->joint.kind)) return;
    Report({path + ".joint", "bodies." + name + ".joint.type"},
           fmt::format("the joint of this body is not {}; of others the body's position, direction, velocity and "
                       "angular_velocity can be watched",
                       wanted));
  }

  void CheckFrame(const std::string& in, const std::string& body, const std::string& path) {
    if (in == body && !in.empty()) {
      Report({path + ".in", path + ".body"}, "a body does not move in its own frame; name another one, or the world");
    }
  }

  void CheckGroup(const std::vector<std::string>& of, const std::string& path) {
    if (HasRepeats(of)) Report({path + ".of"}, "names something twice");
    for (std::size_t i = 0; i < of.size(); ++i) {
      const Body* body = FindBody(scene_, of[i]);
      if (body == nullptr) continue;
      if (!body->inertia) {
        Report({fmt::format("{}.of[{}]", path, i), "bodies." + of[i]}, "has no inertia, and so no centre of mass");
      } else if (FindShape<DesignedMeshShape>(*body) != nullptr &&
                 std::holds_alternative<DensityInertia>(*body->inertia)) {
        Report({fmt::format("{}.of[{}]", path, i), "bodies." + of[i]},
               "the centre of mass of this body moves with its design: give it an explicit inertia, or watch a point");
      }
    }
  }

  void CheckPair(const std::array<std::string, 2>& pair, const std::string& path) {
    const bool touch = std::any_of(scene_.contacts.begin(), scene_.contacts.end(), [&](const Contact& contact) {
      return contact.bodies == pair || contact.bodies == std::array{pair[1], pair[0]};
    });
    if (!touch) {
      Report({path + ".bodies", "contacts"}, fmt::format("{} has no contact with {}; see contacts", pair[0], pair[1]));
    }
  }

  // That it has a design is said where that is looked at.
  void CheckDesigned(const std::string& name, const std::string& path) {
    const Body* body = FindBody(scene_, name);
    if (body == nullptr || FindShape<DesignedMeshShape>(*body) != nullptr) return;
    Report({path + ".body", "bodies." + name + ".shapes"},
           "none of its shapes is a designed mesh; others stay as they are");
  }

  void CheckCommand(const CommandSignal& signal, const std::string& path) {
    const auto drives = [&](const std::vector<std::string>& actuators) {
      return std::find(actuators.begin(), actuators.end(), signal.actuator) != actuators.end();
    };
    if (scene_.controls && drives(scene_.controls->actuators)) return;
    if (scene_.policy && drives(scene_.policy->actuators)) return;
    if (FindBody(scene_, signal.actuator) == nullptr || log_.HasFailedNear("controls.actuators")) return;
    Report({path + ".actuator"}, "neither controls nor a policy drive this body's joint");
  }

  void CheckParts(const std::vector<std::string>& of, const std::string& name, const std::string& path) {
    const auto end = std::find_if(scene_.signals.begin(), scene_.signals.end(),
                                  [&](const Signal& signal) { return signal.name == name; });
    for (std::size_t i = 0; i < of.size(); ++i) {
      const bool exists = FindSignal(of[i]) != nullptr;
      const bool before = std::any_of(scene_.signals.begin(), end, [&](const Signal& s) { return s.name == of[i]; });
      if (exists && !before) Report({fmt::format("{}.of[{}]", path, i)}, "must stand before this signal");
    }
    CheckSignals(of, path + ".of");
  }

  const Signal* FindSignal(const std::string& name) const {
    const auto found = std::find_if(scene_.signals.begin(), scene_.signals.end(),
                                    [&](const Signal& signal) { return signal.name == name; });
    return found == scene_.signals.end() ? nullptr : &*found;
  }

  // Of one unit. A list with an unknown name has been reported.
  void CheckSignals(const std::vector<std::string>& names, const std::string& path) {
    for (std::size_t i = 1; i < names.size(); ++i) {
      CheckUnit(names[i], names[0], {fmt::format("{}[{}]", path, i), path});
    }
  }

  void CheckUnit(const std::string& name, const std::string& first, const std::vector<std::string>& paths) {
    const std::optional<Dimension> dimension = dimensions_.Find(name);
    const std::optional<Dimension> wanted = dimensions_.Find(first);
    if (!dimension || !wanted || *dimension == *wanted) return;
    Report(paths, fmt::format("'{}' is in {} and '{}' in {}; they must have one unit", name, DescribeUnit(*dimension),
                              first, DescribeUnit(*wanted)));
  }

  static std::string DescribeUnit(const Dimension& dimension) {
    const std::string unit = UnitName(dimension);
    return unit.empty() ? "no unit" : unit;
  }

  void CheckTerm(const Term& term, const std::string& path) {
    CheckSignals(term.signals, path + ".signals");
    if (const auto* target = std::get_if<SignalTarget>(&term.target)) {
      if (!term.signals.empty()) CheckUnit(target->signal, term.signals[0], {path + ".target.signal"});
    }
    const bool refers = std::holds_alternative<ReferenceTarget>(term.target);
    const bool distils = path.starts_with("loss.distillation");
    if (refers && !distils) {
      Report({path + ".target.type"}, "the reference trajectory is known in loss.distillation alone");
    }
    if (refers && distils && std::holds_alternative<AtCrossing>(term.when)) {
      Report({path + ".when.type"}, "the reference trajectory is known at the end, at a time and over samples");
    }
  }

  void CheckObservation(const Observation& observation, const std::string& path) {
    const bool looks_back = Uses(observation.signal, [](const SignalKind& kind) {
      return std::holds_alternative<DriftSignal>(kind) || std::holds_alternative<DepthSignal>(kind) ||
             std::holds_alternative<ForceSignal>(kind) || std::holds_alternative<CommandSignal>(kind) ||
             std::holds_alternative<VolumeSignal>(kind) || std::holds_alternative<ExtentSignal>(kind) ||
             std::holds_alternative<ThicknessSignal>(kind);
    });
    if (!looks_back) return;
    Report({path + ".signal"},
           fmt::format("a policy sees the present state alone, and '{}' looks at more: drifts, commands, contacts and "
                       "shapes cannot be observed",
                       observation.signal));
  }

  // Whether the signal, or one that it is made of, is of a kind. What stands in a cycle has been reported.
  template <class IsOfKind>
  bool Uses(const std::string& name, const IsOfKind& is_of_kind) const {
    std::set<std::string> seen;
    std::vector<std::string> open{name};
    while (!open.empty()) {
      const std::string next = std::move(open.back());
      open.pop_back();
      const Signal* signal = seen.insert(next).second ? FindSignal(next) : nullptr;
      if (signal == nullptr) continue;
      if (is_of_kind(signal->kind)) return true;
      std::visit(Overloaded{[&](const DifferenceSignal& s) { open.insert(open.end(), s.of.begin(), s.of.end()); },
                            [&](const NormSignal& s) { open.insert(open.end(), s.of.begin(), s.of.end()); },
                            [&](const LeastSignal& s) { open.insert(open.end(), s.of.begin(), s.of.end()); },
                            [&](const LargestSignal& s) { open.insert(open.end(), s.of.begin(), s.of.end()); },
                            [](const auto&) {}},
                 signal->kind);
    }
    return false;
  }

  Scene& scene_;
  FieldLog& log_;
  SignalDimensions dimensions_;
};

class NumberChecker {
 public:
  explicit NumberChecker(const Scene& scene) : scene_(scene) {}

  std::vector<ValueFault> Check() {
    for (const Signal& signal : scene_.signals) {
      const std::string path = "signals." + signal.name;
      if (const auto* distance = std::get_if<DistanceSignal>(&signal.kind)) {
        CheckAscending(distance->targets, path + ".targets");
      }
      if (const auto* drift = std::get_if<DriftSignal>(&signal.kind)) CheckTime(drift->since, path + ".since");
    }
    VisitTerms(scene_.loss, [&](const std::string& path, const Term& term) { CheckTerm(term, path); });
    if (scene_.success) {
      VisitConditions(*scene_.success, "success",
                      [&](const std::string& path, const Within& within) { CheckWithin(within, path); });
    }
    return std::move(faults_);
  }

 private:
  void Report(std::vector<std::string> paths, std::string message) {
    faults_.push_back({std::move(paths), std::move(message)});
  }

  template <class Timed>
  void CheckAscending(const std::vector<Timed>& items, const std::string& path) {
    for (std::size_t i = 1; i < items.size(); ++i) {
      if (items[i].after > items[i - 1].after) continue;
      Report({fmt::format("{}[{}].after", path, i), fmt::format("{}[{}]", path, i)},
             "must be later than the one before");
    }
  }

  void CheckTime(double time, const std::string& path) {
    if (time != 0.0 && !IsWholeMultiple(time, scene_.rollout.step)) {
      Report({path, "rollout.step"},
             fmt::format("must be a whole number of steps of {}", FormatQuantity(scene_.rollout.step, kTime)));
    } else if (time > scene_.rollout.horizon * (1.0 + kDecimalRoundOff)) {
      Report({path, "rollout.horizon"},
             fmt::format("must be at most the horizon, {}", FormatQuantity(scene_.rollout.horizon, kTime)));
    }
  }

  // Returns the end that counts.
  double CheckSpan(double from, double until, const std::string& path) {
    if (until > scene_.rollout.horizon * (1.0 + kDecimalRoundOff)) {
      Report({path + ".until", "rollout.horizon"},
             fmt::format("must be at most the horizon, {}", FormatQuantity(scene_.rollout.horizon, kTime)));
    }
    const double end = until == 0.0 ? scene_.rollout.horizon : until;
    if (from >= end) {
      Report({path + ".from", path + ".until", "rollout.horizon"},
             fmt::format("must be less than {}, {}", until == 0.0 ? "the horizon" : "`until`",
                         FormatQuantity(end, kTime)));
    }
    return end;
  }

  void CheckTerm(const Term& term, const std::string& path) {
    if (const auto* target = std::get_if<ScheduleTarget>(&term.target)) {
      CheckAscending(target->values, path + ".target.values");
    }
    if (const auto* at = std::get_if<AtTime>(&term.when)) CheckTime(at->time, path + ".when.time");
    const auto* samples = std::get_if<OverSamples>(&term.when);
    if (samples == nullptr) return;
    const std::string when = path + ".when";
    const std::string step = FormatQuantity(scene_.rollout.step, kTime);
    if (!IsWholeMultiple(samples->every, scene_.rollout.step)) {
      Report({when + ".every", "rollout.step"}, fmt::format("must be a whole number of steps of {}", step));
      return;
    }
    if (samples->from != 0.0 && !IsWholeMultiple(samples->from, scene_.rollout.step)) {
      Report({when + ".from", "rollout.step"}, fmt::format("must be a whole number of steps of {}", step));
      return;
    }
    const std::size_t faults = faults_.size();
    const double end = CheckSpan(samples->from, samples->until, when);
    if (faults_.size() > faults || samples->from + samples->every <= end * (1.0 + kDecimalRoundOff)) return;
    Report({when + ".every", when + ".until", when + ".from"},
           fmt::format("no sample lies between {} and {}; one comes every {}", FormatQuantity(samples->from, kTime),
                       FormatQuantity(end, kTime), FormatQuantity(samples->every, kTime)));
  }

  void CheckWithin(const Within& within, const std::string& path) {
    if (!(within.above < within.below)) {
      Report({path + ".above", path + ".below"}, "must be less than `below`");
    }
    const std::string when = path + ".when";
    std::visit(Overloaded{[&](const AtTime& w) { CheckTime(w.time, when + ".time"); },
                          [&](const Ever& w) { CheckSpan(w.from, w.until, when); },
                          [&](const Always& w) { CheckSpan(w.from, w.until, when); },
                          [&](const Lasting& w) {
                            const double end = CheckSpan(w.from, w.until, when);
                            if (w.duration <= (end - w.from) * (1.0 + kDecimalRoundOff)) return;
                            Report({when + ".duration"},
                                   fmt::format("must fit into the span, {}", FormatQuantity(end - w.from, kTime)));
                          },
                          [](const auto&) {}},
               within.when);
  }

  const Scene& scene_;
  std::vector<ValueFault> faults_;
};

}  // namespace

void CheckObjective(Scene& scene, FieldLog& log) { ObjectiveChecker(scene, log).Check(); }

std::vector<ValueFault> FindObjectiveFaults(const Scene& scene) { return NumberChecker(scene).Check(); }

}  // namespace knap
