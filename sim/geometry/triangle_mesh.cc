#include "sim/geometry/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <optional>
#include <utility>

#include "sim/geometry/self_contact.h"
#include "sim/geometry/shells.h"
#include "sim/geometry/triangle_bvh.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Twice the area of a triangle whose area counts as none, as a fraction of its longest edge squared.
constexpr double kDegenerateArea = 2e-12;

// One use of an edge by a triangle; `forward` when the triangle runs from low to high.
struct EdgeUse {
  int low;
  int high;
  bool forward;
};

bool HasTriangle(const Shell& shell, int triangle) {
  return std::binary_search(shell.triangles.begin(), shell.triangles.end(), triangle);
}

bool HasRepeatedCorner(const Vector3i& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

bool IsDegenerate(const TriangleMesh& mesh, const Vector3i& t) {
  if (HasRepeatedCorner(t)) return true;
  const Vector3d& a = mesh.vertices[t[0]];
  const Vector3d& b = mesh.vertices[t[1]];
  const Vector3d& c = mesh.vertices[t[2]];
  const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return !((b - a).cross(c - a).norm() > kDegenerateArea * longest2);
}

// The middle of vertices that exist, or none where one does not.
std::optional<Vector3d> FindMiddle(const TriangleMesh& mesh, std::initializer_list<int> vertices) {
  Vector3d sum = Vector3d::Zero();
  for (const int v : vertices) {
    if (v < 0 || v >= static_cast<int>(mesh.vertices.size())) return std::nullopt;
    sum += mesh.vertices[static_cast<std::size_t>(v)];
  }
  if (!sum.allFinite()) return std::nullopt;
  return Vector3d(sum / static_cast<double>(vertices.size()));
}

using Note = std::function<void(std::string, std::initializer_list<int>)>;  // text, and the vertices it is about

// Triangles whose corners are those of an earlier one, in any order.
int CountRepeatedTriangles(const TriangleMesh& mesh, const Note& note) {
  std::vector<std::array<int, 4>> sorted;  // corners, ascending, and the triangle
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3i& t = mesh.triangles[i];
    sorted.push_back({t[0], t[1], t[2], static_cast<int>(i)});
    std::sort(sorted.back().begin(), sorted.back().begin() + 3);
  }
  std::sort(sorted.begin(), sorted.end());
  int repeated = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (!std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin())) continue;
    ++repeated;
    note(fmt::format("triangles {} and {} have the same corners", sorted[i - 1][3], sorted[i][3]),
         {sorted[i][0], sorted[i][1], sorted[i][2]});
  }
  return repeated;
}

// What is wrong with a mesh of which every edge has its two triangles.
void FindDefectsOfShells(const TriangleMesh& mesh, MeshDefects* defects) {
  const std::vector<Shell> shells = FindShells(mesh);
  if (shells.size() < 2 && !(CalcSignedVolume(mesh) > 0)) {
    defects->inside_out = true;
  } else if (const auto pair = FindSelfContact(mesh, TriangleBvh(mesh))) {
    defects->meets_itself = true;
    std::array<int, 2> parts{};
    for (int k = 0; k < 2; ++k) {
      while (!HasTriangle(shells[parts[k]], (*pair)[k])) ++parts[k];
    }
    defects->place = mesh.vertices[mesh.triangles[(*pair)[0]][0]];
    const Vector3d at = 1000 * *defects->place;
    defects->example =
        fmt::format("{} meets {} near ({:.6g}, {:.6g}, {:.6g}) mm", DescribeShell(shells, parts[0]),
                    parts[0] == parts[1] ? "itself" : DescribeShell(shells, parts[1]), at.x(), at.y(), at.z());
  } else {
    defects->example = FindWrongShell(mesh, shells);
    defects->wrong_shells = !defects->example.empty();
  }
}

