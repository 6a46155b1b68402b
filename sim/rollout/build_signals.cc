#include "sim/rollout/build_signals.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <variant>

#include "sim/math/check.h"
#include "sim/math/overloaded.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/signals/body_signals.h"
#include "sim/signals/combined_signals.h"
#include "sim/signals/coordinate_signals.h"
#include "sim/signals/depth_signals.h"
#include "sim/signals/group_signals.h"
#include "sim/signals/shape_signals.h"
#include "sim/signals/track_signals.h"

namespace knap {

using Eigen::Vector3d;

namespace {

Vector3d MakeUnit(Axis axis) { return Vector3d::Unit(static_cast<int>(axis)); }

}  // namespace

// The scene has been checked: bodies and joints exist and fit.
class SignalSet::Builder {
 public:
  Builder(World world, const World& moved, const SceneModel& model, const DesignedShapes& shapes, SignalSet* out)
      : world_(std::move(world)), moved_(moved), model_(model), shapes_(shapes), out_(out) {}

  void Build() {
    for (std::size_t i = 0; i < moved_.signals.size(); ++i) {
      at_ = i;
      SignalPointer made =
          std::visit([&](const auto& kind) { return SignalPointer(Make(kind)); }, moved_.signals[i].kind);
      out_->by_name_.emplace(moved_.signals[i].name, std::move(made));
    }
  }

 private:
  using Pointer = std::unique_ptr<SignalFunction>;

  Pointer Make(const AngleSignal& s) const { return MakeCoordinate(s.joint); }
  Pointer Make(const DisplacementSignal& s) const { return MakeCoordinate(s.joint); }
  Pointer Make(const RateSignal& s) const { return MakeRateSignal(GetBody(s.joint).v_start); }
  Pointer Make(const SpeedSignal& s) const { return MakeRateSignal(GetBody(s.joint).v_start); }

  Pointer Make(const PositionSignal& s) { return MakePositionSignal(Watch(s), FindFrame(s.in), MakeUnit(s.axis)); }
  Pointer Make(const VelocitySignal& s) { return MakeVelocitySignal(Watch(s), MakeUnit(s.axis)); }
  Pointer Make(const DirectionSignal& s) const {
    return MakeDirectionSignal(FindFrame(s.body), MakeUnit(s.of), FindFrame(s.in), MakeUnit(s.axis));
  }
  Pointer Make(const AngularVelocitySignal& s) const {
    return MakeAngularVelocitySignal(FindFrame(s.body), MakeUnit(s.axis));
  }
  Pointer Make(const DistanceSignal& s) {
    std::vector<TimedPoint> targets;
    for (const TimedPosition& target : s.targets) targets.push_back({target.after, target.position});
    return MakeDistanceSignal(Watch(s), FindFrame(s.in), std::move(targets));
  }

  Pointer Make(const CenterOfMassSignal& s) const {
    return MakeCenterSignal(MakeGroup(s.of), FindFrame(s.in), MakeUnit(s.axis));
  }
  Pointer Make(const HeightSignal& s) const { return MakeCenterSignal(MakeGroup(s.of), kWorldFrame, GetUp()); }
  Pointer Make(const DriftSignal& s) {
    std::vector<double>& times = out_->remembered_;
    const auto place = std::lower_bound(times.begin(), times.end(), s.since);
    if (place == times.end() || *place != s.since) times.insert(place, s.since);
    return MakeDriftSignal(MakeGroup(s.of), FindFrame(s.carried_by), s.since, GetUp());
  }

