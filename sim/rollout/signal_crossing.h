// Where a signal y crosses a value between two states, and what other signals are there.
//
// Between two states a signal with a rate follows the cubic (Hermite) curve through both values with their rates,
// another one a straight line. The crossing s* is solved for and differentiated:
//
//   s* in [0, 1]: Y(s*) = at,   x~ = X(s*),   dx~ = Σ H_i(s*) dx_i − X'(s*)/Y'(s*) Σ H_i(s*) dy_i
#pragma once

#include <optional>

#include "sim/rollout/rollout_track.h"

namespace knap {

struct CrossingPlace {
  int state = 0;          // the crossing lies between states `state` and `state + 1`
  double fraction = 0.0;  // s* in [0, 1]
  double time = 0.0;      // [s]
};

class CrossingFinder {
 public:
  CrossingFinder(SignalPointer signal, double at, RolloutTrack* track);

  // The first passage through the value, in either direction; none if it never passes.
  std::optional<CrossingPlace> Find() const;

  double CalcAt(const CrossingPlace& place, const SignalFunction& other) const;
  // What the cotangent `bar` of CalcAt puts on both states, by way of s* included.
  void PullBack(const CrossingPlace& place, const SignalFunction& other, double bar, SignalCotangents* out) const;

 private:
  SignalPointer signal_;
  double at_;
  RolloutTrack* track_;
};

}  // namespace knap
