#include "sim/contact/facet_integrals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/contact/planar_moments.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// A wall that the facet's plane meets under less than this angle has no trace on it [rad].
constexpr double kAlongWall = 1e-9;

// A convex polygon in space; wall k: the inner wall of a cell that edge k lies on, −1 where it is the facet's own or on
// the field's surface.
struct SpacePolygon {
  int size = 0;
  std::array<Vector3d, PlanePolygon::kMaxCorners> corner;
  std::array<int, PlanePolygon::kMaxCorners> wall;
  void Push(const Vector3d& x, int on) {
    corner[size] = x;
    wall[size++] = on;
  }
};

SpacePolygon MakePolygon(const Facet& facet) {
  SpacePolygon polygon;
  for (int k = 0; k < facet.size; ++k) polygon.Push(facet.corner[k], -1);
  return polygon;
}

// The part w·x ≤ b [Sutherland & Hodgman 1974]; the new edge lies on `wall`.
SpacePolygon Clip(const SpacePolygon& polygon, const Vector3d& w, double b, int wall) {
  SpacePolygon out;
  if (polygon.size == 0) return out;
  double inside = b - w.dot(polygon.corner[0]);
  for (int k = 0; k < polygon.size; ++k) {
    const Vector3d& x = polygon.corner[k];
    const Vector3d& y = polygon.corner[(k + 1) % polygon.size];
    const double inside_next = b - w.dot(y);
    if (inside >= 0.0) out.Push(x, polygon.wall[k]);
    if ((inside >= 0.0) != (inside_next >= 0.0)) {
      const double t = inside / (inside - inside_next);
      out.Push(x + t * (y - x), inside >= 0.0 ? wall : polygon.wall[k]);
    }
    inside = inside_next;
  }
  return out;
}

// A frame in the facet's plane: x = o + u t + w m; t × m = n.
struct PlaneFrame {
  Vector3d o, t, m, n;
  Vector2d Locate(const Vector3d& x) const { return {t.dot(x - o), m.dot(x - o)}; }
};

// e over the monomials 1, u, w, u², uw, w², and ∇e over 1, u, w.
struct FieldOnPlane {
  Vector6d e;
  Matrix3d gradient;
};

// One cell's part of a facet.
struct Region {
  PlaneFrame frame;
  FieldOnPlane field;
  PlanarMoments moments;
  double depth = 0.0;
  // The inner walls that bound it: their edges.
  struct WallEdge {
    Vector2d begin, end;
    Vector3d w;
    double in_plane;  // |w_t|
  };
  int num_walls = 0;
  std::array<WallEdge, PlanePolygon::kMaxCorners> walls;
};

Vector6d Monomials(const Vector2d& s) {
  return (Vector6d() << 1.0, s.x(), s.y(), s.x() * s.x(), s.x() * s.y(), s.y() * s.y()).finished();
}

PlanePolygon Flatten(const SpacePolygon& polygon, const PlaneFrame& frame) {
  PlanePolygon out;
  out.size = polygon.size;
  for (int k = 0; k < polygon.size; ++k) out.corner[k] = frame.Locate(polygon.corner[k]);
  return out;
}

