// The surface of a solid cylinder with flat ends in the depth field of a half-space.
//
//   F = −∫ e n dA   M = −∫ e x × n dA   W = ∫ e dA   m1 = ∫ e x dA   m2 = ∫ e x xᵀ dA      e > 0 the depth, n outward
//
// over the ends, plane regions within a circle (planar_moments.h), and the side, whose lines along the axis are summed
// by Gauss's rule in the angle between the places where the surface of the half-space passes an end of the line: along
// each line, and between those places, all integrands are polynomials, in the angle's cosine and sine. The sums are
// exact up to some 1e-12, and so is the energy's gradient: the volume below the plane times its depth.
#pragma once

#include <Eigen/Core>

#include "sim/contact/depth_field.h"
#include "sim/contact/patch_integrals.h"
#include "sim/math/pose.h"

namespace knap {

// In its own frame or in S.
struct SolidCylinder {
  Eigen::Vector3d center;
  Eigen::Vector3d direction;  // unit
  double half_length = 0.0;
  double radius = 0.0;
  SolidCylinder Move(const Pose& X) const { return {X * center, X.R * direction, half_length, radius}; }
};

// One patch, E left out, of a cylinder in a half-space, both in S. `jacobian` may be null; both are overwritten.
void CalcCylinder(const SolidCylinder& cylinder, const FieldPlane& ground, PatchIntegrals* patch,
                  PatchJacobian* jacobian);

}  // namespace knap
