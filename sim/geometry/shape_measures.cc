#include "sim/geometry/shape_measures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "sim/geometry/mass_properties.h"

namespace knap {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Cosines below which faces that open at almost a right angle are not looked at: their w is of no weight.
constexpr double kLeastWallFacing = 1e-3;

// A triangle, and cotangents of its unit normal and area taken to its corners.
struct Face {
  Face(const TriangleMesh& mesh, const Vector3i& t) : corners(t) {
    const Vector3d& a = mesh.vertices[t[0]];
    u = mesh.vertices[t[1]] - a;
    v = mesh.vertices[t[2]] - a;
    const Vector3d cross = u.cross(v);
    twice_area = cross.norm();
    normal = cross / twice_area;
  }

  void PullBack(const Vector3d& bar_normal, double bar_twice_area, Matrix3Xd* bar) const {
    const Vector3d bar_cross = (bar_normal - normal * normal.dot(bar_normal)) / twice_area + bar_twice_area * normal;
    const Vector3d bar_u = v.cross(bar_cross);
    const Vector3d bar_v = bar_cross.cross(u);
    bar->col(corners[0]) -= bar_u + bar_v;
    bar->col(corners[1]) += bar_u;
    bar->col(corners[2]) += bar_v;
  }

  Vector3i corners;
  Vector3d u, v, normal;
  double twice_area = 0.0;
};

struct Wall {
  int from = 0, to = 0;  // triangles
  double w = 0.0;        // [m]
};

Vector3d CalcCenter(const TriangleMesh& mesh, const Vector3i& t) {
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
}

std::vector<Wall> FindWalls(const TriangleMesh& mesh) {
  const RayCaster caster(mesh);
  std::vector<Wall> walls;
  std::vector<int> scratch;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    const Vector3i& t = mesh.triangles[static_cast<std::size_t>(i)];
    const Vector3d inward = -Face(mesh, t).normal;
    const auto hit = caster.FindNext(CalcCenter(mesh, t), inward, i, RayCaster::Crossing::kLeaving, &scratch);
    if (hit && hit->facing > kLeastWallFacing) walls.push_back({i, hit->triangle, CalcWall(*hit)});
  }
  return walls;
}

// Adds bar · dw/dvertices. With s = m·(x − p), x a corner of the triangle that is met: w = s / (−n·m)³.
void PullBackWall(const TriangleMesh& mesh, const Wall& wall, double bar, Matrix3Xd* out) {
  const Vector3i& from = mesh.triangles[static_cast<std::size_t>(wall.from)];
  const Vector3i& to = mesh.triangles[static_cast<std::size_t>(wall.to)];
  const Face near(mesh, from);
  const Face far(mesh, to);
  const Vector3d way = mesh.vertices[to[0]] - CalcCenter(mesh, from);
  const double c = -near.normal.dot(far.normal);
  const double s = far.normal.dot(way);
  const double bar_s = bar / (c * c * c);
  const double bar_c = -3.0 * bar * s / (c * c * c * c);
  const Vector3d bar_way = bar_s * far.normal;
  out->col(to[0]) += bar_way;
  for (int k = 0; k < 3; ++k) out->col(from[k]) -= bar_way / 3.0;
  far.PullBack(bar_s * way - bar_c * near.normal, 0.0, out);
  near.PullBack(-bar_c * far.normal, 0.0, out);
}

Matrix3Xd MakeZero(const TriangleMesh& mesh) { return Matrix3Xd::Zero(3, static_cast<Index>(mesh.vertices.size())); }

}  // namespace

ShapeMeasure MeasureVolume(const TriangleMesh& mesh) {
  MassProperties bar;
  bar.mass = 1.0;
  return {CalcSignedVolume(mesh), PullBackMassProperties(mesh, 1.0, bar)};
}

ShapeMeasure MeasureExtent(const TriangleMesh& mesh, int axis) {
  const auto less = [axis](const Vector3d& a, const Vector3d& b) { return a[axis] < b[axis]; };
  const auto low = std::min_element(mesh.vertices.begin(), mesh.vertices.end(), less);
  const auto high = std::max_element(mesh.vertices.begin(), mesh.vertices.end(), less);
  ShapeMeasure out{(*high)[axis] - (*low)[axis], MakeZero(mesh)};
  out.gradient(axis, high - mesh.vertices.begin()) += 1.0;
  out.gradient(axis, low - mesh.vertices.begin()) -= 1.0;
  return out;
}

ShapeMeasure MeasureThickness(const TriangleMesh& mesh, double blend) {
  const std::vector<Wall> walls = FindWalls(mesh);
  ShapeMeasure out{std::numeric_limits<double>::infinity(), MakeZero(mesh)};
  if (walls.empty()) return out;
  double least = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) least = std::min(least, wall.w);
  double sum = 0.0, weighted = 0.0;  // relative to the least, which saves digits
  std::vector<Face> faces;
  std::vector<double> shares;
  for (const Wall& wall : walls) {
    faces.emplace_back(mesh, mesh.triangles[static_cast<std::size_t>(wall.from)]);
    shares.push_back(std::exp((least - wall.w) / blend));
    const double weight = faces.back().twice_area * shares.back();
    sum += weight;
    weighted += weight * (wall.w - least);
  }
  const double above = weighted / sum;
  out.value = least + above;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const double share = shares[i] / sum;
    if (share == 0.0) continue;
    const double beyond = walls[i].w - least - above;
    faces[i].PullBack(Vector3d::Zero(), share * beyond, &out.gradient);
    PullBackWall(mesh, walls[i], faces[i].twice_area * share * (1.0 - beyond / blend), &out.gradient);
  }
  return out;
}

}  // namespace knap
