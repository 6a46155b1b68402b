#include "sim/contact/facet_regions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// A wall that the facet's plane meets under less than this angle has no trace on it [rad].
constexpr double kAlongWall = 1e-9;

using Linear = LinearOnPlane;

// Of n·x on the plane.
Linear Project(const Vector3d& n, const PlaneFrame& frame) { return {n.dot(frame.o), n.dot(frame.t), n.dot(frame.m)}; }

// The depth under one plane of the field.
Linear ProjectDepth(const FieldPlane& plane, const PlaneFrame& frame) {
  return Linear{plane.d, 0.0, 0.0} - Project(plane.n, frame);
}

// A convex polygon; wall k: the inner wall of a cell that edge k lies on, −1 where it is the facet's own or on the
// field's surface.
struct WalledPolygon : PlanePolygon {
  std::array<int, kMaxCorners> wall;
  void Push(const Vector2d& s, int on) {
    corner[size] = s;
    wall[size++] = on;
  }
};

WalledPolygon MakePolygon(const Facet& facet) {
  WalledPolygon polygon;
  for (int k = 0; k < facet.size; ++k) polygon.Push(facet.corner[k], -1);
  return polygon;
}

// The part inside ≥ 0 [Sutherland & Hodgman 1974]; the new edge lies on `wall`.
void Clip(const Linear& inside, int wall, WalledPolygon* polygon) {
  if (polygon->size == 0) return;
  std::array<double, PlanePolygon::kMaxCorners> at;
  bool all = true;
  for (int k = 0; k < polygon->size; ++k) {
    at[k] = inside.At(polygon->corner[k]);
    all = all && at[k] >= 0.0;
  }
  if (all) return;
  WalledPolygon out;
  for (int k = 0; k < polygon->size; ++k) {
    const int next = k + 1 < polygon->size ? k + 1 : 0;
    const Vector2d& x = polygon->corner[k];
    if (at[k] >= 0.0) out.Push(x, polygon->wall[k]);
    if ((at[k] >= 0.0) != (at[next] >= 0.0)) {
      const double t = at[k] / (at[k] - at[next]);
      out.Push(x + t * (polygon->corner[next] - x), at[k] >= 0.0 ? wall : polygon->wall[k]);
    }
  }
  *polygon = out;
}

void CutFacet(int number, const Facet& facet, const PolyhedralField& field, FacetRegions* out) {
  const int planes = static_cast<int>(field.planes.size());
  std::vector<Linear>& depth = out->depth;
  std::vector<std::array<double, Facet::kMaxCorners>>& at = out->at;
  depth.clear();
  at.clear();
  for (const FieldPlane& plane : field.planes) {
    const Linear e = ProjectDepth(plane, facet.frame);
    bool outside = true;
    std::array<double, Facet::kMaxCorners>& at_corner = at.emplace_back();
    for (int k = 0; k < facet.size; ++k) {
      at_corner[k] = e.At(facet.corner[k]);
      outside = outside && at_corner[k] <= 0.0;
    }
    if (outside) return;
    depth.push_back(e);
  }
  // At how many corners plane j is nearer than plane i: all, and the facet has nothing in cell i; none, and j cuts
  // nothing off there.
  const auto count_nearer = [&](int j, int i) {
    int count = 0;
    for (int k = 0; k < facet.size; ++k) count += at[j][k] < at[i][k] ? 1 : 0;
    return count;
  };
  for (int i = 0; i < planes; ++i) {
    bool empty = false;
    for (int j = 0; j < planes && !empty; ++j) empty = count_nearer(j, i) == facet.size;
    if (empty) continue;
    const Linear& e = depth[i];
    WalledPolygon polygon = MakePolygon(facet);
    for (int j = 0; j < planes && polygon.size > 0; ++j) {
      if (count_nearer(j, i) > 0) Clip(depth[j] - e, j, &polygon);
    }
    Clip(e, -1, &polygon);
    if (polygon.size < 3) continue;

    const Vector2d origin = polygon.corner[0];
    for (int k = 0; k < polygon.size; ++k) polygon.corner[k] -= origin;
    const PlanarMoments moments = CalcPolygonMoments(polygon);
    if (!(moments.area() > 0.0)) continue;
    FacetRegion& region = out->regions.emplace_back();
    region.facet = number;
    region.cell = i;
    region.frame = facet.frame;
    region.frame.o = facet.frame.Place(origin);
    region.moments = moments;
    const double e0 = e.At(origin);
    region.field.e << e0, e.b, e.c, 0.0, 0.0, 0.0;
    region.field.gradient << -field.planes[i].n, Vector3d::Zero(), Vector3d::Zero();
    region.field.linear = true;
    region.first_wall = static_cast<int>(out->walls.size());
    for (int k = 0; k < polygon.size; ++k) {
      region.depth = std::max(region.depth, e0 + e.b * polygon.corner[k].x() + e.c * polygon.corner[k].y());
      if (polygon.wall[k] < 0) continue;
      const Vector3d w = field.planes[polygon.wall[k]].n - field.planes[i].n;
      const double in_plane = std::hypot(w.dot(facet.frame.t), w.dot(facet.frame.m));
      if (in_plane < kAlongWall) continue;
      const int next = k + 1 < polygon.size ? k + 1 : 0;
      out->walls.push_back({polygon.corner[k], polygon.corner[next], w, in_plane});
    }
    region.num_walls = static_cast<int>(out->walls.size()) - region.first_wall;
  }
}

