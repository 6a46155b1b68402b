// Exact integrals of a sphere's pressure over one triangle.
//
// An elastic foundation lies on the surface of a mesh: where the surface point x is inside a sphere (centre c, radius
// r), it carries the pressure E (r² − |x − c|²)/(2r), which is E × depth to first order, along (c − x)/r. Over a
// triangle T this needs
//
//   W = ∫_{T∩ball} (r² − |x − c|²) dA          [m⁴]
//   g = ∫_{T∩ball} (r² − |x − c|²)(c − x) dA   [m⁵]
//
// which are evaluated in closed form, so that faces, edges and vertices are all covered, nothing slips through between
// samples, and cutting a triangle in two changes nothing. The elastic force E/(2r²)·g is minus the gradient in c of the
// energy E/(8r²) ∫ (r² − |x − c|²)² dA: conservative and C¹ wherever the sphere goes, across edges and creases too.
//
// With n the triangle's normal, h = n·(c − v0), the foot f = c − h n, a² = r² − h² and s = x − f, Green's theorem turns
// the moments over T∩disc(a) into sums over the edges, on the part τ1 ≤ t ≤ τ2 of each edge inside the disc, where
// s = p m + t e (m outward, e along the edge) and q² = a² − p²:
//
//   A0 = ∫ dA      = ½ [Σ p Δτ + a² (Θ − Σ Δθ)]         A1 = ∫ s dA       = −½ Σ m ∫ (q² − t²) dt
//   W  = ∫ (a²−s²) = Σ p ∫ (a²/2 − (p²+t²)/4) dt + a⁴/4 (Θ − Σ Δθ)
//   M1 = ∫ (a²−s²) s dA = −¼ Σ m ∫ (q² − t²)² dt        A2 = ∫ s sᵀ dA    = ½ [W P − Σ ∫ s (q² − t²) dt mᵀ]
//   Δθ = ∫ p/(p² + t²) dt, Θ = 2π if f is inside T, else 0, P = I − n nᵀ,   g = W h n − M1.
#pragma once

#include <Eigen/Dense>
#include <array>

namespace knap {

// What does not depend on the sphere, kept for every triangle of a deformed mesh.
struct TriangleFrame {
  std::array<Eigen::Vector3d, 3> v;  // vertices, counter-clockwise about n
  Eigen::Vector3d n;                 // unit normal, outward of the solid
  std::array<Eigen::Vector3d, 3> e;  // unit direction of edge k, from v[k] to v[(k+1)%3]
  std::array<Eigen::Vector3d, 3> m;  // unit outward normal of edge k in the triangle's plane
  std::array<double, 3> length;      // of edge k [m]

  static TriangleFrame Make(const Eigen::Vector3d& v0, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2);
};

struct SphereTriangleIntegrals {
  bool active = false;  // the sphere reaches the triangle: W > 0
  double W = 0.0;
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  // Kept for the derivatives.
  double h = 0.0;
  double A0 = 0.0;
  Eigen::Vector3d A1 = Eigen::Vector3d::Zero();
  Eigen::Vector3d M1 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d edge_moment = Eigen::Matrix3d::Zero();  // Σ ∫ s (q² − t²) dt mᵀ
};

// False only where the sphere does not reach the triangle: it misses the plane, or the disc it cuts out of the plane
// lies wholly beyond one edge. A quick test, in the order of what most often decides.
inline bool MayReach(const TriangleFrame& triangle, const Eigen::Vector3d& c, double r) {
  const Eigen::Vector3d y = triangle.v[0] - c;
  const double h = triangle.n.dot(y);
  const double a2 = r * r - h * h;
  if (a2 <= 0.0) return false;
  const auto beyond = [a2](double p) { return p < 0.0 && p * p >= a2; };
  // m lies in the plane, so distances from the edges are the same for c as for its foot; edges 0 and 2 meet in v0.
  return !beyond(triangle.m[0].dot(y)) && !beyond(triangle.m[2].dot(y)) &&
         !beyond(triangle.m[1].dot(triangle.v[1] - c));
}

SphereTriangleIntegrals CalcSphereTriangle(const TriangleFrame& triangle, const Eigen::Vector3d& c, double r);

// The same integrals over the whole plane through the point with unit normal n at signed distance h = n·(c − point):
// the limit of an infinitely large triangle, and the model of a half-space.
SphereTriangleIntegrals CalcSpherePlane(const Eigen::Vector3d& n, double h, double r);

// dW/dc = −2 ∫ (c − x) dA and dg/dc = W I − 2 ∫ (c − x)(c − x)ᵀ dA.
struct SphereTriangleJacobian {
  Eigen::RowVector3d dW_dc;
  Eigen::Matrix3d dg_dc;
};
SphereTriangleJacobian CalcSphereTriangleJacobian(const SphereTriangleIntegrals& integrals, const Eigen::Vector3d& n);

// Cotangents of the vertices for Phi = bar_W W + bar_g · g, by the transport theorem on the moving triangle:
//   bar_v_k = Σ_edges m ∫ λ_k φ dt + n ∫ λ_k ∂φ/∂n dA,   φ the integrand of Phi, λ_k the barycentric coordinate.
std::array<Eigen::Vector3d, 3> PullBackSphereTriangle(const TriangleFrame& triangle,
                                                      const SphereTriangleIntegrals& integrals,
                                                      const Eigen::Vector3d& c, double r, double bar_W,
                                                      const Eigen::Vector3d& bar_g);

}  // namespace knap
