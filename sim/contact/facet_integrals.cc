#include "sim/contact/facet_integrals.h"

#include <Eigen/Geometry>

#include "sim/contact/planar_moments.h"
#include "sim/math/so3.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
// Rows W, m1 and the six numbers of m2; from integrals of the monomials, or by perturbations.
using WeightMatrix = Eigen::Matrix<double, 10, 6>;
using Weights = Eigen::Matrix<double, 10, 1>;

Vector6d Monomials(const Vector2d& s) {
  return (Vector6d() << 1.0, s.x(), s.y(), s.x() * s.x(), s.x() * s.y(), s.y() * s.y()).finished();
}

// The six numbers of x xᵀ, and of x yᵀ + y xᵀ.
Vector6d Square(const Vector3d& x) {
  return {x(0) * x(0), x(0) * x(1), x(0) * x(2), x(1) * x(1), x(1) * x(2), x(2) * x(2)};
}
Vector6d Mix(const Vector3d& x, const Vector3d& y) {
  return {2.0 * x(0) * y(0), x(0) * y(1) + x(1) * y(0), x(0) * y(2) + x(2) * y(0),
          2.0 * x(1) * y(1), x(1) * y(2) + x(2) * y(1), 2.0 * x(2) * y(2)};
}

WeightMatrix MakeWeightMatrix(const PlaneFrame& f) {
  WeightMatrix out;
  out.row(0) << 1.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  out.block<3, 6>(1, 0) << f.o, f.t, f.m, Matrix3d::Zero();
  out.block<6, 6>(4, 0) << Square(f.o), Mix(f.o, f.t), Mix(f.o, f.m), Square(f.t), Mix(f.t, f.m), Square(f.m);
  return out;
}

// Over each inner wall's edge, at Gauss's points: use(wall, s, e dl/|w_t|).
template <class Use>
void ForWalls(const FacetRegion& region, std::span<const WallEdge> walls, const Use& use) {
  for (const WallEdge& wall : walls.subspan(region.first_wall, region.num_walls)) {
    const Vector2d d = wall.end - wall.begin;
    for (int g = 0; g < 3; ++g) {
      const Vector2d s = wall.begin + kEdgeAt[g] * d;
      const double e = region.field.e.dot(Monomials(s));
      use(wall, s, e * kEdgeWeight[g] * d.norm() / wall.in_plane);
    }
  }
}

// How W, m1 and m2 move for what ∫ (∂e/∂xi) ψ dA and the walls say; columns the perturbation (rotation, translation).
WeightMatrix CalcRates(const FacetRegion& region, std::span<const WallEdge> walls) {
  const PlaneFrame& f = region.frame;
  const Vector3d G0 = region.field.gradient.col(0);
  // ∂e/∂xi over the monomials.
  Matrix6d slope = Matrix6d::Zero();
  slope.leftCols<3>() << f.o.cross(G0), f.t.cross(G0), f.m.cross(G0), G0, Vector3d::Zero(), Vector3d::Zero();
  const WeightMatrix weights = MakeWeightMatrix(f);
  const Matrix6d gram = region.moments.MakeGram();
  WeightMatrix out;
  if (region.field.linear) {
    const Eigen::Matrix<double, 10, 3> moved = weights * gram.leftCols<3>();
    out.noalias() = moved * slope.leftCols<3>().transpose();
  } else {
    const Vector3d Gu = region.field.gradient.col(1);
    const Vector3d Gw = region.field.gradient.col(2);
    slope.topRows<3>().middleCols<2>(1) += (Eigen::Matrix<double, 3, 2>() << f.o.cross(Gu), f.o.cross(Gw)).finished();
    slope.topRows<3>().rightCols<3>() << f.t.cross(Gu), f.t.cross(Gw) + f.m.cross(Gu), f.m.cross(Gw);
    slope.bottomRows<3>().middleCols<2>(1) << Gu, Gw;
    const WeightMatrix moved = weights * gram;
    out.noalias() = moved * slope.transpose();
  }
  ForWalls(region, walls, [&](const WallEdge& wall, const Vector2d& s, double e_dl) {
    const Vector3d x = f.Place(s);
    Vector6d flow;
    flow << x.cross(wall.w), wall.w;
    Weights psi;
    psi << 1.0, x, Square(x);
    out.noalias() -= (e_dl * psi) * flow.transpose();
  });
  return out;
}

// The sum that a patch's cotangents make is ∫ e ψ dA with ψ = c + L·x + xᵀ B x on a facet.
struct Integrand {
  Vector6d at;        // ψ over the monomials
  Matrix3d gradient;  // ∇ψ over 1, u, w

  Integrand(const PlaneFrame& f, const PatchCotangent& b) {
    const double c = b.W - b.F.dot(f.n);
    const Vector3d L = b.m1 - f.n.cross(b.M);
    const Matrix3d& B = b.m2;
    const Vector3d Bo = B * f.o;
    at << c + L.dot(f.o) + f.o.dot(Bo), L.dot(f.t) + 2.0 * Bo.dot(f.t), L.dot(f.m) + 2.0 * Bo.dot(f.m),
        f.t.dot(B * f.t), 2.0 * f.t.dot(B * f.m), f.m.dot(B * f.m);
    gradient << L + 2.0 * Bo, 2.0 * B * f.t, 2.0 * B * f.m;
  }
};

}  // namespace

