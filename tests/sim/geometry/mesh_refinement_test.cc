#include "sim/geometry/mesh_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace knap {
namespace mesh_refinement_test {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::size_t kMost = 100'000;

// Two triangles a side.
TriangleMesh MakeBox(const Vector3d& size) {
  TriangleMesh mesh;
  for (const double x : {0.0, size.x()}) {
    for (const double y : {0.0, size.y()}) {
      for (const double z : {0.0, size.z()}) mesh.vertices.emplace_back(x, y, z);
    }
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return mesh;
}

// Long, thin and crooked: four corners, of which three are close to one another.
TriangleMesh MakeNeedle() {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {0.002, 0.0, 0.0005}, {0.0003, 0.0017, 0.0}, {0.031, 0.017, 0.093}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

// A sphere as two pyramids of many sides: triangles of unlike shapes and sizes meet.
TriangleMesh MakeSpindle(int sides) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, -0.05}, {0.0, 0.0, 0.02}};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * M_PI * (i + 0.3 * std::sin(5.0 * i)) / sides;
    mesh.vertices.emplace_back(0.03 * std::cos(angle), 0.01 * std::sin(angle), 0.0);
  }
  for (int i = 0; i < sides; ++i) {
    const int a = 2 + i, b = 2 + (i + 1) % sides;
    mesh.triangles.emplace_back(0, b, a);
    mesh.triangles.emplace_back(1, a, b);
  }
  return mesh;
}

std::vector<TriangleMesh> ListMeshes() {
  return {MakeBox({0.1, 0.06, 0.004}), MakeBox({0.01, 0.01, 0.01}), MakeNeedle(), MakeSpindle(17)};
}

Vector3d GetCorner(const TriangleMesh& mesh, const Vector3i& triangle, int k) {
  return mesh.vertices[static_cast<std::size_t>(triangle(k))];
}

Vector3d CalcNormal(const TriangleMesh& mesh, const Vector3i& triangle) {  // as long as twice the area
  const Vector3d a = GetCorner(mesh, triangle, 0);
  return (GetCorner(mesh, triangle, 1) - a).cross(GetCorner(mesh, triangle, 2) - a);
}

double CalcArea(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const Vector3i& triangle : mesh.triangles) area += 0.5 * CalcNormal(mesh, triangle).norm();
  return area;
}

// Whether p lies on the segment from a to b, but is none of its ends.
bool IsWithin(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double along = (p - a).dot(b - a) / (b - a).squaredNorm();
  return along > 1e-9 && along < 1.0 - 1e-9 && (p - a - along * (b - a)).norm() < 1e-9 * (b - a).norm();
}

TEST(MeshRefinement, SplitsWhatIsTooLongAndKeepsTheShape) {
  for (const TriangleMesh& mesh : ListMeshes()) {
    ASSERT_TRUE(FindDefects(mesh).empty()) << FindDefects(mesh).Describe();
    const double own = CalcLongestEdge(mesh);
    std::size_t before = mesh.triangles.size();
    for (const double part : {0.9, 0.5, 0.3, 0.11, 0.03}) {
      const double longest = part * own;
      const std::optional<TriangleMesh> refined = RefineMesh(mesh, longest, kMost);
      ASSERT_TRUE(refined.has_value());
      EXPECT_GT(refined->triangles.size(), mesh.triangles.size());
      EXPECT_GE(refined->triangles.size(), before);
      before = refined->triangles.size();
      EXPECT_LE(CalcLongestEdge(*refined), longest);
      const MeshDefects defects = FindDefects(*refined);  // closed, manifold, oriented, without self-contact
      EXPECT_TRUE(defects.empty()) << defects.Describe();
      // Halves and sums of doubles: a rounding or two a vertex.
      EXPECT_NEAR(CalcSignedVolume(*refined), CalcSignedVolume(mesh), 1e-12 * CalcSignedVolume(mesh));
      EXPECT_NEAR(CalcArea(*refined), CalcArea(mesh), 1e-12 * CalcArea(mesh));
      for (std::size_t i = 0; i < mesh.vertices.size(); ++i) EXPECT_EQ(refined->vertices[i], mesh.vertices[i]);
    }
  }
}