// The cells of a polyhedron, in order: calls use(cell, region) for each that the facet reaches.
template <class Use>
void ForRegions(const Facet& facet, const Vector3d& n, const PolyhedralField& field, const Use& use) {
  const std::vector<FieldPlane>& planes = field.planes;
  for (const FieldPlane& plane : planes) {
    bool outside = true;
    for (int k = 0; k < facet.size; ++k) outside = outside && plane.n.dot(facet.corner[k]) >= plane.d;
    if (outside) return;
  }
  const SpacePolygon whole = MakePolygon(facet);
  // Which cuts there are to make: corners on either side of a plane.
  const auto count_inside = [&](const Vector3d& w, double b) {
    int count = 0;
    for (int k = 0; k < facet.size; ++k) count += b - w.dot(facet.corner[k]) >= 0.0 ? 1 : 0;
    return count;
  };
  for (int i = 0; i < static_cast<int>(planes.size()); ++i) {
    SpacePolygon polygon = whole;
    for (int j = 0; j < static_cast<int>(planes.size()) && polygon.size > 0; ++j) {
      if (j == i) continue;
      const Vector3d w = planes[j].n - planes[i].n;
      const double b = planes[j].d - planes[i].d;
      const int inside = count_inside(w, b);
      if (inside == 0) {
        polygon.size = 0;
      } else if (inside < facet.size) {
        polygon = Clip(polygon, w, b, j);
      }
    }
    if (polygon.size > 0 && count_inside(planes[i].n, planes[i].d) < facet.size) {
      polygon = Clip(polygon, planes[i].n, planes[i].d, -1);
    }
    if (polygon.size < 3) continue;
    Region region;
    region.frame = {polygon.corner[0], {}, {}, n};
    region.frame.t = n.unitOrthogonal();
    region.frame.m = n.cross(region.frame.t);
    const PlaneFrame& f = region.frame;
    region.moments = CalcPolygonMoments(Flatten(polygon, f));
    if (!(region.moments.area() > 0.0)) continue;
    region.field.e << planes[i].d - planes[i].n.dot(f.o), -planes[i].n.dot(f.t), -planes[i].n.dot(f.m), 0.0, 0.0, 0.0;
    region.field.gradient << -planes[i].n, Vector3d::Zero(), Vector3d::Zero();
    for (int k = 0; k < polygon.size; ++k) {
      region.depth = std::max(region.depth, planes[i].d - planes[i].n.dot(polygon.corner[k]));
      if (polygon.wall[k] < 0) continue;
      const Vector3d w = planes[polygon.wall[k]].n - planes[i].n;
      const double in_plane = (w - w.dot(n) * n).norm();
      if (in_plane < kAlongWall) continue;
      region.walls[region.num_walls++] = {f.Locate(polygon.corner[k]), f.Locate(polygon.corner[(k + 1) % polygon.size]),
                                          w, in_plane};
    }
    use(i, region);
  }
}

// The field of one end's sphere (axial false) or of the cylinder between the ends.
bool MakeRoundRegion(const SpacePolygon& polygon, const Vector3d& n, const RoundField& field, const Vector3d& c,
                     bool axial, Region* region) {
  if (polygon.size < 3) return false;
  const double r = field.radius;
  const double h = n.dot(polygon.corner[0] - c);
  if (std::abs(h) >= r && !axial) return false;
  PlaneFrame& f = region->frame;
  f.n = n;
  f.o = c + h * n;  // the foot of c
  const double upright = axial ? field.axis.dot(n) : 1.0;
  const Vector3d along = field.axis - upright * n;
  const double length = axial ? along.norm() : 0.0;
  f.t = length > 1e-12 ? Vector3d(along / length) : n.unitOrthogonal();
  f.m = n.cross(f.t);
  Conic conic{r * r, upright, h * length};
  if (!axial) conic = {r * r - h * h, 1.0, 0.0};
  region->moments = CalcConicMoments(Flatten(polygon, f), conic);
  if (!(region->moments.area() > 0.0)) return false;
  Matrix3d P = Matrix3d::Identity();
  if (axial) P -= field.axis * field.axis.transpose();
  const Vector3d off = P * (f.o - c);
  const Vector3d Pt = P * f.t;
  const Vector3d Pm = P * f.m;
  region->field.e << r * r - off.squaredNorm(), -2.0 * off.dot(f.t), -2.0 * off.dot(f.m), -Pt.dot(f.t),
      -2.0 * Pt.dot(f.m), -Pm.dot(f.m);
  region->field.e /= 2.0 * r;
  region->field.gradient << -off / r, -Pt / r, -Pm / r;
  // Estimated from the mean e over the region: a paraboloid's peak is twice that, a ridge's 1.5 times.
  const double mean = region->field.e.dot(region->moments.MakeGram().col(0)) / region->moments.area();
  region->depth = std::min(2.0 * mean, 0.5 * r);
  return true;
}

