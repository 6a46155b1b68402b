// The damping of a rope's joints in one implicit step, apart from Bullet's own: explicit torques would need steps of
// some 10 µs, since links are light about their long axis.
//
//   I_i w_i' + h d Σ_j (w_i' − w_j') = I_i w_i       j the neighbours of link i; I_i about its centre, in W
//
// A block-tridiagonal system, solved exactly. It keeps the angular momentum of the whole and never adds energy.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace knap {

// h d [N·m·s²/rad]; `inertia` and `*w` of each link in order, in any one unit of length squared that damping shares.
void DampJoints(double damping_step, const std::vector<Eigen::Matrix3d>& inertia, std::vector<Eigen::Vector3d>* w);

}  // namespace knap
