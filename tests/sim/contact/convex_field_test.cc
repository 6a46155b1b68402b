// Which meshes are convex, their planes and depth, and what they do to others: against sums over volume, and against
// boxes where they are some.
#include "sim/contact/convex_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/contact/contact_side.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/pair_sum.h"
#include "tests/sim/contact/patch_differences.h"

namespace knap {
namespace {

using Eigen::Vector3d;

TEST(ConvexField, HasAPlaneAFaceAndTheLargestBallInside) {
  const Vector3d half(0.01, 0.006, 0.008);
  const Vector3d center(0.001, 0.0, -0.002);
  const std::optional<PolyhedralField> box = MakeConvexField(test::MakeBoxMesh(half, center));
  ASSERT_TRUE(box);
  EXPECT_EQ(box->planes.size(), 6u);  // of twelve triangles
  for (const FieldPlane& plane : box->planes) {
    EXPECT_NEAR(plane.d, half.dot(plane.n.cwiseAbs()) + center.dot(plane.n), 1e-17);
  }
  EXPECT_NEAR(box->deepest, 0.006, 1e-15);
  EXPECT_EQ(box->bounds.max(), center + half);

  // Of a tetrahedron the ball's radius is three times the volume over the surface.
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0.0, 0.0, 0.0}, {0.02, 0.0, 0.0}, {0.003, 0.015, 0.0}, {0.004, 0.005, 0.03}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  double surface = 0.0;
  for (const Eigen::Vector3i& t : tetrahedron.triangles) {
    const Vector3d& a = tetrahedron.vertices[t[0]];
    surface += 0.5 * (tetrahedron.vertices[t[1]] - a).cross(tetrahedron.vertices[t[2]] - a).norm();
  }
  const std::optional<PolyhedralField> pointed = MakeConvexField(tetrahedron);
  ASSERT_TRUE(pointed);
  EXPECT_EQ(pointed->planes.size(), 4u);
  EXPECT_NEAR(pointed->deepest, 3.0 * CalcSignedVolume(tetrahedron) / surface, 1e-14);

  const TriangleMesh round = test::MakeRoundHull(0.01, 2);
  const std::optional<PolyhedralField> hull = MakeConvexField(round);
  ASSERT_TRUE(hull);
  EXPECT_EQ(hull->planes.size(), 128u);
  // It is the same seen from all eight octants: the ball is in the middle.
  double nearest = 1.0;
  for (const FieldPlane& plane : hull->planes) nearest = std::min(nearest, plane.d);
  EXPECT_NEAR(hull->deepest, nearest, 1e-14);
}

TEST(ConvexField, IsNoneWhereAVertexSticksOutOrFacesAreTooMany) {
  TriangleMesh mesh = test::MakeRoundHull(0.01, 1);
  mesh.vertices[7] *= 0.6;
  EXPECT_FALSE(MakeConvexField(mesh));
  // Two bodies, each of them convex.
  TriangleMesh two = test::MakeWedge();
  for (const Vector3d& x : test::MakeWedge().vertices) two.vertices.emplace_back(x + Vector3d(0.05, 0.0, 0.0));
  for (const Eigen::Vector3i& t : test::MakeWedge().triangles)
    two.triangles.emplace_back(t + Eigen::Vector3i::Constant(6));
  EXPECT_FALSE(MakeConvexField(two));
  EXPECT_EQ(MakeConvexField(test::MakeRoundHull(0.01, 3))->planes.size(), 512u);
  EXPECT_FALSE(MakeConvexField(test::MakeRoundHull(0.01, 4)));  // 2048
}

// As a file in single precision has it, turned, so that no coordinate is a round one.
TEST(ConvexField, TakesRoundedFiles) {
  TriangleMesh box = test::MakeBoxMesh({0.01, 0.006, 0.008}, {0.2, 0.1, 0.0});
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  for (Vector3d& x : box.vertices) x = (1e3 * (R * x)).cast<float>().cast<double>() * 1e-3;
  const std::optional<PolyhedralField> field = MakeConvexField(box);
  ASSERT_TRUE(field);
  EXPECT_EQ(field->planes.size(), 6u);
}

using test::CalcWrench;
using test::Wrench;

double CalcDepth(const PolyhedralField& field, const Vector3d& x, Vector3d* normal) {
  double least = 1.0;
  for (const FieldPlane& plane : field.planes) {
    const double e = plane.d - plane.n.dot(x);
    if (e >= least) continue;
    least = e;
    *normal = plane.n;
  }
  return least;
}

// Of E ∫ e_S dV over what both share, by the derivative under the integral: the force on what is at x in B is E n, n
// the normal of S's face that is nearest there.
Wrench SumOverVolume(const PolyhedralField& B, const PolyhedralField& S, const Pose& X_SB, double modulus) {
  constexpr int kParts = 120;
  const Vector3d step = B.bounds.sizes() / kParts;
  const double dF = modulus * step.prod();
  Wrench out;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j) {
      for (int k = 0; k < kParts; ++k) {
        const Vector3d x_B = B.bounds.min() + Vector3d(i + 0.5, j + 0.5, k + 0.5).cwiseProduct(step);
        Vector3d n;
        if (CalcDepth(B, x_B, &n) <= 0.0) continue;
        const Vector3d x = X_SB * x_B;
        if (CalcDepth(S, x, &n) <= 0.0) continue;
        out.F += dF * n;
        out.M += dF * x.cross(n);
      }
    }
  }
  return out;
}

