// A rollout as signals, terms and conditions see it, whichever engine simulated it: states of bodies, one by one.
#pragma once

#include "sim/signals/signal_function.h"

namespace knap {

class RolloutTrack : public Track {
 public:
  // States 0 … size() − 1, in the order of their times; the first is the start.
  virtual int size() const = 0;
  virtual double time(int k) const = 0;
  // Whether state k is a stage within a step, at which crossings look but no condition.
  virtual bool IsStage(int k) const = 0;
  // Holds until another state is looked at.
  virtual Moment At(int k) = 0;

  int last_state() const { return size() - 1; }
  double Calc(const SignalFunction& signal, int k) { return signal.Calc(At(k)); }
};

}  // namespace knap
