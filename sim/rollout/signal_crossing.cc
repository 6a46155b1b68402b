#include "sim/rollout/signal_crossing.h"

#include <cstddef>
#include <utility>

namespace knap {
namespace {

// Weights of the values at both ends and of h times the rates there.
struct Weights {
  double begin, begin_rate, end, end_rate;
};
Weights CalcHermite(double s) {
  return {(1 + 2 * s) * (1 - s) * (1 - s), s * (1 - s) * (1 - s), s * s * (3 - 2 * s), s * s * (s - 1)};
}
Weights CalcHermiteSlope(double s) {
  return {6 * s * s - 6 * s, 3 * s * s - 4 * s + 1, 6 * s - 6 * s * s, 3 * s * s - 2 * s};
}

// A signal between states k and k + 1.
class Segment {
 public:
  Segment(const SignalFunction& signal, int k, RolloutTrack* track) : signal_(signal), k_(k), track_(track) {
    rate_ = signal.MakeRate();
    h_ = track->time(k + 1) - track->time(k);
    begin_ = track->Calc(signal, k);
    if (rate_) begin_rate_ = track->Calc(*rate_, k);
    end_ = track->Calc(signal, k + 1);
    if (rate_) end_rate_ = track->Calc(*rate_, k + 1);
  }

  double Calc(double s) const { return rate_ ? Apply(CalcHermite(s)) : Apply({1.0 - s, 0.0, s, 0.0}); }
  double CalcSlope(double s) const { return rate_ ? Apply(CalcHermiteSlope(s)) : end_ - begin_; }

  void PullBack(double s, double bar, SignalCotangents* out) const {
    const Weights w = rate_ ? CalcHermite(s) : Weights{1.0 - s, 0.0, s, 0.0};
    const double bar_h = bar * (w.begin_rate * begin_rate_ + w.end_rate * end_rate_);
    AddEnd(k_, bar * w.begin, bar * w.begin_rate * h_, -bar_h, out);
    AddEnd(k_ + 1, bar * w.end, bar * w.end_rate * h_, bar_h, out);
  }

 private:
  double Apply(const Weights& w) const {
    return w.begin * begin_ + w.begin_rate * h_ * begin_rate_ + w.end * end_ + w.end_rate * h_ * end_rate_;
  }

  void AddEnd(int k, double bar, double bar_rate, double bar_time, SignalCotangents* out) const {
    const std::size_t before = out->states.size();
    const Moment at = track_->At(k);
    signal_.PullBack(at, bar, out);
    if (rate_) rate_->PullBack(at, bar_rate, out);
    // What another time of the state would mean is known, and the state may move.
    for (std::size_t i = before; i < out->states.size(); ++i) {
      out->states[i].time = out->states[i].clock + (i == before ? bar_time : 0.0);
    }
  }

  const SignalFunction& signal_;
  std::unique_ptr<SignalFunction> rate_;
  int k_;
  RolloutTrack* track_;
  double h_ = 0.0;
  double begin_ = 0.0, end_ = 0.0;
  double begin_rate_ = 0.0, end_rate_ = 0.0;
};

}  // namespace

CrossingFinder::CrossingFinder(SignalPointer signal, double at, RolloutTrack* track)
    : signal_(std::move(signal)), at_(at), track_(track) {}

std::optional<CrossingPlace> CrossingFinder::Find() const {
  const bool from_below = track_->Calc(*signal_, 0) < at_;
  for (int k = 0; k < track_->last_state(); ++k) {
    if ((track_->Calc(*signal_, k + 1) < at_) == from_below) continue;
    // Bisection to rounding: the end values have different sides, so a root exists and is found the same way always.
    const Segment y(*signal_, k, track_);
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double s = 0.5 * (low + high);
      ((y.Calc(s) < at_) == from_below ? low : high) = s;
    }
    CrossingPlace place;
    place.state = k;
    place.fraction = 0.5 * (low + high);
    place.time = track_->time(k) + place.fraction * (track_->time(k + 1) - track_->time(k));
    return place;
  }
  return std::nullopt;
}

double CrossingFinder::CalcAt(const CrossingPlace& place, const SignalFunction& other) const {
  return Segment(other, place.state, track_).Calc(place.fraction);
}

void CrossingFinder::PullBack(const CrossingPlace& place, const SignalFunction& other, double bar,
                              SignalCotangents* out) const {
  const Segment x(other, place.state, track_), y(*signal_, place.state, track_);
  x.PullBack(place.fraction, bar, out);
  y.PullBack(place.fraction, -bar * x.CalcSlope(place.fraction) / y.CalcSlope(place.fraction), out);
}

}  // namespace knap
