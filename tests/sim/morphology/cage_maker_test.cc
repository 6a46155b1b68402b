// Cages made around meshes: sound, close, and with parameters that do what their names say.
#include "sim/morphology/cage_maker.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "sim/morphology/cage_design.h"
#include "sim/morphology/cage_fit.h"

namespace knap {
namespace cage_maker_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

// A body of revolution about `axis`: rings of 24 vertices at these radii, 10 mm from one another, closed by flat ends.
TriangleMesh MakeTurned(const std::vector<double>& radii_mm, int axis) {
  constexpr int kSides = 24;
  TriangleMesh mesh;
  const int rings = static_cast<int>(radii_mm.size());
  const auto add = [&](double along, double b, double c) {
    Vector3d p;
    p[axis] = 1e-3 * along;
    p[(axis + 1) % 3] = 1e-3 * b;
    p[(axis + 2) % 3] = 1e-3 * c;
    mesh.vertices.push_back(p);
  };
  for (int i = 0; i < rings; ++i) {
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * M_PI * k / kSides;
      const double r = radii_mm[static_cast<std::size_t>(i)];
      add(10.0 * i, r * std::cos(angle), r * std::sin(angle));
    }
  }
  add(0.0, 0.0, 0.0);
  add(10.0 * (rings - 1), 0.0, 0.0);
  const int ends = rings * kSides;
  for (int k = 0; k < kSides; ++k) {
    const int next = (k + 1) % kSides;
    mesh.triangles.emplace_back(ends, next, k);
    mesh.triangles.emplace_back(ends + 1, ends - kSides + k, ends - kSides + next);
    for (int i = 0; i + 1 < rings; ++i) {
      const int a = i * kSides;
      mesh.triangles.emplace_back(a + k, a + next, a + kSides + next);
      mesh.triangles.emplace_back(a + k, a + kSides + next, a + kSides + k);
    }
  }
  return mesh;
}

MadeCage Make(const TriangleMesh& mesh, CageShape shape, int stations, int axis) {
  return MakeCage(mesh, {.axis = axis, .stations = stations, .shape = shape, .margin = 0.5e-3});
}

TEST(CageMaker, EnclosesTheMeshByItsMargin) {
  for (int axis = 0; axis < 3; ++axis) {
    const TriangleMesh mesh = MakeTurned({3, 12, 5, 5, 5, 9, 2}, axis);
    ASSERT_EQ(FindDefects(mesh).Describe(), "");
    for (const int stations : {2, 3, 4, 7, 12}) {
      for (const CageShape shape : {CageShape::kBox, CageShape::kPrism, CageShape::kFitted}) {
        const MadeCage made = Make(mesh, shape, stations, axis);
        EXPECT_EQ(FindDefects(made.cage).Describe(), "") << stations;
        EXPECT_EQ(DescribeMisfit(mesh, made.cage), "");
        const Eigen::AlignedBox3d inner = CalcBoundingBox(mesh);
        const Eigen::AlignedBox3d outer = CalcBoundingBox(made.cage);
        EXPECT_NEAR((inner.min() - outer.min()).minCoeff(), 0.5e-3, 1e-12);
        EXPECT_NEAR((outer.max() - inner.max()).minCoeff(), 0.5e-3, 1e-12);
      }
    }
  }
}

TEST(CageMaker, PrismsAndFittedCagesAreCloser) {
  const TriangleMesh rod = MakeTurned({10, 10, 10, 10}, 2);
  EXPECT_LT(CalcSignedVolume(Make(rod, CageShape::kPrism, 4, 2).cage),
            0.85 * CalcSignedVolume(Make(rod, CageShape::kBox, 4, 2).cage));
  const TriangleMesh cone = MakeTurned({20, 16, 12, 8, 4, 1}, 2);
  EXPECT_LT(CalcSignedVolume(Make(cone, CageShape::kFitted, 6, 2).cage),
            0.6 * CalcSignedVolume(Make(cone, CageShape::kBox, 6, 2).cage));
}

