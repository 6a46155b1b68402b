#include "sim/geometry/triangle_bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace knap {
namespace triangle_bvh_test {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

Vector3d DrawPoint(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double x = uniform(*random), y = uniform(*random), z = uniform(*random);
  return {x, y, z};
}

// Small triangles all over the place.
TriangleMesh MakeSoup(int num_triangles, std::mt19937* random) {
  TriangleMesh mesh;
  for (int i = 0; i < num_triangles; ++i) {
    const Vector3d centre = DrawPoint(random);
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(centre + 0.1 * DrawPoint(random));
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return mesh;
}

std::vector<int> TestEveryTriangle(const TriangleMesh& mesh, const AlignedBox3d& box) {
  std::vector<int> ids;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis) {
      double low = INFINITY, high = -INFINITY;
      for (int k = 0; k < 3; ++k) {
        low = std::min(low, mesh.vertices[static_cast<size_t>(mesh.triangles[i][k])][axis]);
        high = std::max(high, mesh.vertices[static_cast<size_t>(mesh.triangles[i][k])][axis]);
      }
      apart = apart || low > box.max()[axis] || high < box.min()[axis];
    }
    if (!apart) ids.push_back(static_cast<int>(i));
  }
  return ids;
}

TEST(TriangleBvh, AgreesWithTestingEveryTriangle) {
  std::mt19937 random(1);
  size_t most = 0, none = 0;
  for (const int num_triangles : {1, 2, 7, 100, 3000}) {
    const TriangleMesh mesh = MakeSoup(num_triangles, &random);
    const TriangleBvh bvh(mesh);
    EXPECT_EQ(bvh.num_triangles(), num_triangles);
    std::vector<int> found = {-7};  // must be replaced
    for (int query = 0; query < 300; ++query) {
      AlignedBox3d box(DrawPoint(&random));
      box.extend(box.min() + 0.5 * DrawPoint(&random));
      bvh.FindTriangles(box, &found);
      ASSERT_EQ(found, TestEveryTriangle(mesh, box));
      most = std::max(most, found.size());
      none += found.empty() ? 1 : 0;
    }
  }
  EXPECT_GT(most, 20u);  // the queries exercised both outcomes
  EXPECT_GT(none, 20u);
}

TEST(TriangleBvh, TouchingCounts) {
  const TriangleMesh mesh{{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)}, {{0, 1, 2}}};
  const TriangleBvh bvh(mesh);
  std::vector<int> found;
  bvh.FindTriangles(AlignedBox3d(Vector3d(1, 0, 0), Vector3d(2, 1, 1)), &found);
  EXPECT_EQ(found, std::vector<int>{0});
  bvh.FindTriangles(AlignedBox3d(Vector3d(std::nextafter(1.0, 2.0), 0, 0), Vector3d(2, 1, 1)), &found);
  EXPECT_TRUE(found.empty());
}

TEST(TriangleBvh, NothingMeetsAnEmptyBoxOrAnEmptyMesh) {
  std::mt19937 random(2);
  const TriangleBvh bvh(MakeSoup(50, &random));
  std::vector<int> found = {1};
  bvh.FindTriangles(AlignedBox3d(), &found);
  EXPECT_TRUE(found.empty());
  found = {1};
  TriangleBvh(TriangleMesh{}).FindTriangles(AlignedBox3d(Vector3d::Zero()), &found);
  EXPECT_TRUE(found.empty());
}

TEST(TriangleBvh, FillsTheGivenStorage) {
  std::mt19937 random(3);
  const TriangleBvh bvh(MakeSoup(500, &random));
  std::vector<int> found;
  found.reserve(static_cast<size_t>(bvh.num_triangles()));
  const int* const storage = found.data();
  bvh.FindTriangles(AlignedBox3d(Vector3d::Constant(-3), Vector3d::Constant(3)), &found);
  EXPECT_EQ(found.size(), 500u);
  EXPECT_EQ(found.data(), storage);
}

TEST(TriangleBvh, Moves) {
  std::mt19937 random(4);
  const TriangleMesh mesh = MakeSoup(40, &random);
  TriangleBvh first(mesh);
  TriangleBvh second = std::move(first);
  std::vector<int> found;
  second.FindTriangles(AlignedBox3d(Vector3d::Constant(-3), Vector3d::Constant(3)), &found);
  EXPECT_EQ(found.size(), 40u);
}

}  // namespace triangle_bvh_test
}  // namespace knap
