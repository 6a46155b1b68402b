#include "sim/geometry/self_contact.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kMeeting = 1e-12;  // of the mesh's size

// A triangle, or one of its edges: up to three corners and the edges between them.
struct Simplex {
  std::array<Vector3d, 3> corners;
  int count = 3;

  int CountEdges() const { return count == 3 ? 3 : 1; }
  Vector3d GetEdge(int i) const { return corners[(i + 1) % count] - corners[i]; }
  Vector3d CalcNormal() const { return GetEdge(0).cross(corners[2] - corners[0]); }
};

bool Separates(const Vector3d& axis, const Simplex& a, const Simplex& b, double tolerance) {
  const Vector3d& origin = a.corners[0];  // saves digits far from the frame's own
  double low[2], high[2];
  for (int side = 0; side < 2; ++side) {
    const Simplex& simplex = side == 0 ? a : b;
    low[side] = high[side] = axis.dot(simplex.corners[0] - origin);
    for (int i = 1; i < simplex.count; ++i) {
      const double at = axis.dot(simplex.corners[i] - origin);
      low[side] = std::min(low[side], at);
      high[side] = std::max(high[side], at);
    }
  }
  return std::max(low[1] - high[0], low[0] - high[1]) > tolerance * axis.norm();
}

bool AreApart(const Simplex& a, const Simplex& b, double tolerance) {
  for (const Simplex* simplex : {&a, &b}) {
    if (simplex->count == 3 && Separates(simplex->CalcNormal(), a, b, tolerance)) return true;
  }
  // Most neighbours lie in one plane: its axes first.
  for (const Simplex* plane : {&a, &b}) {
    if (plane->count != 3) continue;
    const Vector3d normal = plane->CalcNormal();
    for (const Simplex* simplex : {&a, &b}) {
      for (int i = 0; i < simplex->CountEdges(); ++i) {
        if (Separates(normal.cross(simplex->GetEdge(i)), a, b, tolerance)) return true;
      }
    }
  }
  for (int i = 0; i < a.CountEdges(); ++i) {
    for (int j = 0; j < b.CountEdges(); ++j) {
      if (Separates(a.GetEdge(i).cross(b.GetEdge(j)), a, b, tolerance)) return true;
    }
  }
  return false;
}

class PairTest {
 public:
  explicit PairTest(const TriangleMesh& mesh) : mesh_(mesh) {
    const Eigen::AlignedBox3d box = CalcBoundingBox(mesh);
    if (box.isEmpty()) return;
    // Far from the frame's origin the coordinates themselves are rounded to more than that.
    const double farthest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    tolerance_ = kMeeting * std::max(box.diagonal().norm(), 1e-3 * farthest);
  }

  double tolerance() const { return tolerance_; }

  bool Meet(int i, int j) const {
    const Vector3i& a = mesh_.triangles[static_cast<std::size_t>(i)];
    const Vector3i& b = mesh_.triangles[static_cast<std::size_t>(j)];
    int shared = 0, in_a = 0, in_b = 0;  // corners, and where one of them stands
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) {
        if (a[k] != b[l]) continue;
        ++shared;
        in_a = k;
        in_b = l;
      }
    }
    if (shared == 0) return !AreApart(MakeTriangle(a), MakeTriangle(b), tolerance_);
    if (shared == 1) {
      return !AreApart(MakeOppositeEdge(a, in_a), MakeTriangle(b), tolerance_) ||
             !AreApart(MakeTriangle(a), MakeOppositeEdge(b, in_b), tolerance_);
    }
    return shared == 3 || IsFolded(a, b);
  }

 private:
  Simplex MakeTriangle(const Vector3i& t) const {
    return {{mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]}, 3};
  }
  Simplex MakeOppositeEdge(const Vector3i& t, int corner) const {
    const Vector3d& from = mesh_.vertices[t[(corner + 1) % 3]];
    const Vector3d& to = mesh_.vertices[t[(corner + 2) % 3]];
    return {{from, to, to}, 2};
  }

  // Of triangles that share an edge and agree on outside: whether both lie in one plane on the same side of the edge.
  bool IsFolded(const Vector3i& a, const Vector3i& b) const {
    const Vector3d na = MakeTriangle(a).CalcNormal().stableNormalized();
    const Vector3d nb = MakeTriangle(b).CalcNormal().stableNormalized();
    if (na.dot(nb) > 0.0) return false;
    double off_plane = 0.0;
    for (int k = 0; k < 3; ++k) {
      off_plane = std::max(off_plane, std::abs(na.dot(mesh_.vertices[b[k]] - mesh_.vertices[a[0]])));
      off_plane = std::max(off_plane, std::abs(nb.dot(mesh_.vertices[a[k]] - mesh_.vertices[b[0]])));
    }
    return off_plane <= tolerance_;
  }

  const TriangleMesh& mesh_;
  double tolerance_ = 0.0;
};

}  // namespace

std::optional<std::array<int, 2>> FindSelfContact(const TriangleMesh& mesh, const TriangleBvh& bvh) {
  const PairTest test(mesh);
  std::vector<int> near;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) box.extend(mesh.vertices[mesh.triangles[static_cast<std::size_t>(i)][k]]);
    box.min().array() -= test.tolerance();
    box.max().array() += test.tolerance();
    bvh.FindTriangles(box, &near);
    for (const int j : near) {
      if (j > i && test.Meet(i, j)) return std::array{i, j};
    }
  }
  return {};
}

}  // namespace knap
