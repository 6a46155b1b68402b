// A round body, a ball swept along an axis of length 2 L, against a half-space or another round body.
//
// The energy is that of the axis in the other's field, widened by the own radius r: with e(x) the depth at which a ball
// of radius r at x touches, ρ = r + r_S, R = r r_S/ρ, b the lesser of r and r_S (against a half-space R = b = r),
//
//   U = E [ ∫_axis b e² ds + ½ Σ_ends u(e) ]        e = (ρ² − d²)/(2ρ), d the distance from S's axis;  e = r − z
//   u = π R e³/3      against a half-space exactly a ball's: u' = volume below the plane, π e² (r − e/3) up to
//                     e = 2 r, then 4/3 π r³
//
// A ball's two ends fall together. U hangs on where the axis is alone: nothing brakes a bar along its own axis. Exact:
// the integrands are polynomials between a few breakpoints. Two round bodies meet with half of E in either direction,
// so that neither is special. Contact acts at x_C = (r_S x + r y)/ρ, y the nearest point of S's axis; below x on a
// plane. z is the height over the half-space's plane.
#pragma once

#include <Eigen/Core>
#include <variant>

#include "sim/contact/depth_field.h"
#include "sim/contact/patch_integrals.h"
#include "sim/math/pose.h"

namespace knap {

// A round body's axis, in its own frame or in S.
struct RoundAxis {
  Eigen::Vector3d center;
  Eigen::Vector3d direction;  // unit
  double half_length = 0.0;
  double radius = 0.0;
  RoundAxis Move(const Pose& X) const { return {X * center, X.R * direction, half_length, radius}; }
};

// One patch, E left out. A polyhedron in `field` is a half-space. `jacobian` may be null; both
// are overwritten.
void CalcAxis(const RoundAxis& axis, const DepthField& field, PatchIntegrals* patch, PatchJacobian* jacobian);

}  // namespace knap