// The plane's own coordinates about a centre c: the origin at its foot, u along the axis's trace.
struct RoundCoordinates {
  double h = 0.0;        // of the plane above c, along its normal
  double upright = 0.0;  // the axis's part along the normal
  double length = 0.0;   // and in the plane, ≥ 0
  Vector2d foot, turn;

  RoundCoordinates(const PlaneFrame& plane, const Vector3d& c, const Vector3d& axis)
      : h(plane.n.dot(plane.o - c)), upright(axis.dot(plane.n)), foot(plane.Locate(c)) {
    const Vector2d along(axis.dot(plane.t), axis.dot(plane.m));
    length = along.norm();
    turn = length > 1e-12 ? Vector2d(along / length) : Vector2d::UnitX();
  }
  PlanePolygon Turn(const WalledPolygon& polygon) const {
    PlanePolygon out;
    out.size = polygon.size;
    for (int k = 0; k < polygon.size; ++k) {
      const Vector2d s = polygon.corner[k] - foot;
      out.corner[k] = {turn.dot(s), turn.x() * s.y() - turn.y() * s.x()};
    }
    return out;
  }
  PlaneFrame Turn(const PlaneFrame& plane, const Vector3d& c) const {
    return {c + h * plane.n, turn.x() * plane.t + turn.y() * plane.m, turn.x() * plane.m - turn.y() * plane.t, plane.n};
  }
};

// (r² − |P (x − c)|²)/(2 r) on a plane.
FieldOnPlane MakeRoundField(const PlaneFrame& f, const Vector3d& c, const Matrix3d& P, double r) {
  FieldOnPlane out;
  const Vector3d off = P * (f.o - c);
  const Vector3d Pt = P * f.t;
  const Vector3d Pm = P * f.m;
  out.e << r * r - off.squaredNorm(), -2.0 * off.dot(f.t), -2.0 * off.dot(f.m), -Pt.dot(f.t), -2.0 * Pt.dot(f.m),
      -Pm.dot(f.m);
  out.e /= 2.0 * r;
  out.gradient << -off / r, -Pt / r, -Pm / r;
  return out;
}

FacetRegion* AddRoundRegion(int number, const PlanarMoments& moments, const PlaneFrame& frame,
                            const FieldOnPlane& field, FacetRegions* out) {
  if (!(moments.area() > 0.0)) return nullptr;
  FacetRegion& region = out->regions.emplace_back();
  region.facet = number;
  region.frame = frame;
  region.field = field;
  region.moments = moments;
  return &region;
}

Matrix3d ProjectAcross(const Vector3d& axis) { return Matrix3d::Identity() - axis * axis.transpose(); }

