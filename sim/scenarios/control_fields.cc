#include "sim/scenarios/control_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {

using std::string_view;

static constexpr string_view kSquashes[] = {"tanh", "none"};
static constexpr Range kLayer{1.0, 1000.0};

static void VisitActuators(FieldVisitor& v, std::vector<std::string>& actuators) {
  v.LeafList({.key = "actuators", .doc = "that are driven: bodies whose joints have one"}, actuators, 1,
             [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kBody}, name); });
}

static void VisitInterval(FieldVisitor& v, double& interval) {
  v.Number({.key = "interval",
            .doc = "for which a control is held: a whole number of steps, and the horizon a whole number of intervals",
            .dimension = kTime,
            .range = kPositive},
           interval);
}

void VisitFields(FieldVisitor& v, Controls& c) {
  VisitActuators(v, c.actuators);
  VisitInterval(v, c.interval);
  v.EnumField(
      {.key = "squash", .doc = "from a control to its actuator's command, which lies from -1 to 1", .required = false},
      c.squash, kSquashes);
  v.Number({.key = "initial", .doc = "value of every control", .required = false}, c.initial);
  v.Number({.key = "lower", .doc = "least value", .required = false}, c.lower);
  v.Number({.key = "upper", .doc = "largest value", .required = false}, c.upper);
}

// ---- Observations -------------------------------------------------------------------------------------------------

// The network's input is (what is observed − offset)/scale.
template <class Observation>
static void VisitScale(FieldVisitor& v, const Dimension& dimension, Observation& o) {
  v.Number({.key = "offset", .doc = "what counts as 0", .required = false, .dimension = dimension}, o.offset);
  v.Number({.key = "scale",
            .doc = "what counts as 1, from the offset",
            .required = false,
            .dimension = dimension,
            .range = kPositive},
           o.scale);
}

static void VisitJoint(FieldVisitor& v, string_view doc, std::string& joint) {
  v.Text({.key = "joint", .doc = doc, .role = TextRole::kBody}, joint);
}

static constexpr string_view kRevolute = "of the revolute joint of this body";
static constexpr string_view kPrismatic = "of the prismatic joint of this body";

static void VisitFields(FieldVisitor& v, AngleObservation& o) {
  VisitJoint(v, kRevolute, o.joint);
  VisitScale(v, kAngle, o);
}

static void VisitFields(FieldVisitor& v, RateObservation& o) {
  VisitJoint(v, kRevolute, o.joint);
  VisitScale(v, kAngularSpeed, o);
}

static void VisitFields(FieldVisitor& v, DisplacementObservation& o) {
  VisitJoint(v, kPrismatic, o.joint);
  VisitScale(v, kLength, o);
}

static void VisitFields(FieldVisitor& v, SpeedObservation& o) {
  VisitJoint(v, kPrismatic, o.joint);
  VisitScale(v, kSpeed, o);
}

static void VisitPoint(FieldVisitor& v, std::string& body, Eigen::Vector3d& point) {
  v.Text({.key = "body", .doc = "that is observed", .role = TextRole::kBody}, body);
  VisitVector(v, "point", "in B; on a designed body it moves with the mesh", kLength, point);
}

static void VisitFrame(FieldVisitor& v, std::string& in) {
  v.Text({.key = "in", .doc = "whose frame the axis is of", .required = false, .role = TextRole::kBodyOrWorld}, in);
}

static void VisitFields(FieldVisitor& v, PositionObservation& o) {
  VisitPoint(v, o.body, o.point);
  VisitFrame(v, o.in);
  VisitAxis(v, "axis", "along which the coordinate is", o.axis);
  VisitScale(v, kLength, o);
}

static void VisitFields(FieldVisitor& v, VelocityObservation& o) {
  VisitPoint(v, o.body, o.point);
  VisitAxis(v, "axis", "of the world", o.axis);
  VisitScale(v, kSpeed, o);
}

static void VisitFields(FieldVisitor& v, DirectionObservation& o) {
  v.Text({.key = "body", .doc = "that is observed", .role = TextRole::kBody}, o.body);
  VisitAxis(v, "of", "axis of the body whose direction it is", o.of);
  VisitFrame(v, o.in);
  VisitAxis(v, "axis", "along which the component is", o.axis);
  VisitScale(v, kDimensionless, o);
}

static void VisitFields(FieldVisitor& v, AngularVelocityObservation& o) {
  v.Text({.key = "body", .doc = "that is observed", .role = TextRole::kBody}, o.body);
  VisitAxis(v, "axis", "of the world", o.axis);
  VisitScale(v, kAngularSpeed, o);
}

static void VisitFields(FieldVisitor& v, TimeObservation& o) { VisitScale(v, kTime, o); }

static void VisitFields(FieldVisitor& v, NumberObservation& o) {
  v.Text({.key = "key", .doc = "of a number that may vary, as in `variation`", .role = TextRole::kNumericKey}, o.key);
  v.Number({.key = "offset", .doc = "what counts as 0", .required = false, .dimension_of = &o.key}, o.offset);
  v.Number({.key = "scale",
            .doc = "what counts as 1, from the offset",
            .required = false,
            .dimension_of = &o.key,
            .range = kPositive},
           o.scale);
}

static void VisitFields(FieldVisitor& v, PolicyObservation& o) {
  v.OneOf({.key = "type",
           .doc = "one number: a joint's angle, rate, displacement or speed; a coordinate of a body's point in "
                  "another body's frame, or of its velocity; a component of the direction of a body's axis, which "
                  "tells orientations without singularities, or of its angular velocity; the time; a number of the "
                  "scene, such as a goal"},
          o,
          {"angle", "rate", "displacement", "speed", "position", "velocity", "direction", "angular_velocity", "time",
           "number"});
}

// ---- Policy -------------------------------------------------------------------------------------------------------

static void VisitFields(FieldVisitor& v, RandomWeights& w) {
  v.Integer({.key = "seed", .doc = "of the weights", .required = false, .range = kSeed}, w.seed);
  v.Number({.key = "scale",
            .doc = "standard deviation of a unit's weights, times the root of how many inputs it has; biases are 0",
            .required = false,
            .range = kNonNegative},
           w.scale);
}

static void VisitFields(FieldVisitor& v, WeightsFile& w) {
  v.Text({.key = "file", .doc = "as `knap learn` writes it to `policy/`", .role = TextRole::kFile}, w.file);
}

static void VisitFields(FieldVisitor& v, InitialWeights& initial) {
  v.OneOf({.key = "type", .doc = "drawn at random, or read from a file"}, initial, {"random", "file"});
}

void VisitFields(FieldVisitor& v, Policy& p) {
  VisitActuators(v, p.actuators);
  VisitInterval(v, p.interval);
  v.StructList({.key = "observations", .doc = "the network's inputs, at the start of each interval"}, p.observations,
               1);
  v.LeafList({.key = "hidden", .doc = "units of each hidden layer, with tanh; [] for a linear policy"}, p.hidden, 0,
             [](FieldVisitor& w, std::int64_t& units) { w.Integer({.range = kLayer}, units); });
  v.EnumField({.key = "squash",
               .doc = "of the outputs, the actuators' commands; none only where position actuators have limits of "
                      "their own",
               .required = false},
              p.squash, kSquashes);
  v.Struct({.key = "initial", .doc = "weights from which learning starts"}, p.initial);
  v.Number({.key = "lower", .doc = "least value of a weight", .required = false}, p.lower);
  v.Number({.key = "upper", .doc = "largest value of a weight", .required = false}, p.upper);
}

}  // namespace knap