template <class Use>
void ForRegions(const Facet& facet, const Vector3d& n, const RoundField& field, const Use& use) {
  const SpacePolygon whole = MakePolygon(facet);
  Region region;
  if (field.half_length == 0.0) {
    if (MakeRoundRegion(whole, n, field, field.center, false, &region)) use(0, region);
    return;
  }
  const double at = field.axis.dot(field.center);
  for (const double end : {1.0, -1.0}) {
    const SpacePolygon cap = Clip(whole, -end * field.axis, -(end * at + field.half_length), -1);
    const Vector3d c = field.center + end * field.half_length * field.axis;
    region.num_walls = 0;
    if (MakeRoundRegion(cap, n, field, c, false, &region)) use(0, region);
  }
  const SpacePolygon middle =
      Clip(Clip(whole, field.axis, at + field.half_length, -1), -field.axis, -(at - field.half_length), -1);
  if (MakeRoundRegion(middle, n, field, field.center, true, &region)) use(0, region);
}

template <class Use>
void ForRegions(const Facet& facet, const DepthField& field, const Use& use) {
  const Vector3d area = (facet.corner[1] - facet.corner[0]).cross(facet.corner[2] - facet.corner[0]);
  const double size = area.norm();
  if (!(size > 0.0)) return;
  const Vector3d n = area / size;
  std::visit([&](const auto& f) { ForRegions(facet, n, f, use); }, field);
}

// The three last integrals of a region.
struct Weights {
  double W;
  Vector3d m1;
  Matrix3d m2;
};
Weights CalcWeights(const PlaneFrame& f, const Vector6d& by_monomial) {
  const Vector3d first = by_monomial(1) * f.t + by_monomial(2) * f.m;
  const Matrix3d second = by_monomial(3) * f.t * f.t.transpose() + by_monomial(5) * f.m * f.m.transpose() +
                          by_monomial(4) * (f.t * f.m.transpose() + f.m * f.t.transpose());
  const Matrix3d mixed = f.o * first.transpose();
  return {by_monomial(0), by_monomial(0) * f.o + first,
          by_monomial(0) * f.o * f.o.transpose() + mixed + mixed.transpose() + second};
}

// Over each inner wall's edge, at Gauss's points: use(s, w, e dl/|w_t|).
template <class Use>
void ForWalls(const Region& region, const Use& use) {
  for (int k = 0; k < region.num_walls; ++k) {
    const Region::WallEdge& wall = region.walls[k];
    const Vector2d d = wall.end - wall.begin;
    for (int g = 0; g < 3; ++g) {
      const Vector2d s = wall.begin + kEdgeAt[g] * d;
      const double e = region.field.e.dot(Monomials(s));
      use(s, wall.w, e * kEdgeWeight[g] * d.norm() / wall.in_plane);
    }
  }
}

// ∫ (∂e/∂xi) s^α dA and the walls' part: rows the perturbation (rotation, translation), columns the monomials.
Matrix6d CalcRates(const Region& region, const Matrix6d& gram) {
  const PlaneFrame& f = region.frame;
  const Vector3d G0 = region.field.gradient.col(0);
  const Vector3d Gu = region.field.gradient.col(1);
  const Vector3d Gw = region.field.gradient.col(2);
  Matrix6d rates;
  rates.topRows<3>() << f.o.cross(G0), f.t.cross(G0) + f.o.cross(Gu), f.m.cross(G0) + f.o.cross(Gw), f.t.cross(Gu),
      f.t.cross(Gw) + f.m.cross(Gu), f.m.cross(Gw);
  rates.bottomRows<3>() << G0, Gu, Gw, Matrix3d::Zero();
  Matrix6d out = rates * gram;
  ForWalls(region, [&](const Vector2d& s, const Vector3d& w, double e_dl) {
    const Vector3d x = f.o + s.x() * f.t + s.y() * f.m;
    Vector6d flow;
    flow << x.cross(w), w;
    out -= e_dl * flow * Monomials(s).transpose();
  });
  return out;
}

}  // namespace

int CountCells(const DepthField& field) {
  const auto* polyhedron = std::get_if<PolyhedralField>(&field);
  return polyhedron == nullptr ? 1 : static_cast<int>(polyhedron->planes.size());
}

