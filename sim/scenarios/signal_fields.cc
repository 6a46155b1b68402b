#include "sim/scenarios/signal_fields.h"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "sim/math/overloaded.h"
#include "sim/scenarios/common_fields.h"
#include "sim/scenarios/numeric_keys.h"

namespace knap {

using std::string_view;

namespace {

void VisitJoint(FieldVisitor& v, string_view doc, std::string& joint) {
  v.Text({.key = "joint", .doc = doc, .role = TextRole::kBody}, joint);
}

constexpr string_view kRevolute = "of the revolute joint of this body";
constexpr string_view kPrismatic = "of the prismatic joint of this body";

void VisitBody(FieldVisitor& v, std::string& body) {
  v.Text({.key = "body", .doc = "that is watched", .role = TextRole::kBody}, body);
}

void VisitPoint(FieldVisitor& v, std::string& body, Eigen::Vector3d& point) {
  VisitBody(v, body);
  VisitVector(v, "point", "in B; on a designed body it moves with the mesh", kLength, point);
}

void VisitFrame(FieldVisitor& v, std::string& in) {
  v.Text({.key = "in", .doc = "whose frame it is seen in", .required = false, .role = TextRole::kBodyOrWorld}, in);
}

void VisitGroup(FieldVisitor& v, std::vector<std::string>& of) {
  v.LeafList({.key = "of", .doc = "bodies and ropes, by their common centre of mass"}, of, 1,
             [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kBodyOrRope}, name); });
}

void VisitSignals(FieldVisitor& v, std::vector<std::string>& of, std::size_t least) {
  v.LeafList({.key = "of", .doc = "signals that stand before this one, of one unit"}, of, least,
             [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kSignal}, name); });
}

void VisitPair(FieldVisitor& v, std::array<std::string, 2>& bodies) {
  v.FixedList({.key = "bodies", .doc = "two that have a contact"}, bodies,
              [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kBodyOrRope}, name); });
}

void VisitDesigned(FieldVisitor& v, std::string& body) {
  v.Text({.key = "body", .doc = "a designed one, whose shape is measured", .role = TextRole::kBody}, body);
}

}  // namespace

static void VisitFields(FieldVisitor& v, AngleSignal& s) { VisitJoint(v, kRevolute, s.joint); }
static void VisitFields(FieldVisitor& v, RateSignal& s) { VisitJoint(v, kRevolute, s.joint); }
static void VisitFields(FieldVisitor& v, DisplacementSignal& s) { VisitJoint(v, kPrismatic, s.joint); }
static void VisitFields(FieldVisitor& v, SpeedSignal& s) { VisitJoint(v, kPrismatic, s.joint); }

static void VisitFields(FieldVisitor& v, PositionSignal& s) {
  VisitPoint(v, s.body, s.point);
  VisitFrame(v, s.in);
  VisitAxis(v, "axis", "along which the coordinate is", s.axis);
}

static void VisitFields(FieldVisitor& v, VelocitySignal& s) {
  VisitPoint(v, s.body, s.point);
  VisitAxis(v, "axis", "of the world", s.axis);
}

static void VisitFields(FieldVisitor& v, DirectionSignal& s) {
  VisitBody(v, s.body);
  VisitAxis(v, "of", "axis of the body whose direction it is", s.of);
  VisitFrame(v, s.in);
  VisitAxis(v, "axis", "along which the component is", s.axis);
}

static void VisitFields(FieldVisitor& v, AngularVelocitySignal& s) {
  VisitBody(v, s.body);
  VisitAxis(v, "axis", "of the world", s.axis);
}

static void VisitFields(FieldVisitor& v, TimedPosition& t) {
  v.Number({.key = "after",
            .doc = "time after which it counts; the first one always does",
            .required = false,
            .dimension = kTime,
            .range = kNonNegative},
           t.after);
  v.Numbers({.key = "position", .doc = "in the frame", .dimension = kLength}, t.position);
}

static void VisitFields(FieldVisitor& v, DistanceSignal& s) {
  VisitPoint(v, s.body, s.point);
  VisitFrame(v, s.in);
  v.StructList({.key = "targets", .doc = "places from which the distance is, by time"}, s.targets, 1);
}

static void VisitFields(FieldVisitor& v, CenterOfMassSignal& s) {
  VisitGroup(v, s.of);
  VisitFrame(v, s.in);
  VisitAxis(v, "axis", "along which the coordinate is", s.axis);
}

static void VisitFields(FieldVisitor& v, HeightSignal& s) { VisitGroup(v, s.of); }

static void VisitFields(FieldVisitor& v, DriftSignal& s) {
  VisitGroup(v, s.of);
  v.Text({.key = "carried_by",
          .doc = "`world` or the body that is to carry the centre of mass along",
          .required = false,
          .role = TextRole::kBodyOrWorld},
         s.carried_by);
  v.Number({.key = "since",
            .doc = "time from which it is carried, a whole number of steps",
            .required = false,
            .dimension = kTime,
            .range = kNonNegative},
           s.since);
}

static void VisitFields(FieldVisitor& v, DepthSignal& s) { VisitPair(v, s.bodies); }
static void VisitFields(FieldVisitor& v, ForceSignal& s) { VisitPair(v, s.bodies); }

