#include "sim/scenarios/objective_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {

using std::string_view;

namespace {

const std::string& GetFirst(const std::vector<std::string>& signals) {
  static const std::string kNone;
  return signals.empty() ? kNone : signals.front();
}

void VisitSignals(FieldVisitor& v, string_view doc, std::vector<std::string>& signals) {
  v.LeafList({.key = "signals", .doc = doc}, signals, 1,
             [](FieldVisitor& w, std::string& name) { w.Text({.role = TextRole::kSignal}, name); });
}

void VisitTime(FieldVisitor& v, string_view key, string_view doc, double& time, const Range& range = kNonNegative) {
  v.Number({.key = key, .doc = doc, .required = false, .dimension = kTime, .range = range}, time);
}

void VisitCrossing(FieldVisitor& v, const SignalDimensions& signals, SignalCrossing& c) {
  v.Text({.key = "signal", .doc = "that crosses", .role = TextRole::kSignal}, c.signal);
  v.Number(signals.With({.key = "at", .doc = "value that it crosses, the first time"}, c.signal), c.at);
}

// ---- When -----------------------------------------------------------------------------------------------------------

void VisitWhen(FieldVisitor&, const SignalDimensions&, AtEnd&) {}

void VisitWhen(FieldVisitor& v, const SignalDimensions&, AtTime& w) {
  v.Number({.key = "time", .doc = "a whole number of steps", .dimension = kTime, .range = kNonNegative}, w.time);
}

void VisitWhen(FieldVisitor& v, const SignalDimensions&, OverSamples& w) {
  v.Number({.key = "every", .doc = "between samples, a whole number of steps", .dimension = kTime, .range = kPositive},
           w.every);
  VisitTime(v, "from", "time after which samples count, a whole number of steps", w.from);
  VisitTime(v, "until", "the last sample's time, at most; 0: the horizon", w.until);
  static constexpr string_view kReductions[] = {"sum", "mean", "largest", "least"};
  v.EnumField({.key = "reduce", .doc = "over the samples", .required = false}, w.reduce, kReductions);
}

void VisitWhen(FieldVisitor& v, const SignalDimensions& signals, AtCrossing& w) {
  VisitCrossing(v, signals, w.crossing);
  v.Number({.key = "never_cost",
            .doc = "what a rollout pays that stays far from crossing, before the weight",
            .required = false,
            .range = kNonNegative},
           w.never_cost);
  v.Number(signals.With({.key = "never_scale",
                         .doc = "how far from crossing half of it is paid",
                         .required = false,
                         .range = kPositive},
                        w.crossing.signal),
           w.never_scale);
}

void VisitSpan(FieldVisitor& v, double& from, double& until) {
  VisitTime(v, "from", "time from which it is looked at", from);
  VisitTime(v, "until", "time until which it is; 0: the horizon", until);
}

void VisitWhen(FieldVisitor& v, const SignalDimensions&, Ever& w) { VisitSpan(v, w.from, w.until); }
void VisitWhen(FieldVisitor& v, const SignalDimensions&, Always& w) { VisitSpan(v, w.from, w.until); }

void VisitWhen(FieldVisitor& v, const SignalDimensions&, Lasting& w) {
  v.Number({.key = "duration", .doc = "for which it holds without a break", .dimension = kTime, .range = kPositive},
           w.duration);
  VisitSpan(v, w.from, w.until);
}

void VisitWhen(FieldVisitor& v, const SignalDimensions& signals, WhenCrossing& w) {
  VisitCrossing(v, signals, w.crossing);
}

// ---- Terms ----------------------------------------------------------------------------------------------------------

void VisitTarget(FieldVisitor& v, const SignalDimensions& signals, const std::string& signal, NumberTarget& t) {
  v.Number(signals.With({.key = "value", .doc = "that is wanted"}, signal), t.value);
}

void VisitTarget(FieldVisitor& v, const SignalDimensions& signals, const std::string& signal, ScheduleTarget& t) {
  v.StructList({.key = "values", .doc = "by time"}, t.values, 1, [&signals, &signal](FieldVisitor& w, TimedValue& x) {
    VisitTime(w, "after", "time after which it counts; the first one always does", x.after);
    w.Number(signals.With({.key = "value", .doc = "that is wanted"}, signal), x.value);
  });
}

void VisitTarget(FieldVisitor& v, const SignalDimensions&, const std::string&, SignalTarget& t) {
  v.Text({.key = "signal", .doc = "whose value is wanted, of the same unit", .role = TextRole::kSignal}, t.signal);
}

void VisitTarget(FieldVisitor&, const SignalDimensions&, const std::string&, ReferenceTarget&) {}

void VisitTerm(FieldVisitor& v, const SignalDimensions& signals, Term& t) {
  VisitSignals(v, "of one unit; their shapes are added up", t.signals);
  const std::string& first = GetFirst(t.signals);
  v.Group({.key = "when", .doc = "the moments that count; the end", .required = false}, [&](FieldVisitor& w) {
    w.OneOf({.key = "type",
             .doc = "end: at the horizon; at: at a time; samples: over samples; crossing: when a signal crosses a "
                    "value, interpolated between states"},
            t.when, {"end", "at", "samples", "crossing"},
            [&signals](FieldVisitor& x, auto& when) { VisitWhen(x, signals, when); });
  });
  v.Group({.key = "target", .doc = "what is wanted; 0", .required = false}, [&](FieldVisitor& w) {
    w.OneOf({.key = "type",
             .doc = "number, schedule: given; signal: that of another signal; reference: that of the "
                    "reference trajectory, in distillation"},
            t.target, {"number", "schedule", "signal", "reference"},
            [&signals, &first](FieldVisitor& x, auto& target) { VisitTarget(x, signals, first, target); });
  });
  static constexpr string_view kShapes[] = {"square", "absolute", "log", "saturating"};
  v.EnumField({.key = "shape",
               .doc = "of e, the distance from the target over the scale: e^2, |e|, log(1 + e^2), e^2/(1 + e^2)",
               .required = false},
              t.shape, kShapes);
  static constexpr string_view kSides[] = {"both", "above", "below"};
  v.EnumField({.key = "side", .doc = "of the target that counts", .required = false}, t.side, kSides);
  v.Number(signals.With({.key = "margin",
                         .doc = "distance from the target that costs nothing",
                         .required = false,
                         .range = kNonNegative},
                        first),
           t.margin);
  v.Number(
      signals.With({.key = "scale", .doc = "distance that counts as 1", .required = false, .range = kPositive}, first),
      t.scale);
  v.Number({.key = "weight", .doc = "factor of this term", .required = false, .range = kNonNegative}, t.weight);
}

// ---- Success --------------------------------------------------------------------------------------------------------

void VisitCondition(FieldVisitor& v, const SignalDimensions& signals, Within& c) {
  VisitSignals(v, "of one unit; each of them", c.signals);
  const std::string& first = GetFirst(c.signals);
  v.Number(signals.With({.key = "above", .doc = "lower bound", .required = false}, first), c.above);
  v.Number(signals.With({.key = "below", .doc = "upper bound", .required = false}, first), c.below);
  v.Group({.key = "when", .doc = "the moments that count; the end", .required = false}, [&](FieldVisitor& w) {
    w.OneOf({.key = "type",
             .doc = "end: at the horizon; at: at a time; ever, always: at one or all of the states of a "
                    "span; lasting: at all of them for some duration; crossing: when a signal crosses a "
                    "value, interpolated between states, and not without a crossing"},
            c.when, {"end", "at", "ever", "always", "lasting", "crossing"},
            [&signals](FieldVisitor& x, auto& when) { VisitWhen(x, signals, when); });
  });
}

void VisitConditions(FieldVisitor& v, const SignalDimensions& signals, std::vector<Condition>& of) {
  v.StructList({.key = "of", .doc = "conditions", .recursive = true}, of, 1,
               [&signals](FieldVisitor& w, Condition& condition) { VisitObjective(w, signals, condition); });
}

void VisitCondition(FieldVisitor& v, const SignalDimensions& signals, AllOf& c) { VisitConditions(v, signals, c.of); }
void VisitCondition(FieldVisitor& v, const SignalDimensions& signals, AnyOf& c) { VisitConditions(v, signals, c.of); }
void VisitCondition(FieldVisitor& v, const SignalDimensions& signals, NoneOf& c) { VisitConditions(v, signals, c.of); }

}  // namespace

void VisitObjective(FieldVisitor& v, const SignalDimensions& signals, Loss& loss) {
  const auto visit = [&signals](FieldVisitor& w, Term& term) { VisitTerm(w, signals, term); };
  v.StructList({.key = "task", .doc = "terms, added up", .required = false}, loss.task, 0, visit);
  v.StructList({.key = "distillation", .doc = "terms, added up", .required = false}, loss.distillation, 0, visit);
}

void VisitObjective(FieldVisitor& v, const SignalDimensions& signals, Condition& condition) {
  v.OneOf({.key = "type", .doc = "within: signals lie between bounds; all, any, none: of conditions"}, condition.kind,
          {"within", "all", "any", "none"},
          [&signals](FieldVisitor& w, auto& kind) { VisitCondition(w, signals, kind); });
}

}  // namespace knap
