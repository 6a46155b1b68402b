#include "sim/contact/facet_regions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

void StartPolygon(const Facet& facet, WalledPolygon* polygon) {
  polygon->clear();
  for (int k = 0; k < facet.size; ++k) polygon->Push(facet.corner[k], -1);
}

// Leaves of out->polygon the part inside ≥ 0 [Sutherland & Hodgman 1974]; the new edge lies on `wall`.
void Clip(const Linear& inside, int wall, FacetRegions* out) {
  WalledPolygon& polygon = out->polygon;
  if (std::all_of(polygon.corner.begin(), polygon.corner.end(),
                  [&](const Vector2d& x) { return inside.At(x) >= 0.0; })) {
    return;
  }
  std::vector<double>& at = out->inside;
  at.clear();
  for (const Vector2d& x : polygon.corner) at.push_back(inside.At(x));
  out->clipped.clear();
  for (int k = 0; k < polygon.size(); ++k) {
    const int next = k + 1 < polygon.size() ? k + 1 : 0;
    const Vector2d& x = polygon.corner[k];
    if (at[k] >= 0.0) out->clipped.Push(x, polygon.wall[k]);
    if ((at[k] >= 0.0) != (at[next] >= 0.0)) {
      const double t = at[k] / (at[k] - at[next]);
      out->clipped.Push(x + t * (polygon.corner[next] - x), at[k] >= 0.0 ? wall : polygon.wall[k]);
    }
  }
  std::swap(polygon, out->clipped);
}

// At how many corners plane a is nearer than plane b.
int CountNearer(const FacetDepth& a, const FacetDepth& b, int corners) {
  if (a.least >= b.most) return 0;
  int count = 0;
  for (int k = 0; k < corners; ++k) count += a.at[k] < b.at[k] ? 1 : 0;
  return count;
}

