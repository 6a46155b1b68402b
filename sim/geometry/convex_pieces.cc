#include "sim/geometry/convex_pieces.h"

#include <HACD/hacdHACD.h>

#include <cstddef>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "sim/geometry/convex_hull.h"
#include "sim/geometry/mass_properties.h"

namespace knap {
namespace {

using Point = HACD::Vec3<HACD::Real>;
using Corners = HACD::Vec3<long>;

// Of the library's own unit, a thousandth of the mesh's size.
constexpr double kConcavity = 10.0;
// How much it prefers round patches to long ones.
constexpr double kCompactness = 1e-4;
constexpr double kNoVolume = 1e-9;  // of the mesh's: a piece is flat

// For each triangle the number of its cluster; it scales and moves `points`.
std::vector<long> MakeClusters(std::vector<Point>* points, std::vector<Corners>* corners) {
  HACD::HACD clusters;
  clusters.SetPoints(points->data());
  clusters.SetNPoints(points->size());
  clusters.SetTriangles(corners->data());
  clusters.SetNTriangles(corners->size());
  clusters.SetNClusters(1);
  clusters.SetConcavity(kConcavity);
  clusters.SetCompacityWeight(kCompactness);
  clusters.SetVolumeWeight(0.0);
  clusters.SetConnectDist(0.0);
  // Without these a patch counts as convex whose hull leaves the mesh elsewhere.
  clusters.SetAddExtraDistPoints(true);
  clusters.SetAddNeighboursDistPoints(true);
  clusters.SetAddFacesPoints(true);
  // It shakes points that lie in one plane by the C library's random numbers.
  std::srand(1);
  clusters.NormalizeData();
  clusters.Compute(true);
  return {clusters.GetPartition(), clusters.GetPartition() + corners->size()};
}

}  // namespace

std::vector<TriangleMesh> MakeConvexPieces(const TriangleMesh& mesh) {
  std::vector<Point> points;
  for (const Eigen::Vector3d& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<Corners> corners;
  for (const Eigen::Vector3i& t : mesh.triangles) corners.emplace_back(t[0], t[1], t[2]);
  const std::vector<long> cluster = MakeClusters(&points, &corners);
  std::map<long, std::set<int>> vertices;  // of each
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    for (const int corner : mesh.triangles[i]) vertices[cluster[i]].insert(corner);
  }
  const double volume = CalcMassProperties(mesh, 1.0).mass;
  std::vector<TriangleMesh> out;
  for (const auto& [number, of_cluster] : vertices) {
    std::vector<Eigen::Vector3d> places;
    for (const int vertex : of_cluster) places.push_back(mesh.vertices[vertex]);
    std::optional<TriangleMesh> piece = MakeConvexHull(places);
    if (!piece || CalcMassProperties(*piece, 1.0).mass < kNoVolume * volume) continue;
    out.push_back(*std::move(piece));
  }
  return out;
}

}  // namespace knap