// No vertex in the middle of another triangle's edge, where the surface would tear when it bends.
TEST(MeshRefinement, LeavesNoTJunction) {
  for (const TriangleMesh& mesh : ListMeshes()) {
    const TriangleMesh refined = *RefineMesh(mesh, 0.2 * CalcLongestEdge(mesh), kMost);
    std::map<std::pair<int, int>, int> uses;
    for (const Vector3i& triangle : refined.triangles) {
      for (int k = 0; k < 3; ++k) ++uses[std::minmax({triangle(k), triangle((k + 1) % 3)})];
    }
    for (const auto& [edge, count] : uses) {
      EXPECT_EQ(count, 2);
      const Vector3d& a = refined.vertices[static_cast<std::size_t>(edge.first)];
      const Vector3d& b = refined.vertices[static_cast<std::size_t>(edge.second)];
      for (const Vector3d& p : refined.vertices) EXPECT_FALSE(IsWithin(p, a, b));
    }
  }
}

// Every new triangle faces as one of the old ones does.
TEST(MeshRefinement, FacesAsBefore) {
  for (const TriangleMesh& mesh : ListMeshes()) {
    const TriangleMesh refined = *RefineMesh(mesh, 0.1 * CalcLongestEdge(mesh), kMost);
    for (const Vector3i& triangle : refined.triangles) {
      double best = 0.0;
      for (const Vector3i& old : mesh.triangles) {
        best = std::max(best, CalcNormal(refined, triangle).normalized().dot(CalcNormal(mesh, old).normalized()));
      }
      EXPECT_GT(best, 1.0 - 1e-9);
    }
  }
}

TEST(MeshRefinement, WhatIsFineStaysAsItIs) {
  for (const TriangleMesh& mesh : ListMeshes()) {
    const TriangleMesh same = *RefineMesh(mesh, CalcLongestEdge(mesh), mesh.triangles.size());
    EXPECT_EQ(same.vertices, mesh.vertices);
    EXPECT_EQ(same.triangles, mesh.triangles);
  }
}

// A square's diagonal is split, and nothing else: by hand.
TEST(MeshRefinement, ACubesDiagonalsAreSplitFirst) {
  const TriangleMesh refined = *RefineMesh(MakeBox({1.0, 1.0, 1.0}), 1.2, kMost);
  EXPECT_EQ(refined.triangles.size(), 24u);
  EXPECT_EQ(refined.vertices.size(), 8u + 6u);
  EXPECT_EQ(CalcLongestEdge(refined), 1.0);
  EXPECT_EQ(CalcSignedVolume(refined), 1.0);
}

TEST(MeshRefinement, KeepsToTheNumberAllowed) {
  for (const TriangleMesh& mesh : ListMeshes()) {
    const double own = CalcLongestEdge(mesh);
    for (const std::size_t most : {mesh.triangles.size(), std::size_t{40}, std::size_t{1000}, std::size_t{5000}}) {
      if (most < mesh.triangles.size()) continue;
      for (const double longest : {1e-300, 1e-9, 1e-3 * own}) {
        if (const auto refined = RefineMesh(mesh, longest, most)) {
          EXPECT_LE(refined->triangles.size(), most);
          continue;
        }
        const double allowed = FindAllowedLength(mesh, longest, most);
        EXPECT_GT(allowed, longest);
        ASSERT_TRUE(RefineMesh(mesh, allowed, most).has_value()) << allowed << " of " << own;
        EXPECT_LT(allowed, 1.11 * own);
        EXPECT_FALSE(RefineMesh(mesh, allowed / 1.4, most).has_value()) << allowed << " of " << own;
      }
    }
  }
}

}  // namespace mesh_refinement_test
}  // namespace knap
