// The height of a rope's centre of mass, h = −ĝ·p, ĝ the direction of gravity, p = Σ m p_WBcm / Σ m over its links: its
// path, its squared distance from another path, and whether the rope is held at the end.
#pragma once

#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Heights [m] at each sample time of a loss.
std::vector<double> TraceHeight(const HeightLoss& loss, double step, const SceneModel& model,
                                const Trajectory& trajectory, Dynamics* dynamics);

// Values of the terms; `reference` as TraceHeight makes it. Cotangents are added to *out when not null.
double EvaluateHeightMatch(const HeightLoss& loss, double step, const SceneModel& model, const Trajectory& trajectory,
                           const std::vector<double>& reference, Dynamics* dynamics, std::vector<StateCotangent>* out);
// h' = −ĝ·X_WB(t) X_WB(from)⁻¹ p(from), B the body that is to carry the rope.
double EvaluateHeightHold(const HeightHoldLoss& loss, double step, const SceneModel& model,
                          const Trajectory& trajectory, Dynamics* dynamics, std::vector<StateCotangent>* out);

bool HoldsRopeAtEnd(const HoldsRope& test, const Scene& scene, const SceneModel& model, const Trajectory& trajectory,
                    Dynamics* dynamics);

}  // namespace knap
