#include "coordinator/report/silhouette.h"

#include <set>
#include <utility>

namespace knap {
namespace {

// A side wall seen edge-on has an area of rounding errors; relative to the longest edge squared.
constexpr double kEdgeOn = 1e-9;

}  // namespace

Outline CalcSilhouette(const TriangleMesh& mesh, int right, int up) {
  const auto project = [&](int vertex) {
    const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(vertex)];
    return Eigen::Vector2d(p[right], p[up]);
  };
  // Directed edges of the chosen triangles; an edge between two of them cancels.
  std::set<std::pair<int, int>> edges;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Eigen::Vector2d a = project(triangle[0]), b = project(triangle[1]), c = project(triangle[2]);
    const double area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    if (area <= kEdgeOn * ((b - a).squaredNorm() + (c - a).squaredNorm())) continue;
    for (int k = 0; k < 3; ++k) {
      const int from = triangle[k], to = triangle[(k + 1) % 3];
      if (edges.erase({to, from}) == 0) edges.insert({from, to});
    }
  }
  // Every vertex has as many edges in as out, so a walk along unused edges ends where it began.
  Outline outline;
  while (!edges.empty()) {
    const int start = edges.begin()->first;
    std::vector<Eigen::Vector2d> loop;
    int vertex = start;
    do {
      loop.push_back(project(vertex));
      const auto edge = edges.lower_bound({vertex, -1});
      vertex = edge->second;
      edges.erase(edge);
    } while (vertex != start);
    outline.push_back(std::move(loop));
  }
  return outline;
}

}  // namespace knap
