// Meshes taken apart: an angle exactly, a ring nearly, and always the same.
#include "sim/geometry/convex_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace knap {
namespace convex_pieces_test {

using Eigen::Vector3d;

// A ring about z, of round section.
TriangleMesh MakeRing(int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2.0 * M_PI * i / around;
      const double b = 2.0 * M_PI * j / across;
      const double rho = 0.030 + 0.008 * std::cos(b);
      mesh.vertices.emplace_back(rho * std::cos(a), rho * std::sin(a), 0.008 * std::sin(b));
    }
  }
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return mesh;
}

double CalcDepthInTube(const Vector3d& x) { return 0.008 - std::hypot(x.head<2>().norm() - 0.030, x.z()); }

bool Holds(const TriangleMesh& piece, const Vector3d& x) {
  for (const Eigen::Vector3i& t : piece.triangles) {
    const Vector3d& a = piece.vertices[t[0]];
    if ((piece.vertices[t[1]] - a).cross(piece.vertices[t[2]] - a).dot(x - a) > 0.0) return false;
  }
  return true;
}

// By how much a vertex lies above a facet of its own piece.
double FindDent(const TriangleMesh& piece) {
  double worst = 0.0;
  for (const Eigen::Vector3i& t : piece.triangles) {
    const Vector3d& a = piece.vertices[t[0]];
    const Vector3d n = (piece.vertices[t[1]] - a).cross(piece.vertices[t[2]] - a);
    if (n.norm() < 1e-12) continue;  // of no area
    for (const Vector3d& v : piece.vertices) worst = std::max(worst, n.normalized().dot(v - a));
  }
  return worst;
}

TEST(ConvexPieces, FillARingNearly) {
  const TriangleMesh ring = MakeRing(32, 12);
  ASSERT_TRUE(FindDefects(ring).empty());
  const std::vector<TriangleMesh> pieces = MakeConvexPieces(ring);
  EXPECT_GT(pieces.size(), 6u);
  EXPECT_LT(pieces.size(), 40u);
  for (const TriangleMesh& piece : pieces) {
    EXPECT_TRUE(FindDefects(piece).empty()) << FindDefects(piece).Describe();
    EXPECT_LE(FindDent(piece), 1e-8);
    // What sticks out is some hundredths of the size, 76 mm; none closes the hole.
    for (const Eigen::Vector3i& t : piece.triangles) {
      const Vector3d middle = (piece.vertices[t[0]] + piece.vertices[t[1]] + piece.vertices[t[2]]) / 3.0;
      EXPECT_GT(CalcDepthInTube(middle), -0.0015);
    }
  }
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int inside = 0;
  int held = 0;
  while (inside < 2000) {
    const Vector3d x(0.038 * uniform(generator), 0.038 * uniform(generator), 0.008 * uniform(generator));
    if (CalcDepthInTube(x) < 0.001) continue;  // the ring has corners on the tube
    ++inside;
    if (std::any_of(pieces.begin(), pieces.end(), [&x](const TriangleMesh& piece) { return Holds(piece, x); })) ++held;
  }
  EXPECT_GT(held, 1980);
}

TEST(ConvexPieces, AreAlwaysTheSame) {
  const TriangleMesh ring = MakeRing(20, 8);
  const std::vector<TriangleMesh> first = MakeConvexPieces(ring);
  for (int i = 0; i < 17; ++i) static_cast<void>(std::rand());
  const std::vector<TriangleMesh> second = MakeConvexPieces(ring);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].vertices, second[i].vertices);
    EXPECT_EQ(first[i].triangles, second[i].triangles);
  }
}

}  // namespace convex_pieces_test
}  // namespace knap
