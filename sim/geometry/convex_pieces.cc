#include "sim/geometry/convex_pieces.h"

#include <HACD/hacdHACD.h>

#include <cstddef>
#include <cstdlib>

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

TriangleMesh GetPiece(HACD::HACD* pieces, std::size_t index) {
  std::vector<Point> points(pieces->GetNPointsCH(index));
  std::vector<Corners> corners(pieces->GetNTrianglesCH(index));
  pieces->GetCH(index, points.data(), corners.data());
  TriangleMesh out;
  for (const Point& p : points) out.vertices.emplace_back(p.X(), p.Y(), p.Z());
  for (const Corners& c : corners) {
    out.triangles.emplace_back(static_cast<int>(c.X()), static_cast<int>(c.Y()), static_cast<int>(c.Z()));
  }
  return out;
}

}  // namespace

std::vector<TriangleMesh> MakeConvexPieces(const TriangleMesh& mesh) {
  std::vector<Point> points;
  for (const Eigen::Vector3d& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<Corners> corners;
  for (const Eigen::Vector3i& t : mesh.triangles) corners.emplace_back(t[0], t[1], t[2]);
  HACD::HACD pieces;
  pieces.SetPoints(points.data());
  pieces.SetNPoints(points.size());
  pieces.SetTriangles(corners.data());
  pieces.SetNTriangles(corners.size());
  pieces.SetNClusters(1);
  pieces.SetConcavity(kConcavity);
  pieces.SetCompacityWeight(kCompactness);
  pieces.SetVolumeWeight(0.0);
  pieces.SetConnectDist(0.0);
  // Without these a patch counts as convex whose hull leaves the mesh elsewhere.
  pieces.SetAddExtraDistPoints(true);
  pieces.SetAddNeighboursDistPoints(true);
  pieces.SetAddFacesPoints(true);
  // It shakes points that lie in one plane by the C library's random numbers.
  std::srand(1);
  pieces.NormalizeData();
  pieces.Compute(true);
  pieces.DenormalizeData();
  const double volume = CalcMassProperties(mesh, 1.0).mass;
  std::vector<TriangleMesh> out;
  for (std::size_t i = 0; i < pieces.GetNClusters(); ++i) {
    TriangleMesh piece = GetPiece(&pieces, i);
    if (piece.triangles.empty() || CalcMassProperties(piece, 1.0).mass < kNoVolume * volume) continue;
    out.push_back(std::move(piece));
  }
  return out;
}

}  // namespace knap