TEST(ConvexField, WrenchesAreTheEnergysSlopes) {
  const TriangleMesh pyramid = test::MakePyramid();
  const TriangleMesh wedge = test::MakeWedge();
  const TriangleMesh round = test::MakeRoundHull(0.008, 1);
  const PolyhedralField of_pyramid = *MakeConvexField(pyramid);
  const PolyhedralField of_wedge = *MakeConvexField(wedge);
  const PolyhedralField of_round = *MakeConvexField(round);
  const PolyhedralField of_box = PolyhedralField::MakeBox({0.01, 0.006, 0.004}, Vector3d::Zero());
  const BoxGeometry box{{0.01, 0.006, 0.004}, Vector3d::Zero()};
  const MeshGeometry designed{std::make_shared<ContactMesh>(wedge)};
  struct Case {
    ContactGeometry a, b;
    const PolyhedralField& of_a;
    const PolyhedralField& of_b;
    bool both;
  };
  const Case cases[] = {{designed, *MakeConvexMesh(pyramid), of_wedge, of_pyramid, false},
                        {designed, *MakeConvexMesh(round), of_wedge, of_round, false},
                        {*MakeConvexMesh(wedge), *MakeConvexMesh(pyramid), of_wedge, of_pyramid, true},
                        {box, *MakeConvexMesh(round), of_box, of_round, true}};
  const Pose X_BA{Eigen::AngleAxisd(0.5, Vector3d(1.0, -0.4, 0.3).normalized()).toRotationMatrix(),
                  Vector3d(0.001, -0.002, 0.009)};
  const Pose X_AB{X_BA.R.transpose(), -(X_BA.R.transpose() * X_BA.p)};
  for (const Case& c : cases) {
    const Wrench exact = CalcWrench(c.a, c.b, X_BA);
    Wrench sum = SumOverVolume(c.of_a, c.of_b, X_BA, c.both ? 0.5e9 : 1e9);
    if (c.both) {
      const Wrench other = SumOverVolume(c.of_b, c.of_a, X_AB, 0.5e9);
      const Vector3d F = -(X_BA.R * other.F);
      sum.F += F;
      sum.M += -(X_BA.R * other.M) + X_BA.p.cross(F);
    }
    // The lattice misses by some thousandths: its parts are a 120th of the body, which is some 0.01 m large.
    ASSERT_GT(sum.F.norm(), 0.01);
    EXPECT_LE((exact.F - sum.F).norm(), 0.01 * sum.F.norm()) << exact.F.transpose() << " : " << sum.F.transpose();
    EXPECT_LE((exact.M - sum.M).norm(), 0.01 * 0.01 * sum.F.norm())
        << exact.M.transpose() << " : " << sum.M.transpose();
  }
}

TEST(ConvexField, ABoxOfTrianglesIsABox) {
  const Vector3d half(0.01, 0.006, 0.008);
  const Vector3d center(0.001, 0.0, -0.002);
  const BoxGeometry box{half, center};
  const MeshGeometry mesh = *MakeConvexMesh(test::MakeBoxMesh(half, center));
  const ContactGeometry others[] = {HalfSpaceGeometry{},
                                    SphereGeometry{0.007, {0.0, 0.001, 0.0}},
                                    CapsuleGeometry{0.004, 0.006, Vector3d::Zero()},
                                    BoxGeometry{{0.005, 0.007, 0.006}, Vector3d::Zero()},
                                    *MakeConvexMesh(test::MakePyramid()),
                                    MeshGeometry{std::make_shared<ContactMesh>(test::MakeWedge())}};
  const Pose X_BA{Eigen::AngleAxisd(0.4, Vector3d(0.7, 0.4, -0.2).normalized()).toRotationMatrix(),
                  Vector3d(0.002, -0.001, 0.006)};
  for (const ContactGeometry& other : others) {
    const Wrench of_box = CalcWrench(box, other, X_BA);
    const Wrench of_mesh = CalcWrench(mesh, other, X_BA);
    ASSERT_GT(of_box.F.norm(), 1.0) << other.index();
    // Arcs are summed to some 1e-11, and faces are cut into triangles by one of two diagonals.
    EXPECT_LE((of_box.F - of_mesh.F).norm(), 1e-10 * of_box.F.norm()) << other.index();
    EXPECT_LE((of_box.M - of_mesh.M).norm(), 1e-10 * 0.01 * of_box.F.norm()) << other.index();
  }
}

TEST(ConvexField, OfTwoMeshesOneMustHaveAFieldOrPieces) {
  TriangleMesh dented = test::MakeRoundHull(0.01, 1);
  dented.vertices[7] *= 0.6;
  EXPECT_FALSE(MakeConvexMesh(dented));
  const MeshGeometry designed{std::make_shared<ContactMesh>(dented)};
  ContactPair pair;
  pair.bodies = {0, 1};
  pair.shapes = {designed, designed};
  EXPECT_THROW(MakeSides({pair}), std::invalid_argument);
  pair.shapes = {designed, *MakeConvexMesh(test::MakePyramid())};
  const std::vector<ContactSide> sides = MakeSides({pair});
  ASSERT_EQ(sides.size(), 1u);
  EXPECT_EQ(sides[0].body, 0);
  EXPECT_TRUE(sides[0].is_designed);
}

}  // namespace
}  // namespace knap