void AddRegion(const FacetRegion& region, PatchIntegrals* patch) {
  const PlaneFrame& f = region.frame;
  const Weights sum = MakeWeightMatrix(f) * (region.moments.MakeGram() * region.field.e);
  const Vector3d m1 = sum.segment<3>(1);
  patch->F -= sum(0) * f.n;
  patch->M -= m1.cross(f.n);
  patch->W += sum(0);
  patch->m1 += m1;
  patch->m2 += UnpackSymmetric(sum.tail<6>());
  patch->depth = std::max(patch->depth, region.depth);
}

void AddRegionJacobian(const FacetRegion& region, std::span<const WallEdge> walls, PatchJacobian* jacobian) {
  const Vector3d& n = region.frame.n;
  const WeightMatrix rate = CalcRates(region, walls);
  jacobian->topRows<3>().noalias() -= n * rate.row(0);
  jacobian->middleRows<3>(3).noalias() += Skew(n) * rate.middleRows<3>(1);
  jacobian->bottomRows<10>() += rate;
}

void FinishJacobian(const PatchIntegrals& patch, PatchJacobian* jacobian) {
  // v = w × x + v0: forces turn and shift with B, places too.
  jacobian->block<3, 3>(0, 0) -= Skew(patch.F);
  jacobian->block<3, 3>(3, 0) -= Skew(patch.M);
  jacobian->block<3, 3>(3, 3) -= Skew(patch.F);
  jacobian->block<3, 3>(7, 0) -= Skew(patch.m1);
  jacobian->block<3, 3>(7, 3) += patch.W * Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) {
    const Matrix3d turned = Skew(Vector3d::Unit(k)) * patch.m2;
    const Matrix3d shifted = Vector3d::Unit(k) * patch.m1.transpose();
    AddSymmetric(turned + turned.transpose(), k, jacobian);
    AddSymmetric(shifted + shifted.transpose(), 3 + k, jacobian);
  }
}

void PullBackRegion(const FacetRegion& region, std::span<const WallEdge> walls, const Facet& triangle,
                    const PatchCotangent& b, std::array<Vector3d, 3>* bar_corners) {
  const std::array<Vector3d, 3> x = {triangle.Place(0), triangle.Place(1), triangle.Place(2)};
  const PlaneFrame& f = region.frame;
  const Vector3d& n = f.n;
  const Integrand psi(f, b);

  // Barycentric coordinates, each over 1, u, w: rows of the inverse of [1; u; w] of the corners.
  Matrix3d corners;
  for (int i = 0; i < 3; ++i) corners.col(i) << 1.0, f.Locate(x[i]);
  const Matrix3d barycentric = corners.inverse();

  const Matrix6d gram = region.moments.MakeGram();
  const Vector6d by_e = gram * region.field.e;
  const Matrix3d H = region.field.gradient * UnpackSymmetric(gram * psi.at) + psi.gradient * UnpackSymmetric(by_e);
  const Weights sum = MakeWeightMatrix(f) * by_e;
  const Vector3d m1 = sum.segment<3>(1);
  // Normal and area: both are the triangle's vector area.
  const double psi_s = b.W * sum(0) + b.m1.dot(m1) + b.m2.cwiseProduct(UnpackSymmetric(sum.tail<6>())).sum();
  const double twice_area = (x[1] - x[0]).cross(x[2] - x[0]).norm();
  const Vector3d by_area = (psi_s * n - sum(0) * b.F - b.M.cross(m1)) / twice_area;
  for (int i = 0; i < 3; ++i) {
    (*bar_corners)[i] += H * barycentric.row(i).transpose() + (x[(i + 1) % 3] - x[(i + 2) % 3]).cross(by_area);
  }
  ForWalls(region, walls, [&](const WallEdge& wall, const Vector2d& s, double e_dl) {
    const double flow = e_dl * psi.at.dot(Monomials(s));
    const Vector3d phi = barycentric * Vector3d(1.0, s.x(), s.y());
    for (int i = 0; i < 3; ++i) (*bar_corners)[i] -= phi(i) * flow * wall.w;
  });
}

void PullBackField(const FacetRegion& region, std::span<const WallEdge> walls, const PatchCotangent& bar,
                   std::span<FieldPlane> bar_planes) {
  const PlaneFrame& f = region.frame;
  const Integrand psi(f, bar);
  const Vector6d sum = region.moments.MakeGram() * psi.at;
  FieldPlane& own = bar_planes[static_cast<std::size_t>(region.cell)];
  own.d += sum(0);
  own.n -= sum(0) * f.o + sum(1) * f.t + sum(2) * f.m;
  ForWalls(region, walls, [&](const WallEdge& wall, const Vector2d& s, double e_dl) {
    const double flow = e_dl * psi.at.dot(Monomials(s));
    const Vector3d x = f.Place(s);
    FieldPlane& other = bar_planes[static_cast<std::size_t>(wall.beyond)];
    other.d += flow;
    other.n -= flow * x;
    own.d -= flow;
    own.n += flow * x;
  });
}

}  // namespace knap
