#include "sim/geometry/triangle_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

namespace knap {
namespace triangle_mesh_test {

using Eigen::Vector3d;
using Eigen::Vector3i;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Corners at the origin and at 1, 2 and 3 along the axes: volume 1 * 2 * 3 / 6 = 1.
TriangleMesh MakeTetrahedron() {
  return {{Vector3d::Zero(), Vector3d(1, 0, 0), Vector3d(0, 2, 0), Vector3d(0, 0, 3)},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

TEST(TriangleMesh, SoundMeshHasNoDefects) {
  const MeshDefects defects = FindDefects(MakeTetrahedron());
  EXPECT_TRUE(defects.empty());
  EXPECT_EQ(defects.Describe(), "");
}

TEST(TriangleMesh, VolumeOfATetrahedronWhereverItIs) {
  TriangleMesh mesh = MakeTetrahedron();
  EXPECT_NEAR(CalcSignedVolume(mesh), 1, 1e-15);
  // Coordinates near 1e6 carry 1e-10 of rounding, and the volume as much; a sum about the origin would lose
  // (1e6)^3 * 1e-16 = 100.
  for (Vector3d& v : mesh.vertices) v += Vector3d(1e6, -2e6, 3e6);
  EXPECT_NEAR(CalcSignedVolume(mesh), 1, 1e-8);
}

TEST(TriangleMesh, BoundingBox) {
  const Eigen::AlignedBox3d box = CalcBoundingBox(MakeTetrahedron());
  EXPECT_EQ(box.min(), Vector3d(0, 0, 0));
  EXPECT_EQ(box.max(), Vector3d(1, 2, 3));
  EXPECT_TRUE(CalcBoundingBox({}).isEmpty());
}

TEST(TriangleMesh, FindsOpenEdges) {
  TriangleMesh mesh = MakeTetrahedron();
  mesh.triangles.pop_back();
  const MeshDefects defects = FindDefects(mesh);
  EXPECT_EQ(defects.open_edges, 3);
  EXPECT_EQ(defects.Describe(), "3 open edges (edge 1-2 has only one triangle)");
}

TEST(TriangleMesh, FindsOneFlippedTriangle) {
  TriangleMesh mesh = MakeTetrahedron();
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  const MeshDefects defects = FindDefects(mesh);
  EXPECT_EQ(defects.flipped_edges, 3);
  EXPECT_EQ(defects.open_edges, 0);
  EXPECT_FALSE(defects.inside_out);
}

TEST(TriangleMesh, FindsAMeshThatFacesInwards) {
  TriangleMesh mesh = MakeTetrahedron();
  for (Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  const MeshDefects defects = FindDefects(mesh);
  EXPECT_EQ(defects.flipped_edges, 0);
  EXPECT_TRUE(defects.inside_out);
  EXPECT_THAT(defects.Describe(), HasSubstr("face inwards"));
  EXPECT_NEAR(CalcSignedVolume(mesh), -1, 1e-15);
}

TEST(TriangleMesh, FindsEdgesOfMoreThanTwoTriangles) {
  TriangleMesh mesh = MakeTetrahedron();
  mesh.vertices.emplace_back(0, 0, -1);
  mesh.triangles.emplace_back(0, 1, 4);
  EXPECT_EQ(FindDefects(mesh).non_manifold_edges, 1);
  EXPECT_EQ(FindDefects(mesh).open_edges, 2);
}

TEST(TriangleMesh, FindsAPartThatIsThereTwice) {
  TriangleMesh mesh = MakeTetrahedron();
  for (int i = 0; i < 4; ++i) mesh.triangles.push_back(mesh.triangles[static_cast<std::size_t>(i)]);
  EXPECT_THAT(FindDefects(mesh).Describe(), AllOf(HasSubstr("4 triangles that are there twice"),
                                                  HasSubstr("triangles 0 and 4 have the same corners")));
}

TEST(TriangleMesh, FindsTrianglesWithoutArea) {
  TriangleMesh mesh = MakeTetrahedron();
  mesh.triangles.emplace_back(1, 1, 2);
  EXPECT_EQ(FindDefects(mesh).degenerate_triangles, 1);
  EXPECT_EQ(FindDefects(mesh).open_edges, 0) << "a repeated corner makes no edges";
  mesh = MakeTetrahedron();
  mesh.vertices[3] = Vector3d(0.5, 1, 0);  // on the edge from 1 to 2
  EXPECT_EQ(FindDefects(mesh).degenerate_triangles, 1);
}

TEST(TriangleMesh, FindsBadIndicesVerticesWithoutTriangleAndNonFiniteOnes) {
  TriangleMesh mesh = MakeTetrahedron();
  mesh.triangles.emplace_back(0, 1, 4);
  mesh.triangles.emplace_back(-1, 1, 2);
  EXPECT_EQ(FindDefects(mesh).bad_indices, 2);
  EXPECT_THAT(FindDefects(mesh).Describe(), HasSubstr("(triangle 4 is 0 1 4, with 4 vertices)"));
  mesh = MakeTetrahedron();
  mesh.vertices.emplace_back(9, 9, 9);
  EXPECT_EQ(FindDefects(mesh).unused_vertices, 1);
  mesh = MakeTetrahedron();
  mesh.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(FindDefects(mesh).non_finite_vertices, 1);
}

TEST(TriangleMesh, NothingIsNotABody) { EXPECT_TRUE(FindDefects({}).inside_out); }

}  // namespace triangle_mesh_test
}  // namespace knap
