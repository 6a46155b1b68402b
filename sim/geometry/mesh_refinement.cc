#include "sim/geometry/mesh_refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// From the corner with the lower index to the other, so that both triangles of an edge mean the same.
std::pair<int, int> MakeEdge(int a, int b) { return std::minmax(a, b); }

double CalcLength(const TriangleMesh& mesh, const std::pair<int, int>& edge) {
  return (mesh.vertices[static_cast<std::size_t>(edge.second)] - mesh.vertices[static_cast<std::size_t>(edge.first)])
      .norm();
}

// Splits every edge that is too long once. Returns whether there was one.
class Pass {
 public:
  Pass(TriangleMesh* mesh, double longest) : mesh_(*mesh), longest_(longest) {}

  // Whether that would leave no more triangles than allowed.
  bool Prepare(std::size_t most_triangles) {
    std::size_t count = mesh_.triangles.size();
    for (const Vector3i& triangle : mesh_.triangles) {
      for (int k = 0; k < 3; ++k) count += FindMidpoint(triangle(k), triangle((k + 1) % 3)) >= 0 ? 1 : 0;
    }
    return count <= most_triangles;
  }

  bool Split() {
    std::vector<Vector3i> triangles;
    for (const Vector3i& triangle : mesh_.triangles) SplitTriangle(triangle, &triangles);
    const bool changed = triangles.size() != mesh_.triangles.size();
    mesh_.triangles = std::move(triangles);
    return changed;
  }

 private:
  // The vertex in the middle of an edge that is too long; -1 of another.
  int FindMidpoint(int a, int b) {
    const std::pair<int, int> edge = MakeEdge(a, b);
    const auto [found, is_new] = midpoints_.try_emplace(edge, -1);
    if (is_new && CalcLength(mesh_, edge) > longest_) {
      found->second = static_cast<int>(mesh_.vertices.size());
      const Vector3d& p = mesh_.vertices[static_cast<std::size_t>(edge.first)];
      const Vector3d& q = mesh_.vertices[static_cast<std::size_t>(edge.second)];
      mesh_.vertices.push_back(0.5 * (p + q));
    }
    return found->second;
  }

  void SplitTriangle(const Vector3i& triangle, std::vector<Vector3i>* out) {
    std::array<int, 3> middle{};  // of the edge behind each corner
    for (int k = 0; k < 3; ++k) middle[static_cast<std::size_t>(k)] = FindMidpoint(triangle(k), triangle((k + 1) % 3));
    const auto split = std::count_if(middle.begin(), middle.end(), [](int m) { return m >= 0; });
    // Turned so that, with one, the first edge is split and, with two, the last one is not.
    int first = 0;
    while (split == 1 && middle[static_cast<std::size_t>(first)] < 0) ++first;
    while (split == 2 && middle[static_cast<std::size_t>((first + 2) % 3)] >= 0) ++first;
    const int a = triangle(first), b = triangle((first + 1) % 3), c = triangle((first + 2) % 3);
    const int ab = middle[static_cast<std::size_t>(first)];
    const int bc = middle[static_cast<std::size_t>((first + 1) % 3)];
    const int ca = middle[static_cast<std::size_t>((first + 2) % 3)];
    switch (split) {
      case 0:
        out->push_back(triangle);
        break;
      case 1:
        out->insert(out->end(), {Vector3i(a, ab, c), Vector3i(ab, b, c)});
        break;
      case 2:
        out->push_back(Vector3i(ab, b, bc));
        if (CalcLength(mesh_, MakeEdge(a, bc)) <= CalcLength(mesh_, MakeEdge(ab, c))) {
          out->insert(out->end(), {Vector3i(a, ab, bc), Vector3i(a, bc, c)});
        } else {
          out->insert(out->end(), {Vector3i(a, ab, c), Vector3i(ab, bc, c)});
        }
        break;
      default:
        out->insert(out->end(), {Vector3i(a, ab, ca), Vector3i(ab, b, bc), Vector3i(ca, bc, c), Vector3i(ab, bc, ca)});
    }
  }

  TriangleMesh& mesh_;
  const double longest_;
  std::map<std::pair<int, int>, int> midpoints_;
};

// To two digits; one that has no more stays.
double RoundUp(double length) {
  const double unit = std::pow(10.0, std::floor(std::log10(length)) - 1.0);
  return std::ceil(length / unit - 1e-9) * unit;
}

double CalcArea(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const Vector3i& triangle : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(triangle(k))]; };
    area += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  return area;
}

}  // namespace

double CalcLongestEdge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (const Vector3i& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, CalcLength(mesh, MakeEdge(triangle(k), triangle((k + 1) % 3))));
    }
  }
  return longest;
}

std::optional<TriangleMesh> RefineMesh(const TriangleMesh& mesh, double longest, std::size_t most_triangles) {
  TriangleMesh refined = mesh;
  // Every pass halves what is too long, or runs into the limit.
  while (true) {
    Pass pass(&refined, longest);
    if (!pass.Prepare(most_triangles)) return std::nullopt;
    if (!pass.Split()) return refined;
  }
}

double FindAllowedLength(const TriangleMesh& mesh, double longest, std::size_t most_triangles) {
  const double own = CalcLongestEdge(mesh);
  // Below that the longest edge has too many parts, or equilateral triangles, the largest, do not cover the surface.
  const auto most = static_cast<double>(most_triangles);
  const double least = std::max(own / most, std::sqrt(4.0 / std::sqrt(3.0) * CalcArea(mesh) / most));
  for (double length = RoundUp(std::max(longest, least)); length < own; length = RoundUp(1.2 * length)) {
    if (RefineMesh(mesh, length, most_triangles)) return length;
  }
  return RoundUp(own);
}

}  // namespace knap
