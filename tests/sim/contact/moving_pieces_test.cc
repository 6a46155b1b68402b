// Designed meshes on one another: against hulls where they are some, and their cotangents against differences.
#include "sim/contact/moving_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim/contact/convex_field.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/designed_meshes.h"
#include "tests/sim/contact/pair_sum.h"
#include "tests/sim/contact/random_places.h"

namespace knap {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using test::MakeDesigned;

// Two boxes in an L, of which no plane bounds both.
TriangleMesh MakeBracket() {
  TriangleMesh out;
  const double y[] = {-0.004, 0.005};
  const Eigen::Vector2d outline[] = {{0.0, 0.0},     {0.016, 0.0},   {0.016, 0.006},
                                     {0.006, 0.006}, {0.006, 0.018}, {0.0, 0.018}};
  for (const double at : y) {
    for (const Eigen::Vector2d& p : outline) out.vertices.emplace_back(p.x() - 0.004, at, p.y() - 0.004);
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    out.triangles.emplace_back(a, b, c);
    out.triangles.emplace_back(6 + a, 6 + c, 6 + b);
  }
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    out.triangles.emplace_back(k, 6 + k, 6 + next);
    out.triangles.emplace_back(k, 6 + next, next);
  }
  return out;
}

TEST(MovingPieces, AConvexMeshIsOneAndHasItsPlanes) {
  const TriangleMesh mesh = test::MakeBoxMesh({0.01, 0.006, 0.008}, {0.001, 0.0, -0.002});
  const std::vector<PieceFaces> faces = FindPieceFaces(mesh);
  ASSERT_EQ(faces.size(), 1u);
  ASSERT_EQ(faces[0].size(), 6u);
  for (const PieceFace& face : faces[0]) EXPECT_EQ(face.size(), 2u);
  const MovingPieces pieces = *MovePieces(faces, mesh.vertices);
  const PolyhedralField expected = *MakeConvexField(mesh);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_LE((pieces.fields[0].planes[i].n - expected.planes[i].n).norm(), 1e-15);
    EXPECT_NEAR(pieces.fields[0].planes[i].d, expected.planes[i].d, 1e-17);
  }
  EXPECT_NEAR(pieces.fields[0].deepest, 0.006, 1e-14);
  EXPECT_LE((pieces.fields[0].bounds.max() - expected.bounds.max()).norm(), 1e-14);
  EXPECT_LE((pieces.fields[0].bounds.min() - expected.bounds.min()).norm(), 1e-14);
}

// Where a face is bent the planes may reach out of the vertices' box, and the bounds with them.
TEST(MovingPieces, BoundsHoldAllThatThePlanesDo) {
  test::RandomPlaces random(3);
  for (int trial = 0; trial < 20; ++trial) {
    TriangleMesh mesh = test::MakeBoxMesh({0.01, 0.006, 0.008}, Vector3d::Zero());
    const std::vector<PieceFaces> faces = FindPieceFaces(mesh);
    for (Vector3d& x : mesh.vertices) x += random.Vec(0.003);
    const PolyhedralField field = MovePieces(faces, mesh.vertices)->fields[0];
    Vector3d most = Vector3d::Constant(-1.0), least = Vector3d::Constant(1.0);
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d x = random.Vec(0.03);
      if (std::any_of(field.planes.begin(), field.planes.end(),
                      [&](const FieldPlane& plane) { return plane.CalcHeight(x) > 0.0; })) {
        continue;
      }
      ++inside;
      most = most.cwiseMax(x);
      least = least.cwiseMin(x);
    }
    ASSERT_GT(inside, 100);
    EXPECT_TRUE((most.array() <= field.bounds.max().array()).all());
    EXPECT_TRUE((least.array() >= field.bounds.min().array()).all());
    // And no more: the outermost of so many places is near.
    EXPECT_LE((field.bounds.max() - most).maxCoeff(), 0.005);
    EXPECT_LE((least - field.bounds.min()).maxCoeff(), 0.005);
  }
}

TEST(MovingPieces, WhatIsFoldedHasNone) {
  TriangleMesh mesh = test::MakeBoxMesh({0.01, 0.006, 0.008}, Vector3d::Zero());
  const std::vector<PieceFaces> faces = FindPieceFaces(mesh);
  ASSERT_TRUE(MovePieces(faces, mesh.vertices));
  for (Vector3d& x : mesh.vertices) x.z() = -x.z();
  EXPECT_FALSE(MovePieces(faces, mesh.vertices));
}

TEST(MovingPieces, DesignedMeshesThatAreConvexTouchAsHulls) {
  const TriangleMesh meshes[] = {test::MakeWedge(), test::MakePyramid(), test::MakeRoundHull(0.008, 1)};
  test::RandomPlaces random(4);
  for (const TriangleMesh& a : meshes) {
    for (const TriangleMesh& b : meshes) {
      Pose X_BA = random.MakePose(0.5, 0.002);
      X_BA.p.z() += 0.008;
      const test::Wrench expected = test::CalcWrench(*MakeConvexMesh(a), *MakeConvexMesh(b), X_BA);
      const test::Wrench found = test::CalcWrench(MakeDesigned(a), MakeDesigned(b), X_BA);
      ASSERT_GT(expected.F.norm(), 0.1);
      EXPECT_LE((found.F - expected.F).norm(), 1e-11 * expected.F.norm());
      EXPECT_LE((found.M - expected.M).norm(), 1e-11 * 0.01 * expected.F.norm());
    }
  }
}

