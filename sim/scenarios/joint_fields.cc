#include "sim/scenarios/joint_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {

using std::string_view;

// ---- Joints -------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, ZigzagMotion& m) {
  v.Number(
      {.key = "amplitude", .doc = "lateral swing along Jx, to each side", .dimension = kLength, .range = kNonNegative},
      m.amplitude);
  v.Number({.key = "period", .doc = "of the swing", .dimension = kTime, .range = kPositive}, m.period);
  v.Number({.key = "sharpness",
            .doc = "k: near 0 a sine, near 1 a triangle wave",
            .required = false,
            .range = {0.0, 0.9999, true}},
           m.sharpness);
  v.Number({.key = "forward_speed", .doc = "along Jy", .dimension = kSpeed, .range = kNonNegative}, m.forward_speed);
  v.Number(
      {.key = "stop_at", .doc = "y in J at which the forward motion ends", .dimension = kLength, .range = kNonNegative},
      m.stop_at);
}

static void VisitFields(FieldVisitor& v, ConstantVelocityMotion& m) {
  VisitVector(v, "velocity", "of Bo in J", kSpeed, m.velocity);
  VisitVector(v, "angular_velocity", "of B in J", kAngularSpeed, m.angular_velocity);
}

static void VisitFields(FieldVisitor& v, MotionSegment& s) {
  v.Number({.key = "duration", .doc = "from rest to rest", .dimension = kTime, .range = kPositive}, s.duration);
  v.Number({.key = "ramp",
            .doc = "during which the speed rises, and in the end falls; at most half the duration",
            .dimension = kTime,
            .range = kPositive},
           s.ramp);
  VisitVector(v, "shift", "of Bo in J", kLength, s.shift);
  v.Number({.key = "angle", .doc = "of a turn about Bo", .required = false, .dimension = kAngle}, s.angle);
  VisitVector(v, "axis", "of the turn in J, of any length", kDimensionless, s.axis);
  VisitVector(v, "tips",
              "in place of `axis`: a direction in J that points straight up and straight down during a full turn; the "
              "axis is the level one across it, whose sense is fixed in J and not to gravity",
              kDimensionless, s.tips);
}

static void VisitFields(FieldVisitor& v, SegmentsMotion& m) {
  v.StructList({.key = "segments", .doc = "one after the other, then still"}, m.segments, 1);
}

static void VisitFields(FieldVisitor& v, PathMotion& m) {
  v.Text({.key = "file",
          .doc = "CSV with the columns time (s), x, y, z (m), roll, pitch, yaw (rad) of B in J: smooth between the "
                 "rows, at rest before the first and after the last",
          .role = TextRole::kFile},
         m.file);
}

static void VisitFields(FieldVisitor& v, JointPathMotion& m) {
  static constexpr string_view kKinds[] = {"turn", "shift"};
  v.Text({.key = "file", .doc = "CSV with a column time (s) and others, as `path` has it", .role = TextRole::kFile},
         m.file);
  v.Text({.key = "column", .doc = "name of the column that this joint follows"}, m.column);
  v.EnumField({.key = "kind", .doc = "turn: the column is an angle (rad); shift: a length (m)", .required = false},
              m.kind, kKinds);
  VisitVector(v, "axis", "direction in J, of any length but zero", kDimensionless, m.axis);
}

static void VisitFields(FieldVisitor& v, Motion& motion) {
  v.OneOf({.key = "type", .doc = "how the body moves"}, motion,
          {"zigzag", "constant_velocity", "segments", "path", "joint_path"});
}

static void VisitFields(FieldVisitor&, FixedJoint&) {}

static void VisitFields(FieldVisitor& v, PrescribedJoint& j) {
  v.Struct({.key = "motion", .doc = "pose of B in J as a function of time"}, j.motion);
}

// The dimensions of what acts within a joint of one degree of freedom.
struct JointDimensions {
  Dimension coordinate, effort, stiffness, damping, limit_damping;
  string_view limits_doc, actuator_doc;
};
static constexpr JointDimensions kTurning{kAngle,
                                          kTorque,
                                          kAngularStiffness,
                                          kAngularDamping,
                                          kAngularLimitDamping,
                                          "springs at the ends of a revolute joint's range",
                                          "of a revolute joint, known by the body's name"};
