#include "sim/contact/deepest_place.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <variant>
#include <vector>

#include "sim/math/check.h"
#include "sim/math/overloaded.h"

namespace knap {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// What is closer than this share of the bodies' width, places or depths, is one.
constexpr double kSame = 1e-9;

// Σ μ_i of some columns.
struct Mean {
  Vector3d g = Vector3d::Zero();
  std::array<int, 3> columns{-1, -1, -1};
  std::array<double, 3> shares{};
};

// Of the columns of `gradients`, at least one, a mean with weights ≥ 0 of at most three that has no part in `level`, a
// projection on a line or plane; where there is none, the one with the least.
Mean Mix(const Eigen::Matrix3Xd& gradients, const Matrix3d& level) {
  const int n = static_cast<int>(gradients.cols());
  Mean best{gradients.col(0), {0, -1, -1}, {1.0, 0.0, 0.0}};
  double least = (level * best.g).norm();
  const auto consider = [&](const Mean& mean) {
    const double part = (level * mean.g).norm();
    // What rounding makes of a tie settles nothing.
    if (!(part < least - kSame)) return;
    least = part;
    best = mean;
  };
  for (int i = 0; i < n && least > kSame; ++i) {
    const Vector3d g = gradients.col(i);
    consider({g, {i, -1, -1}, {1.0, 0.0, 0.0}});
    for (int j = i + 1; j < n && least > kSame; ++j) {
      const Vector3d d = gradients.col(j) - g;
      const double size = d.dot(level * d);
      const double mu = -d.dot(level * g) / size;
      if (mu > 0.0 && mu < 1.0) consider({g + mu * d, {i, j, -1}, {1.0 - mu, mu, 0.0}});
      for (int k = j + 1; k < n && least > kSame; ++k) {
        Eigen::Matrix<double, 3, 2> both;
        both << d, gradients.col(k) - g;
        const Matrix2d along = both.transpose() * level * both;
        if (!(along.determinant() > 1e-9 * along.squaredNorm())) continue;
        const Vector2d weights = -along.inverse() * (both.transpose() * (level * g));
        if (!(weights.minCoeff() > 0.0 && weights.sum() < 1.0)) continue;
        consider({g + both * weights, {i, j, k}, {1.0 - weights.sum(), weights(0), weights(1)}});
      }
    }
  }
  return best;
}

Matrix3d ProjectAcross(const Vector3d& axis) { return Matrix3d::Identity() - axis * axis.transpose(); }
Matrix3d ProjectOnto(const Vector3d& axis) { return axis * axis.transpose(); }

// ---- A facet in a field of planes ---------------------------------------------------------------------------------

// Onto the directions in which the facet goes on to both sides of a place of it.
Matrix3d FindLevel(const Facet& facet, const Vector3d& x, double same) {
  Matrix3d level = ProjectAcross(facet.frame.n);
  for (int k = 0, edges = 0; k < facet.size; ++k) {
    const Vector3d begin = facet.Place(k);
    const Vector3d edge = (facet.Place((k + 1) % facet.size) - begin).normalized();
    if (edge.cross(x - begin).norm() > same) continue;
    level = ++edges > 1 ? Matrix3d(Matrix3d::Zero()) : ProjectOnto(edge);
  }
  return level;
}

DeepestPlace FindOnFacets(const ContactSide& side, const PolyhedralField& field, const SidePatches& patches) {
  const FacetRegion* deepest = nullptr;
  for (const FacetRegion& region : patches.facets.regions) {
    if (deepest == nullptr || region.depth > deepest->depth) deepest = &region;
  }
  if (deepest == nullptr || !(deepest->depth > 0.0)) return {};
  DeepestPlace out;
  out.depth = deepest->depth;
  out.facet = deepest->facet;
  out.p_S = deepest->frame.Place(deepest->peak);
  const double same = kSame * side.size;
  Eigen::Matrix3Xd gradients(3, static_cast<Eigen::Index>(field.planes.size()));
  std::vector<int> holding;
  for (std::size_t i = 0; i < field.planes.size(); ++i) {
    if (-field.planes[i].CalcHeight(out.p_S) > out.depth + same) continue;
    gradients.col(static_cast<Eigen::Index>(holding.size())) = -field.planes[i].n;
    holding.push_back(static_cast<int>(i));
  }
  const Facet facet = Move(patches.X_SB, side.facets->facets()[static_cast<std::size_t>(out.facet)]);
  const Mean mean = Mix(gradients.leftCols(static_cast<Eigen::Index>(holding.size())), FindLevel(facet, out.p_S, same));
  out.g_S = mean.g;
  out.shares = mean.shares;
  for (std::size_t k = 0; k < 3; ++k) {
    if (mean.columns[k] >= 0) out.planes[k] = holding[static_cast<std::size_t>(mean.columns[k])];
  }
  return out;
}

// ---- A facet in a round field or a cylinder's -----------------------------------------------------------------------

// e is concave there, and made of few pieces, each quadratic or linear on the facet's plane: it is largest at a corner,
// where a piece is largest along an edge or in the plane, or on the curve where a cylinder's side and end are equally
// near. All such places are tried, and the depth of each is the field's own.
template <class Field>
class FacetPeak {
 public:
  FacetPeak(const Facet& facet, const Field& field) : facet_(facet), field_(field) {}