void AppendCount(int count, const char* one, const char* many, std::string* line) {
  if (count == 0) return;
  if (!line->empty()) *line += ", ";
  *line += fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

bool MeshDefects::empty() const {
  return bad_indices == 0 && non_finite_vertices == 0 && degenerate_triangles == 0 && repeated_triangles == 0 &&
         open_edges == 0 && non_manifold_edges == 0 && flipped_edges == 0 && unused_vertices == 0 && !meets_itself &&
         !wrong_shells && !inside_out;
}

std::string MeshDefects::Describe() const {
  std::string line;
  AppendCount(bad_indices, "triangle with an index out of range", "triangles with an index out of range", &line);
  AppendCount(non_finite_vertices, "vertex that is not finite", "vertices that are not finite", &line);
  AppendCount(degenerate_triangles, "triangle without area", "triangles without area", &line);
  AppendCount(repeated_triangles, "triangle that is there twice", "triangles that are there twice", &line);
  AppendCount(open_edges, "open edge", "open edges", &line);
  AppendCount(non_manifold_edges, "edge with more than two triangles", "edges with more than two triangles", &line);
  AppendCount(flipped_edges, "edge between triangles of opposite orientation",
              "edges between triangles of opposite orientation", &line);
  AppendCount(unused_vertices, "vertex without a triangle", "vertices without a triangle", &line);
  if (meets_itself) line += "parts that cross or touch";
  if (wrong_shells) line += "a part that is neither a solid nor a cavity";
  if (inside_out) line += "no positive volume: the triangles face inwards, or there are none";
  if (!example.empty()) line += fmt::format(" ({})", example);
  return line;
}

MeshDefects FindDefects(const TriangleMesh& mesh) {
  MeshDefects defects;
  const auto note = [&](std::string text, std::initializer_list<int> vertices) {
    if (!defects.example.empty()) return;
    defects.example = std::move(text);
    defects.place = FindMiddle(mesh, vertices);
  };
  const int num_vertices = static_cast<int>(mesh.vertices.size());

  std::vector<bool> used(mesh.vertices.size(), false);
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3i& t = mesh.triangles[i];
    if (t.minCoeff() < 0 || t.maxCoeff() >= num_vertices) {
      ++defects.bad_indices;
      note(fmt::format("triangle {} is {} {} {}, with {} vertices", i, t[0], t[1], t[2], num_vertices),
           {t[0], t[1], t[2]});
      continue;
    }
    for (int k = 0; k < 3; ++k) used[t[k]] = true;
    if (IsDegenerate(mesh, t)) {
      ++defects.degenerate_triangles;
      note(fmt::format("triangle {} is {} {} {}", i, t[0], t[1], t[2]), {t[0], t[1], t[2]});
    }
    if (HasRepeatedCorner(t)) continue;  // its "edges" would only hide the real ones
    for (int k = 0; k < 3; ++k) {
      const int from = t[k];
      const int to = t[(k + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  for (int v = 0; v < num_vertices; ++v) {
    if (!mesh.vertices[v].allFinite()) {
      ++defects.non_finite_vertices;
      note(fmt::format("vertex {}", v), {v});
    }
  }

  defects.repeated_triangles = CountRepeatedTriangles(mesh, note);
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::array{a.low, a.high, int{a.forward}} < std::array{b.low, b.high, int{b.forward}};
  });
  for (size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    const EdgeUse& edge = uses[begin];
    int forward = 0;
    for (end = begin; end < uses.size() && uses[end].low == edge.low && uses[end].high == edge.high; ++end) {
      forward += uses[end].forward ? 1 : 0;
    }
    const size_t count = end - begin;
    if (count == 1) {
      ++defects.open_edges;
      note(fmt::format("edge {}-{} has only one triangle", edge.low, edge.high), {edge.low, edge.high});
    } else if (count > 2) {
      ++defects.non_manifold_edges;
      note(fmt::format("edge {}-{} has {} triangles", edge.low, edge.high, count), {edge.low, edge.high});
    } else if (forward != 1) {
      ++defects.flipped_edges;
      note(fmt::format("the triangles at edge {}-{}", edge.low, edge.high), {edge.low, edge.high});
    }
  }
  for (int v = 0; v < num_vertices; ++v) {
    if (!used[v]) {
      ++defects.unused_vertices;
      note(fmt::format("vertex {}", v), {v});
    }
  }
  if (defects.empty()) FindDefectsOfShells(mesh, &defects);
  return defects;
}

double CalcSignedVolume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vector3d centre = CalcBoundingBox(mesh).center();
  double sum = 0;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[t[0]] - centre;
    const Vector3d b = mesh.vertices[t[1]] - centre;
    const Vector3d c = mesh.vertices[t[2]] - centre;
    sum += a.dot(b.cross(c));
  }
  return sum / 6;
}

Eigen::AlignedBox3d CalcBoundingBox(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : mesh.vertices) box.extend(v);
  return box;
}

}  // namespace knap