static constexpr JointDimensions kSliding{kLength,
                                          kForceDimension,
                                          kLinearStiffness,
                                          kLinearDamping,
                                          kContactDamping,
                                          "springs at the ends of a prismatic joint's range",
                                          "of a prismatic joint, known by the body's name"};

static void VisitLimits(FieldVisitor& v, const JointDimensions& is, JointLimits& l) {
  v.Number({.key = "lower", .doc = "end of the range", .dimension = is.coordinate}, l.lower);
  v.Number({.key = "upper", .doc = "end of the range", .dimension = is.coordinate}, l.upper);
  v.Number({.key = "stiffness", .doc = "of the spring beyond an end", .dimension = is.stiffness, .range = kPositive},
           l.stiffness);
  v.Number({.key = "damping",
            .doc = "relative to the spring's effort (Hunt and Crossley)",
            .required = false,
            .dimension = is.limit_damping,
            .range = kNonNegative},
           l.damping);
  v.Number({.key = "width", .doc = "over which the spring sets in", .dimension = is.coordinate, .range = kPositive},
           l.width);
}

static void VisitEffortLimit(FieldVisitor& v, const JointDimensions& is, double& limit) {
  v.Number(
      {.key = "limit", .doc = "largest effort, that of a command of 1", .dimension = is.effort, .range = kPositive},
      limit);
}

static void VisitActuator(FieldVisitor& v, const JointDimensions& is, ForceActuator& a) {
  VisitEffortLimit(v, is, a.limit);
}

static void VisitActuator(FieldVisitor& v, const JointDimensions& is, PositionActuator& a) {
  v.Number({.key = "limit", .doc = "largest effort", .dimension = is.effort, .range = kPositive}, a.limit);
  v.Number(
      {.key = "stiffness", .doc = "effort per distance from the target", .dimension = is.stiffness, .range = kPositive},
      a.stiffness);
  v.Number(
      {.key = "damping", .doc = "effort per rate", .required = false, .dimension = is.damping, .range = kNonNegative},
      a.damping);
  v.Number({.key = "lower", .doc = "target of a command of -1", .dimension = is.coordinate}, a.lower);
  v.Number({.key = "upper", .doc = "target of a command of 1", .dimension = is.coordinate}, a.upper);
}

// What the joints of one degree of freedom have in common.
template <class OneDofJoint>
static void VisitOneDof(FieldVisitor& v, const JointDimensions& is, OneDofJoint& j) {
  VisitVector(v, "axis", "direction in J, of any length but zero", kDimensionless, j.axis);
  v.Number(
      {.key = "damping", .doc = "effort per rate", .required = false, .dimension = is.damping, .range = kNonNegative},
      j.damping);
  v.Number(
      {.key = "stiffness", .doc = "of a spring", .required = false, .dimension = is.stiffness, .range = kNonNegative},
      j.stiffness);
  v.Number({.key = "rest", .doc = "where the spring pulls to", .required = false, .dimension = is.coordinate}, j.rest);
  v.OptionalStruct({.key = "limits", .doc = is.limits_doc, .required = false}, j.limits,
                   [&is](FieldVisitor& w, JointLimits& limits) { VisitLimits(w, is, limits); });
  v.OptionalStruct({.key = "actuator", .doc = is.actuator_doc, .required = false}, j.actuator,
                   [&is](FieldVisitor& w, JointActuator& actuator) {
                     w.OneOf({.key = "type", .doc = "force: effort limit·u; position: PD control towards a target"},
                             actuator, {"force", "position"},
                             [&is](FieldVisitor& x, auto& kind) { VisitActuator(x, is, kind); });
                   });
}

static void VisitFields(FieldVisitor& v, RevoluteJoint& j) { VisitOneDof(v, kTurning, j); }

static void VisitFields(FieldVisitor& v, PrismaticJoint& j) { VisitOneDof(v, kSliding, j); }

static void VisitFields(FieldVisitor& v, BallJoint& j) {
  v.Number({.key = "damping",
            .doc = "torque per angular speed",
            .required = false,
            .dimension = kAngularDamping,
            .range = kNonNegative},
           j.damping);
  v.Number({.key = "stiffness",
            .doc = "k of the spring energy k (1 - cos angle)",
            .required = false,
            .dimension = kAngularStiffness,
            .range = kNonNegative},
           j.stiffness);
  VisitVector(v, "rest_rpy", "orientation of B in J where the spring pulls to", kAngle, j.rest_rpy);
}

