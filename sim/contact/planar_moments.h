// Moments of a plane region bounded by straight edges and arcs of a conic, exactly.
//
//   m_ij = ∫ u^i w^j dA = ∮ u^(i+1)/(i+1) w^j dw,   i + j ≤ 4,   boundary counter-clockwise         [Green's theorem]
//
// Edges are summed by Gauss's rule of three points, which is exact for them; arcs by eight points a quarter turn of the
// conic's own angle, which leaves some 1e-11 of the value.
//
// The region is a convex polygon, whole or cut by the conic
//
//   q(u, w) = c + 2 b u − alpha² u² − w² > 0                                      (where a field is > 0, or the lesser)
//
// A disc for alpha = 1; an ellipse where a plane cuts a cylinder slantwise, a strip where alpha and b → 0; a parabola
// where alpha → 0 and b does not.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace knap {

// Gauss-Legendre on [0, 1] with three points, exact up to the fifth power [Abramowitz & Stegun, 25.4].
inline constexpr std::array<double, 3> kEdgeAt = {0.1127016653792583, 0.5, 0.8872983346207417};
inline constexpr std::array<double, 3> kEdgeWeight = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

// On [−1, 1] with eight points, the positive half: exact up to the fifteenth power [same table].
inline constexpr std::array<double, 4> kArcAt = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                                 0.9602898564975363};
inline constexpr std::array<double, 4> kArcWeight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                     0.1012285362903763};

class PlanarMoments {
 public:
  static constexpr int kDegree = 4;
  static constexpr int kCount = 15;
  // By degree, and within a degree by falling power of u: 1, u, w, u², uw, w², …
  static constexpr int Index(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

  double operator()(int i, int j) const { return m_[Index(i, j)]; }
  double area() const { return m_[0]; }

  // The boundary's straight part from p to q, for the moments up to a degree.
  template <int degree>
  void AddEdge(const Eigen::Vector2d& p, const Eigen::Vector2d& q);
  // Its arc center + (a cos φ, b sin φ), φ from `begin` on by `span` ≥ 0.
  void AddArc(double center_u, double a, double b, double begin, double span);
  // Likewise of an open conic, from σ = begin to end: u = vertex + 2 R σ² sign, w = 2 R σ √(1 − alpha² σ²).
  void AddOpenArc(double vertex, double R, double sign, double alpha2, double begin, double end);

  // Sums of two monomials' powers: element (α, β) is ∫ s^α s^β dA over the six monomials of degree up to 2.
  Eigen::Matrix<double, 6, 6> MakeGram() const;

 private:
  template <int degree>
  void Add(double u, double w, double dw);
  std::array<double, kCount> m_{};
};

struct Conic {
  double c = 0.0;
  double b = 0.0;
  double alpha = 1.0;
  // A parabola, or an ellipse that is so long that only the half towards its nearer vertex reaches the polygon.
  bool is_open = false;

  // q = r² − w² − (alpha u − beta)².
  static Conic Around(double r2, double alpha, double beta) { return {r2 - beta * beta, alpha * beta, alpha, false}; }
  double At(const Eigen::Vector2d& x) const { return c + x.x() * (2.0 * b - alpha * alpha * x.x()) - x.y() * x.y(); }
};

// A convex polygon's corners, counter-clockwise.
using PlanePolygon = std::span<const Eigen::Vector2d>;

// Up to the third degree, which is what a linear field asks for; those of the fourth are 0.
PlanarMoments CalcPolygonMoments(PlanePolygon polygon);
// Of the part inside the conic. Zero area without one.
PlanarMoments CalcConicMoments(PlanePolygon polygon, const Conic& conic);

}  // namespace knap
