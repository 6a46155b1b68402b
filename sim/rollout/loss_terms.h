// Terms of a loss on a rollout [objective.h], with the cotangents that they put on it.
#pragma once

#include <vector>

#include "sim/rollout/build_signals.h"
#include "sim/rollout/rollout_track.h"
#include "sim/scenarios/scene.h"

namespace knap {

// What terms look at.
struct Watched {
  const SignalSet& signals;
  RolloutTrack& track;
  const Rollout& rollout;
};

// The term's signals at each of its moments, moment by moment: what it refers to on the reference trajectory. Not of a
// crossing, which has none.
std::vector<double> TraceTerm(const Term& term, const Watched& watched);

// The term's value. `reference`: what TraceTerm said of the reference, where the target is that. Cotangents are added
// to *out when not null.
double EvaluateTerm(const Term& term, const Watched& watched, const std::vector<double>& reference,
                    SignalCotangents* out);

// The sum of all of them. `references`: one a term, or none where no term's target is the reference.
double EvaluateTerms(const std::vector<Term>& terms, const Watched& watched,
                     const std::vector<std::vector<double>>& references, SignalCotangents* out);

}  // namespace knap