// The field of one end's sphere (axial false) or of the cylinder between the ends.
FacetRegion* CutRound(int number, const PlaneFrame& plane, const WalledPolygon& polygon, double r, const Vector3d& axis,
                      const Vector3d& c, bool axial, FacetRegions* out) {
  if (polygon.size < 3) return nullptr;
  if (!axial && std::abs(plane.n.dot(plane.o - c)) >= r) return nullptr;
  const RoundCoordinates at(plane, c, axial ? axis : Vector3d::Zero());
  const Conic conic =
      axial ? Conic::Around(r * r, at.upright, at.h * at.length) : Conic::Around(r * r - at.h * at.h, 1.0, 0.0);
  const PlaneFrame frame = at.Turn(plane, c);
  FacetRegion* region =
      AddRoundRegion(number, CalcConicMoments(at.Turn(polygon), conic), frame,
                     MakeRoundField(frame, c, axial ? ProjectAcross(axis) : Matrix3d(Matrix3d::Identity()), r), out);
  if (region == nullptr) return nullptr;
  // Estimated from the mean e over the region: a paraboloid's peak is twice that, a ridge's 1.5 times.
  const double mean = region->field.e.dot(region->moments.MakeGram().col(0)) / region->moments.area();
  region->depth = std::min(2.0 * mean, 0.5 * r);
  return region;
}

void CutFacet(int number, const Facet& facet, const RoundField& field, FacetRegions* out) {
  const WalledPolygon whole = MakePolygon(facet);
  if (field.half_length == 0.0) {
    CutRound(number, facet.frame, whole, field.radius, field.axis, field.center, false, out);
    return;
  }
  // How far a point lies beyond the middle, along the axis.
  const Linear along = Project(field.axis, facet.frame) - Linear{field.axis.dot(field.center), 0.0, 0.0};
  const Linear half{field.half_length, 0.0, 0.0};
  const Linear back = Linear{} - along;
  for (const double end : {1.0, -1.0}) {
    WalledPolygon cap = whole;
    Clip((end > 0.0 ? along : back) - half, -1, &cap);
    const Vector3d center = field.center + end * field.half_length * field.axis;
    CutRound(number, facet.frame, cap, field.radius, field.axis, center, false, out);
  }
  WalledPolygon middle = whole;
  Clip(half - along, -1, &middle);
  Clip(half - back, -1, &middle);
  CutRound(number, facet.frame, middle, field.radius, field.axis, field.center, true, out);
}

double CalcDepth(const CylinderField& field, const Vector3d& x) {
  const Vector3d d = x - field.center;
  const double along = field.axis.dot(d);
  const double across2 = d.squaredNorm() - along * along;
  return std::min((field.radius * field.radius - across2) / (2.0 * field.radius), field.half_length - std::abs(along));
}

// e is concave on the facet: the largest of its values at the corners, at their middle and where the plane is nearest
// to the axis, which is at most the peak and, but for slanted small facets, near it.
double EstimateDepth(const CylinderField& field, const PlaneFrame& plane, const WalledPolygon& polygon) {
  double depth = 0.0;
  Vector2d middle = Vector2d::Zero();
  for (int k = 0; k < polygon.size; ++k) {
    depth = std::max(depth, CalcDepth(field, plane.Place(polygon.corner[k])));
    middle += polygon.corner[k] / polygon.size;
  }
  depth = std::max(depth, CalcDepth(field, plane.Place(middle)));
  // The axis meets the plane, or runs beside it.
  const double upright = field.axis.dot(plane.n);
  const double h = plane.n.dot(plane.o - field.center);
  const double along = std::abs(upright) > 1e-6 ? std::clamp(h / upright, -field.half_length, field.half_length) : 0.0;
  Vector3d x = field.center + along * field.axis;
  x -= plane.n.dot(x - plane.o) * plane.n;
  const Vector2d s = plane.Locate(x);
  for (int k = 0; k < polygon.size; ++k) {
    const Vector2d edge = polygon.corner[(k + 1) % polygon.size] - polygon.corner[k];
    const Vector2d to = s - polygon.corner[k];
    if (edge.x() * to.y() - edge.y() * to.x() < 0.0) return depth;
  }
  return std::max(depth, CalcDepth(field, x));
}

