// CMA-ES over a box, plain or with points along gradients [Hansen 2016, The CMA Evolution Strategy: A Tutorial].
//
// In y, where the box's sides are [0, 1]: a generation is kGeneration points m + sigma C^½ n_k, n_k standard normal.
// Ranked by value the better half moves m, sigma and C by the tutorial's rules. Beyond the box f goes on as its mirror
// image, so that a bound is no edge to the search. Points that are refused count as worst and move nothing.
//
// With gradients two points of a generation are placed and not drawn: √n and √n/4 standard deviations along
//
//   −C g/√(gᵀ C g),   g the mean over the last generation's gradients, each cut to the median of their lengths
//
// [after Hansen 2011, Injecting external solutions into CMA-ES]. Where the gradients lead somewhere these points are
// selected and the search follows them; where they lead astray it loses an eighth of its samples and nothing else.
//
// sigma begins at first_step. A generation's points are asked for at once. Ends where the best value of ten generations
// has changed by less than the value tolerance, or no coordinate spreads over the step tolerance.
#pragma once

#include <string>

#include "coordinator/optimizer/bounded_minimizer.h"

namespace knap {

inline constexpr int kGeneration = 16;

inline constexpr const char* kEvolution = "CMA_ES";
inline constexpr const char* kEvolutionAlongGradient = "CMA_ES_GRADIENT";

bool IsEvolutionStrategy(const std::string& algorithm);

// As Minimize, which has checked its arguments; options.algorithm is one of the two.
MinimizerResult MinimizeByEvolution(const Objective& f, const MinimizerProblem& problem,
                                    const MinimizerOptions& options);

}  // namespace knap
