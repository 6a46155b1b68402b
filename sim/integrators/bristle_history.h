// Bristles of contacts from state to state: what a step starts from, and their rates (step_formula.h).
//
// A bristle that is not listed at a state is zero there, with its rate.
#pragma once

#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/step_formula.h"

namespace knap {

// Bristles at one state with their rates [m/s], one each.
struct BristleState {
  Bristles bent;
  std::vector<Bristle> rate;
  void Clear() {
    bent.Clear();
    rate.clear();
  }
};

// The base of a step from `now`, `before` the state before it. Bristles of `also` (may be null) are listed too.
void CalcBristleBase(const StepFormula& f, const BristleState& now, const BristleState& before, const Bristles* also,
                     Bristles* base);

// zdot of the bristles that the step has led to.
void CalcBristleRates(const StepFormula& f, const Bristles& base, BristleState* next);

// Cotangents of a state's bristles and rates, in the order of the state's own list.
struct BristleCotangents {
  std::vector<Bristle> bent;
  std::vector<Bristle> rate;
  void Reset(int count) {
    bent.assign(count, Bristle::Zero());
    rate.assign(count, Bristle::Zero());
  }
};

// Of `next`'s rates: adds to those of its bristles, and to bar_base, which lists all of `next`.
void PullBackBristleRates(const StepFormula& f, const Bristles& base, const BristleState& next, BristleCotangents* bar,
                          std::vector<Bristle>* bar_base);

// Of the base: adds to those of `now` and `before`.
void PullBackBristleBase(const StepFormula& f, const Bristles& base, const std::vector<Bristle>& bar_base,
                         const BristleState& now, const BristleState& before, BristleCotangents* bar_now,
                         BristleCotangents* bar_before);

}  // namespace knap