static void VisitFields(FieldVisitor& v, VolumeSignal& s) { VisitDesigned(v, s.body); }

static void VisitFields(FieldVisitor& v, ExtentSignal& s) {
  VisitDesigned(v, s.body);
  VisitAxis(v, "axis", "of B, along which the largest coordinate less the least is taken", s.axis);
}

static void VisitFields(FieldVisitor& v, ThicknessSignal& s) {
  VisitDesigned(v, s.body);
  v.Number(
      {.key = "blend",
       .doc = "thicknesses that are so much more than the least count for 1/e of it: the least is smooth over that",
       .required = false,
       .dimension = kLength,
       .range = kPositive},
      s.blend);
}

static void VisitFields(FieldVisitor& v, CommandSignal& s) {
  v.Text({.key = "actuator", .doc = "a body whose joint is driven", .role = TextRole::kBody}, s.actuator);
}

static void VisitFields(FieldVisitor&, TimeSignal&) {}

static void VisitFields(FieldVisitor& v, NumberSignal& s) {
  v.Text({.key = "key",
          .doc = "of a number that may vary, as in `variation`: of the world or of a signal before this one",
          .role = TextRole::kNumericKey},
         s.key);
}

static void VisitFields(FieldVisitor& v, DifferenceSignal& s) { VisitSignals(v, s.of, 2); }
static void VisitFields(FieldVisitor& v, NormSignal& s) { VisitSignals(v, s.of, 1); }
static void VisitFields(FieldVisitor& v, LeastSignal& s) { VisitSignals(v, s.of, 1); }
static void VisitFields(FieldVisitor& v, LargestSignal& s) { VisitSignals(v, s.of, 1); }

void VisitFields(FieldVisitor& v, Signal& signal) {
  v.Text({.key = "name", .doc = "by which losses, success and policies know it", .role = TextRole::kNewSignal},
         signal.name);
  v.OneOf({.key = "type",
           .doc = "a joint's angle, rate, displacement or speed; a coordinate of a body's point, or of its velocity; a "
                  "component of the direction of a body's axis, which tells orientations without singularities, or of "
                  "its angular velocity; a point's distance from places; a coordinate, the height or the rise of a "
                  "centre of mass; a contact's depth or force; of a designed body's shape the volume, the extent along "
                  "an axis or "
                  "the walls' least thickness; a command; the time; a number of the scene, such as a "
                  "goal; of other signals the difference, norm, least or largest"},
          signal.kind, {"angle",      "rate",           "displacement", "speed",
                        "position",   "velocity",       "direction",    "angular_velocity",
                        "distance",   "center_of_mass", "height",       "drift",
                        "depth",      "force",          "volume",       "extent",
                        "thickness",  "command",        "time",         "number",
                        "difference", "norm",           "least",        "largest"});
}

SignalDimensions::SignalDimensions(World& world) {
  std::vector<NumericKey> keys;  // walked for where there is a number
  for (const Signal& signal : world.signals) {
    const auto add = [&](const Dimension& dimension) { dimensions_.try_emplace(signal.name, dimension); };
    std::visit(
        Overloaded{[&](const AngleSignal& s) {
                     // Also what stands in the place of a kind that could not be read, and then without a joint.
                     if (!s.joint.empty()) add(kAngle);
                   },
                   [&](const RateSignal&) { add(kAngularSpeed); }, [&](const SpeedSignal&) { add(kSpeed); },
                   [&](const VelocitySignal&) { add(kSpeed); }, [&](const DirectionSignal&) { add(kDimensionless); },
                   [&](const AngularVelocitySignal&) { add(kAngularSpeed); },
                   [&](const ForceSignal&) { add(kForceDimension); }, [&](const VolumeSignal&) { add(kVolume); },
                   [&](const CommandSignal&) { add(kDimensionless); }, [&](const TimeSignal&) { add(kTime); },
                   [&](const NumberSignal& s) {
                     if (keys.empty()) keys = ListWorldKeys(world);
                     const auto found =
                         std::find_if(keys.begin(), keys.end(), [&](const NumericKey& k) { return k.path == s.key; });
                     if (found != keys.end()) add(found->dimension);
                   },
                   [&](const auto& s) {
                     // Of signals; what is left of others is a length.
                     using Kind = std::decay_t<decltype(s)>;
                     if constexpr (std::is_same_v<Kind, DifferenceSignal> || std::is_same_v<Kind, NormSignal> ||
                                   std::is_same_v<Kind, LeastSignal> || std::is_same_v<Kind, LargestSignal>) {
                       const std::optional<Dimension> first = s.of.empty() ? std::nullopt : Find(s.of.front());
                       if (first) add(*first);
                     } else {
                       add(kLength);
                     }
                   }},
        signal.kind);
  }
}

std::optional<Dimension> SignalDimensions::Find(const std::string& signal) const {
  const auto found = dimensions_.find(signal);
  return found == dimensions_.end() ? std::nullopt : std::optional(found->second);
}

FieldInfo SignalDimensions::With(FieldInfo info, const std::string& signal) const {
  const std::optional<Dimension> dimension = Find(signal);
  info.dimension = dimension.value_or(kDimensionless);
  info.dimension_known = dimension.has_value();
  info.dimension_is_of = "the signal";
  return info;
}

}  // namespace knap