// What is not convex is taken apart, and what lies in its corner touches neither leg.
TEST(MovingPieces, ABracketHasAnInside) {
  const TriangleMesh bracket = MakeBracket();
  const std::vector<PieceFaces> faces = FindPieceFaces(bracket);
  EXPECT_GE(faces.size(), 2u);
  const MeshGeometry designed = MakeDesigned(bracket, faces);
  const MeshGeometry block = MakeDesigned(test::MakeBoxMesh({0.004, 0.004, 0.004}, Vector3d::Zero()));
  const auto force_at = [&](const Vector3d& p) {
    return test::CalcWrench(block, designed, {Eigen::Matrix3d::Identity(), p}).F;
  };
  // The corner is at (2, ·, 2) mm.
  EXPECT_EQ(force_at({0.0063, 0.0, 0.0063}).norm(), 0.0);
  const Vector3d on_floor = force_at({0.008, 0.0, 0.0059});
  EXPECT_GT(on_floor.z(), 10.0 * std::hypot(on_floor.x(), on_floor.y()));
  const Vector3d on_wall = force_at({0.0059, 0.0, 0.009});
  EXPECT_GT(on_wall.x(), 10.0 * std::hypot(on_wall.y(), on_wall.z()));
}

// Of a random sum of all that a pair's patches are, by the vertices of both meshes.
TEST(MovingPieces, VerticesOfBothMeshesHaveTheirCotangents) {
  const std::pair<TriangleMesh, TriangleMesh> pairs[] = {{test::MakeWedge(), test::MakePyramid()},
                                                         {MakeBracket(), test::MakeRoundHull(0.008, 1)},
                                                         {MakeBracket(), MakeBracket()}};
  test::RandomPlaces random(5);
  for (const auto& [a, b] : pairs) {
    const std::vector<PieceFaces> of_a = FindPieceFaces(a);
    const std::vector<PieceFaces> of_b = FindPieceFaces(b);
    Pose X_BA = random.MakePose(0.5, 0.002);
    X_BA.p.z() += 0.009;
    const Pose X_AB{X_BA.R.transpose(), -(X_BA.R.transpose() * X_BA.p)};
    const auto make_sides = [&](const TriangleMesh& first, const TriangleMesh& second) {
      ContactPair pair;
      pair.bodies = {0, 1};
      pair.shapes = {MakeDesigned(first, of_a), MakeDesigned(second, of_b)};
      pair.material.stiffness = 1e9;
      return MakeSides({pair});
    };
    std::vector<std::vector<PatchCotangent>> bars;
    const auto sum = [&](const std::vector<ContactSide>& sides, std::array<Matrix3Xd, 2>* bar_vertices) {
      double out = 0.0;
      for (std::size_t s = 0; s < sides.size(); ++s) {
        const ContactSide& side = sides[s];
        NearFacets near(side);
        SidePatches at;
        CalcPatches(side, &near, side.body == 0 ? X_BA : X_AB, &at);
        if (bars.size() == s) {
          bars.emplace_back(at.patches.size());
          for (PatchCotangent& bar : bars.back()) {
            // Each of about the same weight: forces are some newtons, places and areas of 0.01 m and 1e-6 m².
            bar.F = random.Vec(1.0);
            bar.M = random.Vec(100.0);
            bar.W = random.U(-1e9, 1e9);
            bar.m1 = random.Vec(1e11);
            const Eigen::Matrix3d m = 1e13 * random.Vec(1.0) * random.Vec(1.0).transpose();
            bar.m2 = m + m.transpose();
          }
        }
        for (std::size_t c = 0; c < at.patches.size(); ++c) {
          const PatchIntegrals& p = at.patches[c];
          const PatchCotangent& bar = bars[s][c];
          out += bar.F.dot(p.F) + bar.M.dot(p.M) + bar.W * p.W + bar.m1.dot(p.m1) + bar.m2.cwiseProduct(p.m2).sum();
        }
        if (bar_vertices == nullptr) continue;
        PullBackVertices(side, at, bars[s], &(*bar_vertices)[static_cast<std::size_t>(side.shape)],
                         &(*bar_vertices)[static_cast<std::size_t>(1 - side.shape)]);
      }
      return out;
    };
    std::array<Matrix3Xd, 2> bar{Matrix3Xd::Zero(3, static_cast<Eigen::Index>(a.vertices.size())),
                                 Matrix3Xd::Zero(3, static_cast<Eigen::Index>(b.vertices.size()))};
    ASSERT_NE(sum(make_sides(a, b), &bar), 0.0);
    for (int which = 0; which < 2; ++which) {
      const Matrix3Xd& of_mesh = bar[static_cast<std::size_t>(which)];
      const double largest = of_mesh.cwiseAbs().maxCoeff();
      for (Eigen::Index i = 0; i < of_mesh.cols(); ++i) {
        for (int k = 0; k < 3; ++k) {
          const auto at = [&](double h) {
            TriangleMesh first = a, second = b;
            (which == 0 ? first : second).vertices[static_cast<std::size_t>(i)](k) += h;
            return sum(make_sides(first, second), nullptr);
          };
          constexpr double h = 1e-7;
          const double slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
          EXPECT_NEAR(of_mesh(k, i), slope, 1e-6 * largest) << "mesh " << which << ", vertex " << i << ", " << k;
        }
      }
    }
  }
}

}  // namespace
}  // namespace knap
