// Where a body B reaches deepest into the depth field of a body S, and what moves that depth.
//
//   e* = max e(x) over B's surface, or over a round B's axis in the field widened by its radius;   de* = g · dx
//
// x is the place, as a point of B's matter, and dx how it moves as seen from S. Where nothing but B's corners, edges
// and facets holds x, g = ∇e. On the walls of the field's cells, where two or three faces of S are equally near, it is
//
//   g = Σ μ_i ∇e_i,   μ_i ≥ 0,   Σ μ_i = 1,   at right angles to B's edge or facet through x
//
// (the conditions of Karush, Kuhn and Tucker, and the theorem of the envelope), and where the planes themselves move
// de* has Σ μ_i (δd_i − δn_i·x) too. Of several equally deep places one counts, always the same: a body that lies flat
// has a depth without a gradient.
#pragma once

#include <Eigen/Core>
#include <array>

#include "sim/contact/contact_side.h"

namespace knap {

struct DeepestPlace {
  double depth = 0.0;                             // e* [m]; 0 where B does not reach S, and then nothing else holds
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();  // x
  Eigen::Vector3d g_S = Eigen::Vector3d::Zero();
  int facet = -1;  // of B's mesh that x lies on
  // In a field of planes: which of them hold x, and their μ; −1 where there are fewer.
  std::array<int, 3> planes{-1, -1, -1};
  std::array<double, 3> shares{};
};

// `near` is the side's own; `patches` is scratch.
DeepestPlace FindDeepestPlace(const ContactSide& side, const Pose& X_SB, NearFacets* near, SidePatches* patches);

}  // namespace knap