  DeepestPlace Find() {
    AddPieces(field_);
    for (int k = 0; k < facet_.size; ++k) TryEdge(facet_.corner[k], facet_.corner[(k + 1) % facet_.size]);
    TryMiddle();
    for (int i = 0; i < num_pieces_; ++i) TryInside(pieces_[i]);
    if (best_.depth > 0.0) best_.g_S = CalcGradient(field_);
    return best_;
  }

 private:
  // c + b·s + s·A s
  struct Piece {
    double c = 0.0;
    Vector2d b = Vector2d::Zero();
    Matrix2d A = Matrix2d::Zero();
    double At(const Vector2d& s) const { return c + b.dot(s) + s.dot(A * s); }
  };
  // Along d from a: what it is at a, and how it goes on.
  struct Line {
    double c, b, A;
  };
  static Line Restrict(const Piece& piece, const Vector2d& a, const Vector2d& d) {
    return {piece.At(a), piece.b.dot(d) + 2.0 * d.dot(piece.A * a), d.dot(piece.A * d)};
  }

  void AddRound(const Vector3d& center, const Matrix3d& P, double radius) {
    const auto e = MakeRoundField(facet_.frame, center, P, radius).e;
    Piece& piece = pieces_[num_pieces_++];
    piece = {e(0), {e(1), e(2)}, (Matrix2d() << e(3), 0.5 * e(4), 0.5 * e(4), e(5)).finished()};
  }

  void AddPieces(const RoundField& f) {
    if (f.half_length == 0.0) {
      AddRound(f.center, Matrix3d::Identity(), f.radius);
      return;
    }
    for (const double end : {1.0, -1.0}) {
      AddRound(f.center + end * f.half_length * f.axis, Matrix3d::Identity(), f.radius);
    }
    AddRound(f.center, ProjectAcross(f.axis), f.radius);
  }
  void AddPieces(const CylinderField& f) {
    AddRound(f.center, ProjectAcross(f.axis), f.radius);
    for (const double end : {1.0, -1.0}) {
      const PlaneFrame& plane = facet_.frame;
      ends_[num_ends_++] = {f.half_length - end * f.axis.dot(plane.o - f.center),
                            {-end * f.axis.dot(plane.t), -end * f.axis.dot(plane.m)},
                            Matrix2d::Zero()};
    }
  }

  void Try(const Vector2d& s, const Matrix3d& level) {
    const Vector3d x = facet_.frame.Place(s);
    const double e = CalcDepth(field_, x);
    if (!(e > best_.depth)) return;
    best_.depth = e;
    best_.p_S = x;
    level_ = level;
  }