void CutFacet(int number, const Facet& facet, const PolyhedralField& field, FacetRegions* out) {
  std::vector<FacetDepth>& depths = out->depths;
  depths.clear();
  // Some plane is at most this far from all of the facet.
  double reach = std::numeric_limits<double>::infinity();
  for (const FieldPlane& plane : field.planes) {
    FacetDepth& depth = depths.emplace_back();
    depth.e = ProjectDepth(plane, facet.frame);
    for (int k = 0; k < facet.size; ++k) depth.at[k] = depth.e.At(facet.corner[k]);
    const auto [least, most] = std::minmax_element(depth.at.begin(), depth.at.begin() + facet.size);
    depth.least = *least;
    depth.most = *most;
    if (depth.most <= 0.0) return;
    reach = std::min(reach, depth.most);
  }
  // Of many planes most are farther from the facet than another is: nothing of it lies in their cells.
  std::vector<int>& near = out->near;
  near.clear();
  const int planes = static_cast<int>(depths.size());
  for (int i = 0; i < planes; ++i) {
    if (depths[i].least <= reach) near.push_back(i);
  }
  for (const int i : near) {
    const auto is_nearer = [&](int j) { return CountNearer(depths[j], depths[i], facet.size) == facet.size; };
    if (std::any_of(near.begin(), near.end(), is_nearer)) continue;
    const Linear& e = depths[i].e;
    WalledPolygon& polygon = out->polygon;
    StartPolygon(facet, &polygon);
    // What is nowhere nearer than plane i cuts nothing off.
    for (int j = 0; j < planes && polygon.size() > 0; ++j) {
      if (CountNearer(depths[j], depths[i], facet.size) > 0) Clip(depths[j].e - e, j, out);
    }
    Clip(e, -1, out);
    if (polygon.size() < 3) continue;

    const Vector2d origin = polygon.corner[0];
    for (Vector2d& x : polygon.corner) x -= origin;
    const PlanarMoments moments = CalcPolygonMoments(polygon.corner);
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
    for (int k = 0; k < polygon.size(); ++k) {
      const double depth = e0 + e.b * polygon.corner[k].x() + e.c * polygon.corner[k].y();
      if (depth > region.depth) {
        region.depth = depth;
        region.peak = polygon.corner[k];
      }
      if (polygon.wall[k] < 0) continue;
      const Vector3d w = field.planes[polygon.wall[k]].n - field.planes[i].n;
      const double in_plane = std::hypot(w.dot(facet.frame.t), w.dot(facet.frame.m));
      if (in_plane < kAlongWall) continue;
      const int next = k + 1 < polygon.size() ? k + 1 : 0;
      out->walls.push_back({polygon.wall[k], polygon.corner[k], polygon.corner[next], w, in_plane});
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
  void Turn(const WalledPolygon& polygon, std::vector<Vector2d>* out) const {
    out->clear();
    for (const Vector2d& x : polygon.corner) {
      const Vector2d s = x - foot;
      out->emplace_back(turn.dot(s), turn.x() * s.y() - turn.y() * s.x());
    }
  }
  PlaneFrame Turn(const PlaneFrame& plane, const Vector3d& c) const {
    return {c + h * plane.n, turn.x() * plane.t + turn.y() * plane.m, turn.x() * plane.m - turn.y() * plane.t, plane.n};
  }
};

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

// The field of one end's sphere (axial false) or of the cylinder between the ends, over out->polygon.
FacetRegion* CutRound(int number, const PlaneFrame& plane, double r, const Vector3d& axis, const Vector3d& c,
                      bool axial, FacetRegions* out) {
  if (out->polygon.size() < 3) return nullptr;
  if (!axial && std::abs(plane.n.dot(plane.o - c)) >= r) return nullptr;
  const RoundCoordinates at(plane, c, axial ? axis : Vector3d::Zero());
  const Conic conic =
      axial ? Conic::Around(r * r, at.upright, at.h * at.length) : Conic::Around(r * r - at.h * at.h, 1.0, 0.0);
  const PlaneFrame frame = at.Turn(plane, c);
  at.Turn(out->polygon, &out->turned);
  FacetRegion* region =
      AddRoundRegion(number, CalcConicMoments(out->turned, conic), frame,
                     MakeRoundField(frame, c, axial ? ProjectAcross(axis) : Matrix3d(Matrix3d::Identity()), r), out);
  if (region == nullptr) return nullptr;
  // Estimated from the mean e over the region: a paraboloid's peak is twice that, a ridge's 1.5 times.
  const double mean = region->field.e.dot(region->moments.MakeGram().col(0)) / region->moments.area();
  region->depth = std::min(2.0 * mean, 0.5 * r);
  return region;
}

void CutFacet(int number, const Facet& facet, const RoundField& field, FacetRegions* out) {
  StartPolygon(facet, &out->polygon);
  if (field.half_length == 0.0) {
    CutRound(number, facet.frame, field.radius, field.axis, field.center, false, out);
    return;
  }
  // How far a point lies beyond the middle, along the axis.
  const Linear along = Project(field.axis, facet.frame) - Linear{field.axis.dot(field.center), 0.0, 0.0};
  const Linear half{field.half_length, 0.0, 0.0};
  const Linear back = Linear{} - along;
  for (const double end : {1.0, -1.0}) {
    StartPolygon(facet, &out->polygon);
    Clip((end > 0.0 ? along : back) - half, -1, out);
    const Vector3d center = field.center + end * field.half_length * field.axis;
    CutRound(number, facet.frame, field.radius, field.axis, center, false, out);
  }
  StartPolygon(facet, &out->polygon);
  Clip(half - along, -1, out);
  Clip(half - back, -1, out);
  CutRound(number, facet.frame, field.radius, field.axis, field.center, true, out);
}

// e is concave on the facet: the largest of its values at the corners, at their middle and where the plane is nearest
// to the axis, which is at most the peak and, but for slanted small facets, near it.
double EstimateDepth(const CylinderField& field, const PlaneFrame& plane, const WalledPolygon& polygon) {
  double depth = 0.0;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& x : polygon.corner) {
    depth = std::max(depth, CalcDepth(field, plane.Place(x)));
    middle += x / polygon.size();
  }
  depth = std::max(depth, CalcDepth(field, plane.Place(middle)));
  // The axis meets the plane, or runs beside it.
  const double upright = field.axis.dot(plane.n);
  const double h = plane.n.dot(plane.o - field.center);
  const double along = std::abs(upright) > 1e-6 ? std::clamp(h / upright, -field.half_length, field.half_length) : 0.0;
  Vector3d x = field.center + along * field.axis;
  x -= plane.n.dot(x - plane.o) * plane.n;
  const Vector2d s = plane.Locate(x);
  for (int k = 0; k < polygon.size(); ++k) {
    const Vector2d edge = polygon.corner[(k + 1) % polygon.size()] - polygon.corner[k];
    const Vector2d to = s - polygon.corner[k];
    if (edge.x() * to.y() - edge.y() * to.x() < 0.0) return depth;
  }
  return std::max(depth, CalcDepth(field, x));
}

// Where the depth under the end `end` (±1) is less than that under the side, the difference of the two, l − q ≤ 0, is
// added over out->polygon: it is zero on the curve where they are equal.
void CutEnd(int number, const PlaneFrame& plane, const CylinderField& field, double end, FacetRegions* out) {
  // Where the axis meets the plane's normal in less than this cosine the ellipse is over ten times as long as wide, and
  // taken for open: the facet's part under the end reaches over at most r/2 along the axis, to its nearer vertex alone.
  constexpr double kOpen = 0.1;
  if (out->polygon.size() < 3) return;
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
  at.Turn(out->polygon, &out->turned);
  AddRoundRegion(number, CalcConicMoments(out->turned, conic), frame, e, out);
}

void CutFacet(int number, const Facet& facet, const CylinderField& field, FacetRegions* out) {
  const Linear along = Project(field.axis, facet.frame) - Linear{field.axis.dot(field.center), 0.0, 0.0};
  const Linear half{field.half_length, 0.0, 0.0};
  const Linear back = Linear{} - along;
  const auto start_inside = [&] {
    StartPolygon(facet, &out->polygon);
    Clip(half - along, -1, out);
    Clip(half - back, -1, out);
  };
  start_inside();
  FacetRegion* side = CutRound(number, facet.frame, field.radius, field.axis, field.center, true, out);
  if (side == nullptr) return;
  side->depth = EstimateDepth(field, facet.frame, out->polygon);
  // Under the side e is at most r/2: nearer to the middle than that no end is nearer than the side.
  const Linear from{std::max(0.0, field.half_length - 0.5 * field.radius), 0.0, 0.0};
  for (const double end : {1.0, -1.0}) {
    start_inside();
    Clip((end > 0.0 ? along : back) - from, -1, out);
    CutEnd(number, facet.frame, field, end, out);
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

void CutFacet(int number, const Facet& facet, const DepthField& field, FacetRegions* out) {
  if (facet.size == 0) return;
  std::visit([&](const auto& f) { CutFacet(number, facet, f, out); }, field);
}

}  // namespace knap
