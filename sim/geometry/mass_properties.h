// Mass, first moment and rotational inertia of a body of one density that fills a closed triangle mesh, as exact volume
// integrals, and the way back from cotangents of these ten numbers to the vertices.
//
// Each triangle (a, b, c) spans a signed tetrahedron with a reference point; for a closed mesh the sum does not depend
// on that point, and neither do its derivatives. With D = a·(b × c), s = a + b + c, relative to it:
//
//   V = Σ D/6,   ∫x dV = Σ D s/24,   ∫x xᵀ dV = Σ D (s sᵀ + a aᵀ + b bᵀ + c cᵀ)/120        [Tonon 2004]
//   I_Bo = density (tr(C) 1 − C),  C = ∫x xᵀ dV
//
// The point is the centre of the bounding box, so that a mesh far from Bo loses no digits but those of its distance.
#pragma once

#include <Eigen/Dense>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Ten numbers, linear in the density; also used for their cotangents, where `inertia` pairs with dI as
// Σ inertia(i,j) dI(i,j).
struct MassProperties {
  double mass = 0.0;                                       // [kg]
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();  // mass · p_BoBcm_B [kg m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();       // I_BBo_B, symmetric [kg m²]

  Eigen::Vector3d CalcCenter() const { return first_moment / mass; }
  // About the centre of mass.
  Eigen::Matrix3d CalcCentralInertia() const;
};

// `mesh` in B, closed and outward (FindDefects is empty); density [kg/m³]. Without meaning for others; indices must be
// in range.
MassProperties CalcMassProperties(const TriangleMesh& mesh, double density);

// Cotangents of the vertices, 3 × vertices, under `bar`.
Eigen::Matrix3Xd PullBackMassProperties(const TriangleMesh& mesh, double density, const MassProperties& bar);

}  // namespace knap
