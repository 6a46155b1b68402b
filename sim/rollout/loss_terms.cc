#include "sim/rollout/loss_terms.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>

#include "sim/math/check.h"
#include "sim/math/overloaded.h"
#include "sim/rollout/signal_crossing.h"
#include "sim/signals/timed_choice.h"

namespace knap {
namespace {

// A function's value and slope.
struct Curve {
  double value = 0.0;
  double slope = 0.0;
};

Curve CalcShape(TermShape shape, double e) {
  const double e2 = e * e;
  switch (shape) {
    case TermShape::kSquare:
      return {e2, 2.0 * e};
    case TermShape::kAbsolute:
      return {e, e > 0.0 ? 1.0 : 0.0};
    case TermShape::kLog:
      return {std::log1p(e2), 2.0 * e / (1.0 + e2)};
    case TermShape::kSaturating:
      return {e2 / (1.0 + e2), 2.0 * e / ((1.0 + e2) * (1.0 + e2))};
  }
  return {};
}

// What a difference from the target costs.
Curve CalcCost(const Term& term, double difference) {
  double sign = difference < 0.0 ? -1.0 : 1.0;
  if (term.side != Side::kBoth) sign = term.side == Side::kAbove ? 1.0 : -1.0;
  const double e = std::max(0.0, sign * difference - term.margin) / term.scale;
  const Curve shape = CalcShape(term.shape, e);
  return {shape.value, shape.slope * sign / term.scale};
}

// The states at which a term looks; none of a crossing.
std::vector<int> ListStates(const Term& term, const Watched& watched) {
  std::vector<int> states;
  std::visit(Overloaded{[&](const AtEnd&) { states.push_back(watched.track.last_state()); },
                        [&](const AtTime& at) { states.push_back(watched.track.FindState(at.time)); },
                        [&](const OverSamples& samples) {
                          const double until = samples.until == 0.0 ? watched.rollout.horizon : samples.until;
                          const double last = until * (1.0 + 1e-9);
                          for (int n = 1; samples.from + n * samples.every <= last; ++n) {
                            states.push_back(watched.track.FindState(samples.from + n * samples.every));
                          }
                        },
                        [](const AtCrossing&) {}},
             term.when);
  return states;
}

// The sum over the term's signals of what they cost, each read and pulled back by the functions given.
class TermEvaluation {
 public:
  TermEvaluation(const Term& term, const Watched& watched, const std::vector<double>& reference)
      : term_(term), watched_(watched), reference_(reference) {
    for (const std::string& name : term.signals) signals_.push_back(watched.signals.Find(name));
    if (const auto* target = std::get_if<SignalTarget>(&term.target)) target_ = watched.signals.Find(target->signal);
  }

  using Read = std::function<double(const SignalFunction&)>;
  using Pull = std::function<void(const SignalFunction&, double bar)>;

  // `moment` counts the term's moments, for the reference.
  double Sum(double time, std::size_t moment, const Read& read) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < signals_.size(); ++i) sum += CalcCost(term_, Differ(i, time, moment, read)).value;
    return sum;
  }

  void PullBack(double time, std::size_t moment, double bar, const Read& read, const Pull& pull) const {
    for (std::size_t i = 0; i < signals_.size(); ++i) {
      const double bar_difference = bar * CalcCost(term_, Differ(i, time, moment, read)).slope;
      pull(*signals_[i], bar_difference);
      if (target_) pull(*target_, -bar_difference);
    }
  }

 private:
  double Differ(std::size_t i, double time, std::size_t moment, const Read& read) const {
    const double value = read(*signals_[i]);
    return std::visit(
        Overloaded{[&](const NumberTarget& target) { return value - target.value; },
                   [&](const ScheduleTarget& target) { return value - ChooseAfter(target.values, time).value; },
                   [&](const SignalTarget&) { return value - read(*target_); },
                   [&](const ReferenceTarget&) { return value - reference_[moment * signals_.size() + i]; }},
        term_.target);
  }

  const Term& term_;
  const Watched& watched_;
  const std::vector<double>& reference_;
  std::vector<SignalPointer> signals_;
  SignalPointer target_;
};

