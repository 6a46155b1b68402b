// Meshes of several parts, and parts that cross themselves.
#include "sim/geometry/shells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace knap {
namespace shells_test {

using Eigen::Vector3d;
using Eigen::Vector3i;
using ::testing::AllOf;
using ::testing::HasSubstr;

// The box from a to b, in metres.
TriangleMesh MakeBox(const Vector3d& a, const Vector3d& b) {
  TriangleMesh box;
  for (int i = 0; i < 8; ++i)
    box.vertices.emplace_back(i & 1 ? b.x() : a.x(), i & 2 ? b.y() : a.y(), i & 4 ? b.z() : a.z());
  for (const auto& [p, q, r, s] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    box.triangles.emplace_back(p, q, r);
    box.triangles.emplace_back(p, r, s);
  }
  return box;
}

TriangleMesh MakeCube(double from, double to) { return MakeBox(Vector3d::Constant(from), Vector3d::Constant(to)); }

TriangleMesh Invert(TriangleMesh mesh) {
  for (Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

TriangleMesh Join(TriangleMesh mesh, const TriangleMesh& more) {
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Vector3i& t : more.triangles) mesh.triangles.push_back(t + Vector3i::Constant(first));
  return mesh;
}

TEST(Shells, PartsThatAreApartAreABody) {
  const TriangleMesh mesh = Join(MakeCube(0, 1), MakeCube(1.001, 3));
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
  const std::vector<Shell> shells = FindShells(mesh);
  ASSERT_EQ(shells.size(), 2u);
  EXPECT_NEAR(shells[0].volume, 1.0, 1e-15);
  EXPECT_NEAR(shells[1].volume, 1.999 * 1.999 * 1.999, 1e-14);
  EXPECT_EQ(shells[1].triangles.front(), 12);
}

TEST(Shells, ACavityAndWhatLiesInItAreABody) {
  EXPECT_EQ(FindDefects(Join(MakeCube(0, 4), Invert(MakeCube(1, 3)))).Describe(), "");
  EXPECT_EQ(FindDefects(Join(MakeCube(1.5, 2), Join(Invert(MakeCube(1, 3)), MakeCube(0, 4)))).Describe(), "");
}

TEST(Shells, PartsThatFaceTheWrongWayAreNamed) {
  EXPECT_THAT(
      FindDefects(Join(MakeCube(0, 0.5), Invert(MakeCube(1, 1.1)))).Describe(),
      HasSubstr("part 2 of 2 (12 triangles, from (1000, 1000, 1000) to (1100, 1100, 1100) mm) faces inwards and "
                "lies in no other"));
  EXPECT_THAT(FindDefects(Join(MakeCube(1, 3), MakeCube(0, 4))).Describe(),
              AllOf(HasSubstr("part 1 of 2"), HasSubstr("faces outwards and lies inside part 2 of 2")));
  EXPECT_THAT(FindDefects(Join(Invert(MakeCube(1.5, 2)), Join(Invert(MakeCube(1, 3)), MakeCube(0, 4)))).Describe(),
              AllOf(HasSubstr("part 1 of 3"), HasSubstr("lies inside part 2 of 3")));
  // In the box of the other, but not in it: an L-shape would do, two boxes beside a tetrahedron are shorter.
  const TriangleMesh corner{{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  EXPECT_EQ(FindDefects(Join(corner, MakeCube(7, 8))).Describe(), "");
}

TEST(Shells, PartsThatOverlapOrTouchAreNamed) {
  for (const double from : {0.5, 1.0}) {  // overlapping, and touching at a corner
    EXPECT_THAT(FindDefects(Join(MakeCube(0, 1), MakeCube(from, 2))).Describe(),
                AllOf(HasSubstr("part 1 of 2"), HasSubstr("meets part 2 of 2")));
  }
  // Faces in one plane; the first part without a vertex in the other, then the other way round.
  const TriangleMesh low = MakeBox({0, 0, 0}, {4, 4, 1});
  const TriangleMesh high = MakeBox({1, 1, 1}, {2, 2, 3});
  EXPECT_THAT(FindDefects(Join(low, high)).Describe(), HasSubstr("meets part 2 of 2"));
  EXPECT_THAT(FindDefects(Join(high, low)).Describe(), HasSubstr("meets part 2 of 2"));
  // A bar right through a plate: no vertex of one in the other.
  const TriangleMesh bar = MakeBox({1, 1, -1}, {2, 2, 3});
  EXPECT_THAT(FindDefects(Join(low, bar)).Describe(), HasSubstr("meets part 2 of 2"));
  // The same box twice, with vertices of its own.
  EXPECT_THAT(FindDefects(Join(bar, bar)).Describe(), HasSubstr("meets part 2 of 2"));
}

TEST(Shells, APartThatCrossesItselfIsNamed) {
  TriangleMesh mesh = MakeBox({0, 0, 0}, {1, 1, 1});
  mesh.vertices[0] = Vector3d(0.5, 0.5, 1.5);  // a lower corner through the roof; the volume stays positive
  ASSERT_GT(CalcSignedVolume(mesh), 0.0);
  EXPECT_THAT(FindDefects(mesh).Describe(), HasSubstr("part 1 of 1 (12 triangles, from (0, 0, 0) to (1000, 1000, 1500) "
                                                      "mm) meets itself"));
}

TEST(Shells, ATriangleFoldedOverInItsPlaneIsFound) {
  // A cube whose roof has a vertex in its middle, which moves within the roof's plane and then over its edge.
  TriangleMesh mesh = MakeBox({0, 0, 0}, {1, 1, 1});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);
  mesh.vertices.emplace_back(0.5, 0.5, 1);
  for (const auto& [a, b] : {std::pair{4, 5}, {5, 7}, {7, 6}, {6, 4}}) mesh.triangles.emplace_back(a, b, 8);
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
  mesh.vertices[8].x() = 0.99;
  EXPECT_EQ(FindDefects(mesh).Describe(), "");
  mesh.vertices[8].x() = 1.01;
  EXPECT_THAT(FindDefects(mesh).Describe(), HasSubstr("meets itself"));
}

}  // namespace shells_test
}  // namespace knap