void AddFacet(const Facet& facet, const DepthField& field, std::vector<PatchIntegrals>* patches,
              std::vector<PatchJacobian>* jacobians) {
  ForRegions(facet, field, [&](int cell, const Region& region) {
    const PlaneFrame& f = region.frame;
    const Matrix6d gram = region.moments.MakeGram();
    const Weights sum = CalcWeights(f, gram * region.field.e);
    PatchIntegrals& patch = (*patches)[static_cast<std::size_t>(cell)];
    patch.F -= sum.W * f.n;
    patch.M -= sum.m1.cross(f.n);
    patch.W += sum.W;
    patch.m1 += sum.m1;
    patch.m2 += sum.m2;
    patch.depth = std::max(patch.depth, region.depth);
    if (jacobians == nullptr) return;
    PatchJacobian& jacobian = (*jacobians)[static_cast<std::size_t>(cell)];
    const Matrix6d rates = CalcRates(region, gram);
    for (int k = 0; k < 6; ++k) {
      const Weights rate = CalcWeights(f, rates.row(k).transpose());
      jacobian.col(k).segment<3>(0) -= rate.W * f.n;
      jacobian.col(k).segment<3>(3) -= rate.m1.cross(f.n);
      jacobian(6, k) += rate.W;
      jacobian.col(k).segment<3>(7) += rate.m1;
      AddSymmetric(rate.m2, k, &jacobian);
    }
  });
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

void PullBackFacet(const Facet& triangle, const DepthField& field, const std::vector<PatchCotangent>& bar,
                   std::array<Vector3d, 3>* bar_corners) {
  const std::array<Vector3d, 4>& x = triangle.corner;
  ForRegions(triangle, field, [&](int cell, const Region& region) {
    const PatchCotangent& b = bar[static_cast<std::size_t>(cell)];
    const PlaneFrame& f = region.frame;
    const Vector3d& n = f.n;
    // The sum is ∫ e ψ dA with ψ = c + L·x + xᵀ B x on this facet.
    const double c = b.W - b.F.dot(n);
    const Vector3d L = b.m1 - n.cross(b.M);
    const Matrix3d& B = b.m2;
    const Vector3d Bo = B * f.o;
    Vector6d psi;
    psi << c + L.dot(f.o) + f.o.dot(Bo), L.dot(f.t) + 2.0 * Bo.dot(f.t), L.dot(f.m) + 2.0 * Bo.dot(f.m),
        f.t.dot(B * f.t), 2.0 * f.t.dot(B * f.m), f.m.dot(B * f.m);
    Matrix3d psi_gradient;
    psi_gradient << L + 2.0 * Bo, 2.0 * B * f.t, 2.0 * B * f.m;

    // Barycentric coordinates, each over 1, u, w: rows of the inverse of [1; u; w] of the corners.
    Matrix3d corners;
    for (int i = 0; i < 3; ++i) corners.col(i) << 1.0, f.Locate(x[i]);
    const Matrix3d barycentric = corners.inverse();

    const Matrix6d gram = region.moments.MakeGram();
    const auto products = [](const Vector6d& v) {
      return (Matrix3d() << v(0), v(1), v(2), v(1), v(3), v(4), v(2), v(4), v(5)).finished();
    };
    const Vector6d by_e = gram * region.field.e;
    const Matrix3d H = region.field.gradient * products(gram * psi) + psi_gradient * products(by_e);
    const Weights sum = CalcWeights(f, by_e);
    // Normal and area: both are the triangle's vector area.
    const double psi_s = b.W * sum.W + b.m1.dot(sum.m1) + b.m2.cwiseProduct(sum.m2).sum();
    const double twice_area = (x[1] - x[0]).cross(x[2] - x[0]).norm();
    const Vector3d by_area = (psi_s * n - sum.W * b.F - b.M.cross(sum.m1)) / twice_area;
    for (int i = 0; i < 3; ++i) {
      (*bar_corners)[i] += H * barycentric.row(i).transpose() + (x[(i + 1) % 3] - x[(i + 2) % 3]).cross(by_area);
    }
    ForWalls(region, [&](const Vector2d& s, const Vector3d& w, double e_dl) {
      const double flow = e_dl * psi.dot(Monomials(s));
      const Vector3d phi = barycentric * Vector3d(1.0, s.x(), s.y());
      for (int i = 0; i < 3; ++i) (*bar_corners)[i] -= phi(i) * flow * w;
    });
  });
}

}  // namespace knap