  void TryEdge(const Vector2d& a, const Vector2d& b) {
    Try(a, Matrix3d::Zero());
    const Vector2d d = b - a;
    const Matrix3d along = ProjectOnto((d.x() * facet_.frame.t + d.y() * facet_.frame.m).normalized());
    const auto try_at = [&](double share) {
      if (share > 0.0 && share < 1.0) Try(a + share * d, along);
    };
    for (int i = 0; i < num_pieces_; ++i) {
      const Line q = Restrict(pieces_[i], a, d);
      if (q.A < 0.0) try_at(-0.5 * q.b / q.A);
      for (int j = 0; j < num_ends_; ++j) {
        const Line l = Restrict(ends_[j], a, d);
        const double half = 0.5 * (q.b - l.b), c = q.c - l.c;
        const double discriminant = half * half - q.A * c;
        if (!(discriminant >= 0.0)) continue;
        // The root without cancellation first.
        const double big = -(half + std::copysign(std::sqrt(discriminant), half));
        if (q.A != 0.0) try_at(big / q.A);
        if (big != 0.0) try_at(c / big);
      }
    }
  }

  // Of a cylinder's ends: the line at which they are equally near, between the facet's edges.
  void TryMiddle() {
    if (num_ends_ == 0) return;
    const Vector2d slope = 0.5 * (ends_[1].b - ends_[0].b);
    const LinearOnPlane along{0.5 * (ends_[1].c - ends_[0].c), slope.x(), slope.y()};
    std::array<Vector2d, 2> passed;
    int count = 0;
    for (int k = 0; k < facet_.size; ++k) {
      const Vector2d& a = facet_.corner[k];
      const Vector2d& b = facet_.corner[(k + 1) % facet_.size];
      const double at_a = along.At(a), at_b = along.At(b);
      if ((at_a < 0.0) != (at_b < 0.0) && count < 2) passed[count++] = a + at_a / (at_a - at_b) * (b - a);
    }
    if (count == 2) TryEdge(passed[0], passed[1]);
  }

  void TryInside(const Piece& q) {
    const double size = q.A.cwiseAbs().maxCoeff();
    if (!(q.A.determinant() > 1e-12 * size * size)) return;  // level along the axis: an edge is as deep
    const Matrix2d inverse = (2.0 * q.A).inverse();
    const Matrix3d level = ProjectAcross(facet_.frame.n);
    const auto try_at = [&](const Vector2d& s) {
      for (int k = 0; k < facet_.size; ++k) {
        const Vector2d edge = facet_.corner[(k + 1) % facet_.size] - facet_.corner[k];
        const Vector2d to = s - facet_.corner[k];
        if (edge.x() * to.y() - edge.y() * to.x() < 0.0) return;
      }
      Try(s, level);
    };
    const Vector2d peak = -inverse * q.b;
    try_at(peak);
    // Where e = (1 − μ) q + μ l is level, s = peak + ν d, ν = μ/(1 − μ), and q = l.
    for (int j = 0; j < num_ends_; ++j) {
      const Piece& l = ends_[j];
      const Vector2d d = -inverse * l.b;
      const double rise = l.b.dot(d);
      const double gap = q.At(peak) - l.At(peak);
      if (rise > 0.0 && gap > 0.0) try_at(peak + (std::sqrt(1.0 + 2.0 * gap / rise) - 1.0) * d);
    }
  }

  Vector3d CalcGradient(const RoundField& f) const {
    const Vector3d d = best_.p_S - f.center;
    return -(d - std::clamp(f.axis.dot(d), -f.half_length, f.half_length) * f.axis) / f.radius;
  }
  Vector3d CalcGradient(const CylinderField& f) const {
    const Vector3d d = best_.p_S - f.center;
    const double along = f.axis.dot(d);
    const Vector3d across = d - along * f.axis;
    const double side = (f.radius * f.radius - across.squaredNorm()) / (2.0 * f.radius);
    const double end = f.half_length - std::abs(along);
    const Vector3d by_side = -across / f.radius;
    const Vector3d by_end = -std::copysign(1.0, along) * f.axis;
    if (std::abs(along) <= kSame * f.radius && end <= side + kSame * f.radius)
      return Vector3d::Zero();  // no place of S is deeper
    if (std::abs(side - end) <= kSame * f.radius) {
      return Mix((Eigen::Matrix3Xd(3, 2) << by_side, by_end).finished(), level_).g;
    }
    return side < end ? by_side : by_end;
  }