  Pointer Make(const DepthSignal& s) const { return MakeDepthSignal(model_.contacts, ListContacts(s.bodies)); }
  Pointer Make(const ForceSignal& s) {
    const std::vector<int> contacts = ListContacts(s.bodies);
    out_->forces_.push_back({contacts});
    return MakeForceSignal(static_cast<int>(out_->forces_.size()) - 1, contacts);
  }
  Pointer Make(const VolumeSignal& s) { return Measure(s.body, MeasureVolume(shapes_.at(s.body).mesh)); }
  Pointer Make(const ExtentSignal& s) {
    return Measure(s.body, MeasureExtent(shapes_.at(s.body).mesh, static_cast<int>(s.axis)));
  }
  Pointer Make(const ThicknessSignal& s) { return Measure(s.body, MeasureThickness(shapes_.at(s.body).mesh, s.blend)); }
  Pointer Make(const CommandSignal& s) const { return MakeCommandSignal(FindCommandRow(moved_, s.actuator)); }
  Pointer Make(const TimeSignal&) const { return MakeTimeSignal(); }
  Pointer Make(const NumberSignal& s) {
    const std::vector<NumericKey> keys = ListWorldKeys(world_);
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const NumericKey& k) { return k.path == s.key; });
    KNAP_CHECK(found != keys.end(), "no number '{}'", s.key);
    return MakeConstantSignal(*found->value);
  }

  Pointer Make(const DifferenceSignal& s) const {
    return MakeDifferenceSignal(out_->Find(s.of[0]), out_->Find(s.of[1]));
  }
  Pointer Make(const NormSignal& s) const { return MakeNormSignal(FindParts(s.of)); }
  Pointer Make(const LeastSignal& s) const { return MakeLeastSignal(FindParts(s.of)); }
  Pointer Make(const LargestSignal& s) const { return MakeLargestSignal(FindParts(s.of)); }

  const TreeBody& GetBody(const std::string& name) const {
    return model_.tree.bodies()[static_cast<std::size_t>(model_.body_index.at(name))];
  }
  int FindFrame(const std::string& name) const { return name == kWorldName ? kWorldFrame : model_.body_index.at(name); }
  Vector3d GetUp() const {
    const double size = model_.tree.gravity.norm();
    return size > 0.0 ? Vector3d(-model_.tree.gravity / size) : Vector3d::UnitZ();
  }
  Pointer MakeCoordinate(const std::string& joint) const {
    return MakeCoordinateSignal(GetBody(joint).q_start, GetBody(joint).v_start);
  }

  // The point of the signal that is being made.
  template <class Kind>
  WatchedPoint Watch(const Kind& kind) {
    const auto& on_file = std::get<Kind>(world_.signals[at_].kind);
    out_->points_.push_back({kind.body, on_file.point});
    return {model_.body_index.at(kind.body), kind.point, static_cast<int>(out_->points_.size()) - 1};
  }

  Pointer Measure(const std::string& body, ShapeMeasure measure) {
    const double value = measure.value;
    out_->measures_.push_back({body, std::move(measure)});
    return MakeMeasureSignal(value, static_cast<int>(out_->measures_.size()) - 1);
  }

  Group MakeGroup(const std::vector<std::string>& of) const {
    std::vector<int> bodies;
    for (const std::string& name : of) {
      const auto links = model_.links.find(name);
      if (links == model_.links.end()) {
        bodies.push_back(model_.body_index.at(name));
      } else {
        bodies.insert(bodies.end(), links->second.begin(), links->second.end());
      }
    }
    return Group(model_.tree, bodies);
  }

  std::vector<int> ListContacts(const std::array<std::string, 2>& bodies) const {
    std::vector<int> contacts;
    for (std::size_t pair = 0; pair < model_.contacts.size(); ++pair) {
      const auto& of = moved_.contacts[static_cast<std::size_t>(model_.contact_of_pair[pair])].bodies;
      if (of == bodies || of == std::array{bodies[1], bodies[0]}) contacts.push_back(static_cast<int>(pair));
    }
    return contacts;
  }

  std::vector<SignalPointer> FindParts(const std::vector<std::string>& of) const {
    std::vector<SignalPointer> parts;
    for (const std::string& name : of) parts.push_back(out_->Find(name));
    return parts;
  }

  World world_;
  const World& moved_;
  const SceneModel& model_;
  const DesignedShapes& shapes_;
  SignalSet* out_;
  std::size_t at_ = 0;
};

SignalSet::SignalSet(const World& world, const World& moved, const SceneModel& model, const DesignedShapes& shapes) {
  Builder(World(world), moved, model, shapes, this).Build();
}

int FindCommandRow(const World& world, const std::string& actuator) {
  int row = 0;
  const auto find = [&](const std::vector<std::string>& actuators) {
    const auto found = std::find(actuators.begin(), actuators.end(), actuator);
    row += static_cast<int>(found - actuators.begin());
    return found != actuators.end();
  };
  const bool is_driven =
      (world.controls && find(world.controls->actuators)) || (world.policy && find(world.policy->actuators));
  KNAP_CHECK(is_driven, "no actuator '{}' is driven", actuator);
  return row;
}

}  // namespace knap
