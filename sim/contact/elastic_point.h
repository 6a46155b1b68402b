// The elastic force that a surface exerts on one point of another body, or on a ball around it.
//
// Three models, all C¹ in the point c (in the surface body's frame S) and all pushing out along the unit normal n; the
// contact acts at a = c + l.
//
//   depth of a field     N = k ramp(−phi(c)) |∇phi|,   n = ∇phi/|∇phi|,   l = −rho n              (contact_shape.h)
//   a ball on a mesh     N = k ramp(depth) |g|/(W rho),  depth = sqrt(2 W/π)/(2 rho),  n = g/|g|,   l = −rho n
//   a whole sphere       N = E/(2 r²) |g|,   n = g/|g|,   l = −g/W                             (sphere_triangle.h)
//
// k = modulus × area that the point stands for [N/m]; rho the ball's radius (0: the point itself); W and g the sphere's
// integrals over all triangles it reaches. On a plane W = π (rho² − h²)²/2, so the ball's depth is (rho² − h²)/(2 rho):
// the same for every triangulation, and smooth over edges and creases. The factor |g|/(W rho), there h/rho, lets the
// force pass through zero where the centre reaches the surface: both sphere models are valid to the depth of their
// radius, and draw in beyond. ramp (smooth_ramp.h) rises over kOnsetDepth.
#pragma once

#include <Eigen/Dense>

#include "sim/contact/contact_shape.h"
#include "sim/contact/sphere_triangle.h"

namespace knap {

inline constexpr double kOnsetDepth = 1e-5;  // [m]
// Contacts lighter than at this depth lose their bristle.
inline constexpr double kLightDepth = 1e-9;  // [m]

struct ElasticPoint {
  double N = 0.0;
  double N_light = 1.0;  // where a bristle begins to fade [N]
  Eigen::Vector3d n;
  Eigen::Vector3d l;
  // Filled where derivatives are wanted. dN_dc as a column.
  Eigen::Vector3d dN_dc;
  Eigen::Matrix3d dn_dc, dl_dc;
};

// False without contact.
bool CalcFieldPoint(const ShapeField& field, const Eigen::Vector3d& c, double k, double rho, bool want_jacobian,
                    ElasticPoint* out);

// Sums of a sphere's integrals over the triangles of a mesh.
struct MeshIntegrals {
  double W = 0.0;
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  SphereTriangleJacobian geometry{Eigen::RowVector3d::Zero(), Eigen::Matrix3d::Zero()};
  void Add(const SphereTriangleIntegrals& part, const Eigen::Vector3d& n);
};

// How the response hangs on the integrals: for derivatives in c and for cotangents of the mesh.
struct IntegralJacobian {
  double dN_dW = 0.0;
  Eigen::Vector3d dN_dg, dl_dW;
  Eigen::Matrix3d dn_dg, dl_dg;
};

// W > 0 and g ≠ 0. `k`: of the ball; `jacobian` may be null.
void CalcBallOnMesh(const MeshIntegrals& integrals, double k, double rho, ElasticPoint* out,
                    IntegralJacobian* jacobian);
void CalcSphereOnMesh(const MeshIntegrals& integrals, double modulus, double r, ElasticPoint* out,
                      IntegralJacobian* jacobian);
void ChainIntegrals(const MeshIntegrals& integrals, const IntegralJacobian& jacobian, ElasticPoint* out);

}  // namespace knap
