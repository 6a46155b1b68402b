#include "sim/rollout/conditions.h"

#include <algorithm>
#include <optional>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/rollout/signal_crossing.h"

namespace knap {
namespace {

constexpr double kRounding = 1e-9;  // [s], of times that a person wrote

class WithinEvaluation {
 public:
  WithinEvaluation(const Within& within, const Watched& watched) : within_(within), watched_(watched) {
    for (const std::string& name : within.signals) signals_.push_back(watched.signals.Find(name));
  }

  bool Evaluate() const {
    return std::visit(
        Overloaded{[&](const AtEnd&) { return IsTrueAt(watched_.track.last_state()); },
                   [&](const AtTime& at) { return IsTrueAt(watched_.track.FindState(at.time)); },
                   [&](const Ever& w) { return FindLongest(w.from, w.until).any; },
                   [&](const Always& w) {
                     const Span span = FindLongest(w.from, w.until);
                     return span.any && span.all;  // of no state nothing is known
                   },
                   [&](const Lasting& w) { return FindLongest(w.from, w.until).longest >= w.duration - kRounding; },
                   [&](const WhenCrossing& w) { return IsTrueAtCrossing(w.crossing); }},
        within_.when);
  }

 private:
  bool IsInside(double value) const { return value > within_.above && value < within_.below; }

  bool IsTrueAt(int k) const {
    const Moment at = watched_.track.At(k);
    return std::all_of(signals_.begin(), signals_.end(),
                       [&](const SignalPointer& signal) { return IsInside(signal->Calc(at)); });
  }

  bool IsTrueAtCrossing(const SignalCrossing& crossing) const {
    const CrossingFinder finder(watched_.signals.Find(crossing.signal), crossing.at, &watched_.track);
    const std::optional<CrossingPlace> place = finder.Find();
    return place && std::all_of(signals_.begin(), signals_.end(),
                                [&](const SignalPointer& signal) { return IsInside(finder.CalcAt(*place, *signal)); });
  }

  // Over the states of a span, stages within steps left out.
  struct Span {
    bool any = false;
    bool all = true;
    double longest = -1.0;  // time without a break [s]; negative: at no state
  };
  Span FindLongest(double from, double until) const {
    const RolloutTrack& track = watched_.track;
    const double end = until == 0.0 ? watched_.rollout.horizon : until;
    Span span;
    bool lasts = false;
    double since = 0.0;
    for (int k = 0; k < track.size(); ++k) {
      const double time = track.time(k);
      if (track.IsStage(k) || time < from - kRounding || time > end + kRounding) continue;
      if (!IsTrueAt(k)) {
        span.all = false;
        lasts = false;
        continue;
      }
      span.any = true;
      if (!lasts) since = time;
      lasts = true;
      span.longest = std::max(span.longest, time - since);
    }
    return span;
  }

  const Within& within_;
  const Watched& watched_;
  std::vector<SignalPointer> signals_;
};

}  // namespace

bool Holds(const Condition& condition, const Watched& watched) {
  const auto holds = [&](const Condition& part) { return Holds(part, watched); };
  return std::visit(Overloaded{[&](const Within& within) { return WithinEvaluation(within, watched).Evaluate(); },
                               [&](const AllOf& c) { return std::all_of(c.of.begin(), c.of.end(), holds); },
                               [&](const AnyOf& c) { return std::any_of(c.of.begin(), c.of.end(), holds); },
                               [&](const NoneOf& c) { return std::none_of(c.of.begin(), c.of.end(), holds); }},
                    condition.kind);
}

}  // namespace knap