// Where the depth under the end `end` (±1) is less than that under the side, the difference of the two, l − q ≤ 0, is
// added: it is zero on the curve where they are equal.
void CutEnd(int number, const PlaneFrame& plane, const WalledPolygon& polygon, const CylinderField& field, double end,
            FacetRegions* out) {
  // An ellipse longer than this many times its width is taken for open: the facet's part under the end reaches over at
  // most r/2 along the axis, and sees its nearer vertex alone.
  constexpr double kOpen = 0.1;
  if (polygon.size < 3) return;
  const double r = field.radius;
  const double H = field.half_length;
  const RoundCoordinates at(plane, field.center, field.axis);
  const double beta = at.h * at.length;
  // 2 r (q − l) with l = H − end (h upright + u length).
  Conic conic = Conic::Around(r * r, at.upright, beta);
  conic.c += 2.0 * r * (end * at.h * at.upright - H);
  conic.b += r * end * at.length;
  conic.is_open = std::abs(at.upright) < kOpen;
  const PlaneFrame frame = at.Turn(plane, field.center);
  FieldOnPlane e = MakeRoundField(frame, field.center, ProjectAcross(field.axis), r);
  e.e *= -1.0;
  e.gradient *= -1.0;
  e.e(0) += H - end * field.axis.dot(frame.o - field.center);
  e.e(1) -= end * field.axis.dot(frame.t);
  e.e(2) -= end * field.axis.dot(frame.m);
  e.gradient.col(0) -= end * field.axis;
  AddRoundRegion(number, CalcConicMoments(at.Turn(polygon), conic), frame, e, out);
}

void CutFacet(int number, const Facet& facet, const CylinderField& field, FacetRegions* out) {
  const Linear along = Project(field.axis, facet.frame) - Linear{field.axis.dot(field.center), 0.0, 0.0};
  const Linear half{field.half_length, 0.0, 0.0};
  const Linear back = Linear{} - along;
  WalledPolygon inside = MakePolygon(facet);
  Clip(half - along, -1, &inside);
  Clip(half - back, -1, &inside);
  FacetRegion* side = CutRound(number, facet.frame, inside, field.radius, field.axis, field.center, true, out);
  if (side == nullptr) return;
  side->depth = EstimateDepth(field, facet.frame, inside);
  // Under the side e is at most r/2: nearer to the middle than that no end is nearer than the side.
  const Linear from{std::max(0.0, field.half_length - 0.5 * field.radius), 0.0, 0.0};
  for (const double end : {1.0, -1.0}) {
    WalledPolygon near_end = inside;
    Clip((end > 0.0 ? along : back) - from, -1, &near_end);
    CutEnd(number, facet.frame, near_end, field, end, out);
  }
}

}  // namespace

Facet Facet::Make(std::span<const Vector3d> corners) {
  Facet facet;
  const Vector3d area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double size = area.norm();
  PlaneFrame& f = facet.frame;
  f = {corners[0], Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  if (!(size > 0.0)) return facet;
  f.n = area / size;
  f.t = f.n.unitOrthogonal();
  f.m = f.n.cross(f.t);
  facet.size = static_cast<int>(corners.size());
  for (int k = 0; k < facet.size; ++k) facet.corner[k] = f.Locate(corners[k]);
  return facet;
}

Facet Move(const Pose& X, const Facet& facet) {
  Facet out = facet;
  out.frame = {X * facet.frame.o, X.R * facet.frame.t, X.R * facet.frame.m, X.R * facet.frame.n};
  return out;
}

int CountCells(const DepthField& field) {
  const auto* polyhedron = std::get_if<PolyhedralField>(&field);
  return polyhedron == nullptr ? 1 : static_cast<int>(polyhedron->planes.size());
}

void CutFacet(int number, const Facet& facet, const DepthField& field, FacetRegions* out) {
  if (facet.size == 0) return;
  std::visit([&](const auto& f) { CutFacet(number, facet, f, out); }, field);
}

}  // namespace knap
