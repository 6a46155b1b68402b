// What is wanted of a rollout, all of it in signals (signals.h): the terms of losses, and the conditions of success.
#pragma once

#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace knap {

// The first moment at which a signal crosses a value, in either direction.
struct SignalCrossing {
  std::string signal;
  double at = 0.0;  // in the signal's unit
};

// ---- Terms of a loss ------------------------------------------------------------------------------------------------

struct AtEnd {};

struct AtTime {
  double time = 0.0;  // [s], a whole number of steps
};

enum class Reduction { kSum, kMean, kLargest, kLeast };

// At t = from + n·every, n = 1 …, as long as t ≤ until.
struct OverSamples {
  double every = 0.0;  // [s], a whole number of steps
  double from = 0.0;   // [s], likewise
  double until = 0.0;  // [s]; 0: the horizon
  Reduction reduce = Reduction::kSum;
};

// A rollout without a crossing pays, of its end, S²(v + never_cost·d²/S²)/(S² + d²) in place of v = Σ shape, d what the
// crossing signal is short of its value, S = never_scale: continuous with a crossing at d = 0, and levelling off.
struct AtCrossing {
  SignalCrossing crossing;
  double never_cost = 1.0;   // [-]
  double never_scale = 1.0;  // in the crossing signal's unit
};

using TermTime = std::variant<AtEnd, AtTime, OverSamples, AtCrossing>;

struct NumberTarget {
  double value = 0.0;  // in the signals' unit
};

struct TimedValue {
  double after = 0.0;  // time after which it counts; the first one always does [s]
  double value = 0.0;
};

struct ScheduleTarget {
  std::vector<TimedValue> values;  // ascending
};

struct SignalTarget {
  std::string signal;
};

// The signal itself at the same moment of the reference trajectory; in distillation alone.
struct ReferenceTarget {};

using Target = std::variant<NumberTarget, ScheduleTarget, SignalTarget, ReferenceTarget>;

// Of e: e², |e|, log(1 + e²), e²/(1 + e²).
enum class TermShape { kSquare, kAbsolute, kLog, kSaturating };

enum class Side { kBoth, kAbove, kBelow };

// weight · reduce_t Σ_i shape(e_i), e_i = max(0, |s_i − target| − margin)/scale; of one side, ±(s_i − target) in place
// of the absolute value.
struct Term {
  std::vector<std::string> signals;  // of one dimension
  TermTime when;
  Target target;
  TermShape shape = TermShape::kSquare;
  Side side = Side::kBoth;
  double margin = 0.0;  // in the signals' unit
  double scale = 1.0;   // likewise
  double weight = 1.0;
};

struct Loss {
  std::vector<Term> task;
  std::vector<Term> distillation;
};

// ---- Success --------------------------------------------------------------------------------------------------------

// Of the states from `from` to `until` (0: the horizon): one of them; all; all of some span that lasts `duration`.
struct Ever {
  double from = 0.0;
  double until = 0.0;
};
struct Always {
  double from = 0.0;
  double until = 0.0;
};
struct Lasting {
  double duration = 0.0;
  double from = 0.0;
  double until = 0.0;
};

// Without a crossing the condition does not hold.
struct WhenCrossing {
  SignalCrossing crossing;
};

using ConditionTime = std::variant<AtEnd, AtTime, Ever, Always, Lasting, WhenCrossing>;

// above < s < below for every one of the signals.
struct Within {
  std::vector<std::string> signals;  // of one dimension
  double above = -std::numeric_limits<double>::infinity();
  double below = std::numeric_limits<double>::infinity();
  ConditionTime when;
};

struct Condition;

struct AllOf {
  std::vector<Condition> of;
};
struct AnyOf {
  std::vector<Condition> of;
};
struct NoneOf {
  std::vector<Condition> of;
};

struct Condition {
  std::variant<Within, AllOf, AnyOf, NoneOf> kind;
};

}  // namespace knap