  const Facet& facet_;
  const Field& field_;
  std::array<Piece, 3> pieces_;
  std::array<Piece, 2> ends_;
  int num_pieces_ = 0, num_ends_ = 0;
  DeepestPlace best_;
  Matrix3d level_;  // onto the directions in which B's surface goes on at the best place
};

template <class Field>
DeepestPlace FindOnFacets(const ContactSide& side, const Field& field, const Pose& X_SB, NearFacets* near) {
  DeepestPlace best;
  for (const int i : near->Find(side, X_SB)) {
    const Facet facet = Move(X_SB, side.facets->facets()[static_cast<std::size_t>(i)]);
    if (facet.size == 0) continue;
    const DeepestPlace place = FacetPeak<Field>(facet, field).Find();
    if (!(place.depth > best.depth)) continue;
    best = place;
    best.facet = i;
  }
  return best;
}

// ---- Bodies without facets ----------------------------------------------------------------------------------------

DeepestPlace FindOnAxis(const RoundAxis& axis, const PolyhedralField& half_space) {
  const FieldPlane& plane = half_space.planes.front();
  const double slope = plane.n.dot(axis.direction);
  const double end = slope == 0.0 ? 0.0 : std::copysign(axis.half_length, -slope);
  DeepestPlace out;
  out.p_S = axis.center + end * axis.direction;
  out.depth = std::max(0.0, axis.radius - plane.CalcHeight(out.p_S));
  out.g_S = -plane.n;
  return out;
}

DeepestPlace FindOnAxis(const RoundAxis& axis, const RoundField& field) {
  const double rho = axis.radius + field.radius;
  const RoundField widened{rho, field.half_length, field.center, field.axis};
  DeepestPlace best;
  const auto try_at = [&](double along) {
    const Vector3d x = axis.center + std::clamp(along, -axis.half_length, axis.half_length) * axis.direction;
    const double e = CalcDepth(widened, x);
    if (!(e > best.depth)) return;
    best.depth = e;
    best.p_S = x;
  };
  // Where the axis is nearest to the middle line of the field, and to either end of it; then its own ends.
  const double slope = axis.direction.dot(field.axis);
  const Vector3d to = field.center - axis.center;
  const double across = 1.0 - slope * slope;
  if (across > 0.0) try_at((to.dot(axis.direction) - slope * to.dot(field.axis)) / across);
  for (const double end : {0.0, field.half_length, -field.half_length}) {
    try_at((to + end * field.axis).dot(axis.direction));
  }
  for (const double end : {axis.half_length, -axis.half_length}) try_at(end);
  const Vector3d d = best.p_S - field.center;
  best.g_S = -(d - std::clamp(field.axis.dot(d), -field.half_length, field.half_length) * field.axis) / rho;
  return best;
}

DeepestPlace FindOnAxis(const RoundAxis&, const CylinderField&) {
  KNAP_CHECK(false, "a cylinder is what touches a round body (pair_rules.h)");
  return {};
}

DeepestPlace FindOnRim(const SolidCylinder& cylinder, const FieldPlane& plane) {
  const double slope = plane.n.dot(cylinder.direction);
  const Vector3d up = plane.n - slope * cylinder.direction;
  DeepestPlace out;
  out.p_S = cylinder.center;
  if (slope != 0.0) out.p_S -= std::copysign(cylinder.half_length, slope) * cylinder.direction;
  if (up.norm() > 0.0) out.p_S -= cylinder.radius / up.norm() * up;
  out.depth = std::max(0.0, -plane.CalcHeight(out.p_S));
  out.g_S = -plane.n;
  return out;
}

}  // namespace

DeepestPlace FindDeepestPlace(const ContactSide& side, const Pose& X_SB, NearFacets* near, SidePatches* patches) {
  if (side.axis) {
    const RoundAxis axis = side.axis->Move(X_SB);
    return std::visit([&](const auto& field) { return FindOnAxis(axis, field); }, side.field);
  }
  if (side.cylinder) {
    return FindOnRim(side.cylinder->Move(X_SB), std::get<PolyhedralField>(side.field).planes.front());
  }
  return std::visit(Overloaded{[&](const PolyhedralField& field) {
                                 CalcPatches(side, near, X_SB, patches);
                                 return FindOnFacets(side, field, *patches);
                               },
                               [&](const auto& field) { return FindOnFacets(side, field, X_SB, near); }},
                    side.field);
}

}  // namespace knap
