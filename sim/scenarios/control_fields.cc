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

static void VisitObservation(FieldVisitor& v, const SignalDimensions& signals, Observation& o) {
  v.Text({.key = "signal", .doc = "that is seen, of the present state", .role = TextRole::kSignal}, o.signal);
  v.Number(signals.With({.key = "offset", .doc = "what counts as 0", .required = false}, o.signal), o.offset);
  v.Number(
      signals.With({.key = "scale", .doc = "what counts as 1, from the offset", .required = false, .range = kPositive},
                   o.signal),
      o.scale);
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

void VisitPolicy(FieldVisitor& v, const SignalDimensions& signals, Policy& p) {
  VisitActuators(v, p.actuators);
  VisitInterval(v, p.interval);
  v.StructList(
      {.key = "observations", .doc = "the network's inputs, (signal - offset)/scale at the start of each interval"},
      p.observations, 1, [&signals](FieldVisitor& w, Observation& o) { VisitObservation(w, signals, o); });
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