double EvaluateOverStates(const Term& term, const TermEvaluation& evaluation, const Watched& watched,
                          SignalCotangents* out) {
  const std::vector<int> states = ListStates(term, watched);
  const auto* samples = std::get_if<OverSamples>(&term.when);
  const Reduction reduce = samples == nullptr ? Reduction::kSum : samples->reduce;
  std::vector<double> values;
  for (std::size_t m = 0; m < states.size(); ++m) {
    const Moment at = watched.track.At(states[m]);
    values.push_back(evaluation.Sum(at.time, m, [&](const SignalFunction& signal) { return signal.Calc(at); }));
  }
  if (values.empty()) return 0.0;
  std::vector<double> weights(values.size(), term.weight);
  if (reduce == Reduction::kMean) weights.assign(values.size(), term.weight / static_cast<double>(values.size()));
  if (reduce == Reduction::kLargest || reduce == Reduction::kLeast) {
    const auto best = reduce == Reduction::kLargest ? std::max_element(values.begin(), values.end())
                                                    : std::min_element(values.begin(), values.end());
    weights.assign(values.size(), 0.0);
    weights[static_cast<std::size_t>(best - values.begin())] = term.weight;
  }
  double sum = 0.0;
  for (std::size_t m = 0; m < states.size(); ++m) {
    sum += weights[m] * values[m];
    if (out == nullptr || weights[m] == 0.0) continue;
    const Moment at = watched.track.At(states[m]);
    evaluation.PullBack(
        at.time, m, weights[m], [&](const SignalFunction& signal) { return signal.Calc(at); },
        [&](const SignalFunction& signal, double bar) { signal.PullBack(at, bar, out); });
  }
  return sum;
}

double EvaluateAtCrossing(const Term& term, const AtCrossing& when, const TermEvaluation& evaluation,
                          const Watched& watched, SignalCotangents* out) {
  const SignalPointer y = watched.signals.Find(when.crossing.signal);
  const CrossingFinder finder(y, when.crossing.at, &watched.track);
  const std::optional<CrossingPlace> place = finder.Find();
  if (place) {
    const auto read = [&](const SignalFunction& signal) { return finder.CalcAt(*place, signal); };
    if (out != nullptr) {
      evaluation.PullBack(place->time, 0, term.weight, read, [&](const SignalFunction& signal, double bar) {
        if (bar != 0.0) finder.PullBack(*place, signal, bar, out);
      });
    }
    return term.weight * evaluation.Sum(place->time, 0, read);
  }
  const Moment end = watched.track.At(watched.track.last_state());
  const auto read = [&](const SignalFunction& signal) { return signal.Calc(end); };
  const double v = evaluation.Sum(end.time, 0, read);
  const double d = when.crossing.at - y->Calc(end);
  const double S2 = when.never_scale * when.never_scale;
  const double fade = S2 / (S2 + d * d);
  if (out != nullptr) {
    evaluation.PullBack(end.time, 0, term.weight * fade, read,
                        [&](const SignalFunction& signal, double bar) { signal.PullBack(end, bar, out); });
    y->PullBack(end, -2.0 * term.weight * d * (when.never_cost - v) * fade / (S2 + d * d), out);
  }
  return term.weight * fade * (v + when.never_cost * d * d / S2);
}

}  // namespace

std::vector<double> TraceTerm(const Term& term, const Watched& watched) {
  std::vector<double> values;
  for (const int k : ListStates(term, watched)) {
    const Moment at = watched.track.At(k);
    for (const std::string& name : term.signals) values.push_back(watched.signals.Find(name)->Calc(at));
  }
  return values;
}

double EvaluateTerm(const Term& term, const Watched& watched, const std::vector<double>& reference,
                    SignalCotangents* out) {
  const TermEvaluation evaluation(term, watched, reference);
  if (const auto* crossing = std::get_if<AtCrossing>(&term.when)) {
    return EvaluateAtCrossing(term, *crossing, evaluation, watched, out);
  }
  return EvaluateOverStates(term, evaluation, watched, out);
}

double EvaluateTerms(const std::vector<Term>& terms, const Watched& watched,
                     const std::vector<std::vector<double>>& references, SignalCotangents* out) {
  double loss = 0.0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    loss += EvaluateTerm(terms[i], watched, references.empty() ? std::vector<double>() : references[i], out);
  }
  return loss;
}

}  // namespace knap
