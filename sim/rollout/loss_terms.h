// Losses and success tests on a trajectory, with the cotangents they put on its states.
//
// A crossing happens between two states; position and velocity of both give a cubic (Hermite) path, whose crossing time
// is solved for and differentiated: with c = at the watched coordinate and x the one along the opening,
//
//   s*: Y(s*) = at,   x~ = X(s*),   dx~ = Σ H_i(s*) dx_i − X'(s*)/Y'(s*) Σ H_i(s*) dy_i
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/integrators/simulate.h"
#include "sim/scenarios/scene.h"

namespace knap {

// World position and velocity of one body's origin over all states of a trajectory.
struct BodyPath {
  int body = -1;
  std::vector<double> time;
  std::vector<Eigen::Vector3d> p_W;
  std::vector<Eigen::Vector3d> v_W;
  std::vector<int> state_of_step;
};
BodyPath TraceBody(const Trajectory& trajectory, int body, Dynamics* dynamics);

struct Crossing {
  int state = 0;        // the crossing lies between states `state` and `state + 1`
  double fraction = 0;  // s* in [0, 1]
  double time = 0.0;    // [s]
  double x = 0.0;       // coordinate along the opening [m]
  double dx_ds = 0.0;
  double dy_ds = 0.0;
};

// First passage of coordinate `axis` through `at`, none if it never passes.
std::optional<Crossing> FindCrossing(const BodyPath& path, const Opening& opening);

// Value of a term; cotangents are added to *out when not null.
double EvaluateCrossingLoss(const CrossingLoss& loss, const BodyPath& path, std::vector<StateCotangent>* out);
// `reference` holds the path at the reference parameters.
double EvaluatePositionMatch(const PositionMatchLoss& loss, double step, const BodyPath& path,
                             const BodyPath& reference, std::vector<StateCotangent>* out);

bool CrossesInside(const Opening& opening, const BodyPath& path);

}  // namespace knap
