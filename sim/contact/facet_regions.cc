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

// The field of one end's sphere (axial false) or of the cylinder between the ends.
void CutRound(int number, const PlaneFrame& plane, const WalledPolygon& polygon, const RoundField& field,
              const Vector3d& c, bool axial, FacetRegions* out) {
  if (polygon.size < 3) return;
  const double r = field.radius;
  const double h = plane.n.dot(plane.o - c);
  if (std::abs(h) >= r && !axial) return;
  // The foot of c, and the direction of the axis from it.
  const Vector2d foot(plane.t.dot(c - plane.o), plane.m.dot(c - plane.o));
  const Vector2d along = axial ? Vector2d(field.axis.dot(plane.t), field.axis.dot(plane.m)) : Vector2d::Zero();
  const double length = along.norm();
  const Vector2d turn = length > 1e-12 ? Vector2d(along / length) : Vector2d::UnitX();
  PlanePolygon turned;
  turned.size = polygon.size;
  for (int k = 0; k < polygon.size; ++k) {
    const Vector2d s = polygon.corner[k] - foot;
    turned.corner[k] = {turn.dot(s), turn.x() * s.y() - turn.y() * s.x()};
  }
  Conic conic{r * r - h * h, 1.0, 0.0};
  if (axial) {
    const double upright = field.axis.dot(plane.n);
    conic = {r * r, upright, h * length};
  }
  const PlanarMoments moments = CalcConicMoments(turned, conic);
  if (!(moments.area() > 0.0)) return;

  FacetRegion& region = out->regions.emplace_back();
  region.facet = number;
  region.cell = 0;
  PlaneFrame& f = region.frame;
  f.n = plane.n;
  f.o = c + h * plane.n;
  f.t = turn.x() * plane.t + turn.y() * plane.m;
  f.m = turn.x() * plane.m - turn.y() * plane.t;
  region.moments = moments;
  Matrix3d P = Matrix3d::Identity();
  if (axial) P -= field.axis * field.axis.transpose();
  const Vector3d off = P * (f.o - c);
  const Vector3d Pt = P * f.t;
  const Vector3d Pm = P * f.m;
  region.field.e << r * r - off.squaredNorm(), -2.0 * off.dot(f.t), -2.0 * off.dot(f.m), -Pt.dot(f.t),
      -2.0 * Pt.dot(f.m), -Pm.dot(f.m);
  region.field.e /= 2.0 * r;
  region.field.gradient << -off / r, -Pt / r, -Pm / r;
  // Estimated from the mean e over the region: a paraboloid's peak is twice that, a ridge's 1.5 times.
  const double mean = region.field.e.dot(moments.MakeGram().col(0)) / moments.area();
  region.depth = std::min(2.0 * mean, 0.5 * r);
}

void CutFacet(int number, const Facet& facet, const RoundField& field, FacetRegions* out) {
  const WalledPolygon whole = MakePolygon(facet);
  if (field.half_length == 0.0) return CutRound(number, facet.frame, whole, field, field.center, false, out);
  // How far a point lies beyond the middle, along the axis.
  const Linear along = Project(field.axis, facet.frame) - Linear{field.axis.dot(field.center), 0.0, 0.0};
  const Linear half{field.half_length, 0.0, 0.0};
  const Linear back = Linear{} - along;
  for (const double end : {1.0, -1.0}) {
    WalledPolygon cap = whole;
    Clip((end > 0.0 ? along : back) - half, -1, &cap);
    CutRound(number, facet.frame, cap, field, field.center + end * field.half_length * field.axis, false, out);
  }
  WalledPolygon middle = whole;
  Clip(half - along, -1, &middle);
  Clip(half - back, -1, &middle);
  CutRound(number, facet.frame, middle, field, field.center, true, out);
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