TEST(CageMaker, NamesGroupsByStationAndSide) {
  const MadeCage made = Make(MakeTurned({5, 5, 5}, 0), CageShape::kPrism, 3, 0);
  ASSERT_EQ(made.groups.size(), 15u);
  EXPECT_EQ(made.groups[5].name, "station_2");
  EXPECT_EQ(made.groups[5].vertices, (std::vector<int>{8, 9, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(made.groups[7].name, "station_2_high_y");
  EXPECT_EQ(made.groups[7].vertices.size(), 4u);
  for (const int v : made.groups[7].vertices) EXPECT_GT(made.cage.vertices[static_cast<std::size_t>(v)].y(), 0.0);
  EXPECT_EQ(made.groups[8].name, "station_2_low_z");
  for (const int v : made.groups[8].vertices) EXPECT_LT(made.cage.vertices[static_cast<std::size_t>(v)].z(), 0.0);
}

TEST(CageMaker, ParametersDoWhatTheirNamesSay) {
  const TriangleMesh mesh = MakeTurned({4, 8, 8, 4}, 0);
  const MadeCage made = Make(mesh, CageShape::kBox, 3, 0);
  const CageDesign design(mesh, made.cage, made.GetInitialTheta(), made.ListMoves());
  std::set<std::string> names;
  for (std::size_t i = 0; i < made.parameters.size(); ++i) {
    const CageParameter& p = made.parameters[i];
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
    EXPECT_LT(p.lower, p.initial);
    EXPECT_LT(p.initial, p.upper);
    for (const double bound : {p.lower, p.upper}) {
      VectorXd theta = made.GetInitialTheta();
      theta(static_cast<Eigen::Index>(i)) = bound;
      EXPECT_EQ(FindDefects(design.CalcMesh(theta)).Describe(), "") << p.name;
      const Vector3d before = CalcBoundingBox(made.cage).sizes();
      const Vector3d after = CalcBoundingBox(design.CalcCage(theta)).sizes();
      if (p.name.starts_with("length")) {
        EXPECT_NEAR(after.x() - before.x(), bound - p.initial, 1e-12) << p.name;
      }
    }
  }
  // 2 lengths, 3 widths, 3 heights, 6 offsets.
  EXPECT_EQ(names.size(), 14u);
  EXPECT_TRUE(names.count("offset_3_z"));

  // All widths at once stretch the cage along y, and mean value coordinates follow affine maps exactly.
  VectorXd theta = made.GetInitialTheta();
  for (std::size_t i = 0; i < made.parameters.size(); ++i) {
    if (made.parameters[i].name.starts_with("width")) theta(static_cast<Eigen::Index>(i)) += 3e-3;
  }
  const double cage = CalcBoundingBox(made.cage).sizes().y();
  const Vector3d stretched = CalcBoundingBox(design.CalcMesh(theta)).sizes();
  const Vector3d size = CalcBoundingBox(mesh).sizes();
  EXPECT_NEAR(stretched.y(), size.y() * (cage + 3e-3) / cage, 1e-12);
  EXPECT_NEAR(stretched.x(), size.x(), 1e-12);
  EXPECT_NEAR(stretched.z(), size.z(), 1e-12);
}

TEST(CageMaker, AMeshThatEndsInAPointHasAWidthThere) {
  TriangleMesh mesh = MakeTurned({6, 6, 6}, 1);
  for (Vector3d& v : mesh.vertices) {
    if (v.y() > 0.0199) v = Vector3d(0.0, 0.02, 0.0) + 1e-4 * (v - Vector3d(0.0, 0.02, 0.0));
  }
  ASSERT_EQ(FindDefects(mesh).Describe(), "");
  for (const CageParameter& p : Make(mesh, CageShape::kFitted, 9, 1).parameters) {
    EXPECT_LT(p.lower, p.upper) << p.name;
  }
}

TEST(CageMaker, RefusesWhatCannotBe) {
  const TriangleMesh mesh = MakeTurned({5, 5}, 0);
  EXPECT_THROW(MakeCage(mesh, {.stations = 1, .margin = 1e-3}), std::invalid_argument);
  EXPECT_THROW(MakeCage(mesh, {.stations = 4, .margin = 0.0}), std::invalid_argument);
}

}  // namespace cage_maker_test
}  // namespace knap