static void VisitFields(FieldVisitor& v, PlanarJoint& j) {
  v.Number({.key = "linear_damping",
            .doc = "force per speed",
            .required = false,
            .dimension = kLinearDamping,
            .range = kNonNegative},
           j.linear_damping);
  v.Number({.key = "angular_damping",
            .doc = "torque per angular speed",
            .required = false,
            .dimension = kAngularDamping,
            .range = kNonNegative},
           j.angular_damping);
}

static void VisitFields(FieldVisitor&, FreeJoint&) {}

static void VisitFields(FieldVisitor& v, Attachment& a) {
  v.Numbers({.key = "point", .doc = "in the parent, where mesh and cage are as on file", .dimension = kLength},
            a.point);
}

void VisitFields(FieldVisitor& v, Joint& j) {
  v.OneOf({.key = "type", .doc = "how B moves relative to J"}, j.kind,
          {"fixed", "prescribed", "revolute", "prismatic", "ball", "planar", "free"});
  VisitVector(v, "position", "of Jo in the parent", kLength, j.position);
  VisitVector(v, "orientation_rpy", "of J in the parent: roll, pitch, yaw", kAngle, j.orientation_rpy);
  v.OptionalStruct({.key = "attachment",
                    .doc = "point of a designed parent with whose mesh the joint moves; without it Jo",
                    .required = false},
                   j.attachment);
}

// ---- Initial states -----------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, RevoluteState& s) {
  v.Number({.key = "angle", .doc = "of B in J", .required = false, .dimension = kAngle}, s.angle);
  v.Number({.key = "rate", .doc = "of B in J", .required = false, .dimension = kAngularSpeed}, s.rate);
}

static void VisitFields(FieldVisitor& v, PrismaticState& s) {
  v.Number({.key = "displacement", .doc = "along the axis", .required = false, .dimension = kLength}, s.displacement);
  v.Number({.key = "speed", .doc = "along the axis", .required = false, .dimension = kSpeed}, s.speed);
}

static void VisitFields(FieldVisitor& v, BallState& s) {
  VisitVector(v, "orientation_rpy", "of B in J: roll, pitch, yaw", kAngle, s.orientation_rpy);
  VisitVector(v, "angular_velocity", "of B in J", kAngularSpeed, s.angular_velocity);
}

static void VisitFields(FieldVisitor& v, PlanarState& s) {
  VisitVector(v, "position", "of Bo in J: x, y", kLength, s.position);
  v.Number({.key = "angle", .doc = "of B about Jz", .required = false, .dimension = kAngle}, s.angle);
  VisitVector(v, "velocity", "of Bo in J: x, y", kSpeed, s.velocity);
  v.Number({.key = "angular_velocity", .doc = "of B about Jz", .required = false, .dimension = kAngularSpeed},
           s.angular_velocity);
}

static void VisitFields(FieldVisitor& v, FreeState& s) {
  VisitVector(v, "position", "of Bo in J", kLength, s.position);
  VisitVector(v, "orientation_rpy", "of B in J: roll, pitch, yaw", kAngle, s.orientation_rpy);
  VisitVector(v, "velocity", "of Bo in J", kSpeed, s.velocity);
  VisitVector(v, "angular_velocity", "of B in J", kAngularSpeed, s.angular_velocity);
}

static string_view DescribeState(const RevoluteJoint&) { return "state of a revolute joint at time 0"; }
static string_view DescribeState(const PrismaticJoint&) { return "state of a prismatic joint at time 0"; }
static string_view DescribeState(const BallJoint&) { return "state of a ball joint at time 0"; }
static string_view DescribeState(const PlanarJoint&) { return "state of a planar joint at time 0"; }
static string_view DescribeState(const FreeJoint&) { return "state of a free joint at time 0"; }

void VisitInitialState(FieldVisitor& v, JointKind& kind) {
  std::visit(
      [&v](auto& joint) {
        if constexpr (requires { joint.initial; }) {
          v.Struct({.key = "initial", .doc = DescribeState(joint), .required = false}, joint.initial);
        }
      },
      kind);
}

}  // namespace knap
