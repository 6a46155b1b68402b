// Mass properties of meshes against closed forms, under rigid motions, and their pull-back against differences.
#include "sim/geometry/mass_properties.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace knap {
namespace mass_properties_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDensity = 1300.0;

// Sides along the axes, one corner at the origin.
TriangleMesh MakeBox(const Vector3d& sides) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) * sides.x(), (i >> 1 & 1) * sides.y(), (i >> 2) * sides.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh MakeTetrahedron() {
  return {{Vector3d::Zero(), Vector3d(1, 0, 0), Vector3d(0, 2, 0), Vector3d(0, 0, 3)},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

TEST(MassProperties, OfABox) {
  const Vector3d side(0.2, 0.3, 0.5);
  const TriangleMesh mesh = MakeBox(side);
  ASSERT_TRUE(FindDefects(mesh).empty());
  const MassProperties m = CalcMassProperties(mesh, kDensity);
  const double mass = kDensity * side.prod();
  EXPECT_NEAR(m.mass / mass, 1.0, 1e-14);
  EXPECT_LT((m.CalcCenter() - side / 2).norm(), 1e-15);
  const Vector3d s2 = side.cwiseAbs2();
  const Matrix3d expected = mass / 12.0 * (s2.sum() * Vector3d::Ones() - s2).asDiagonal();
  EXPECT_LT((m.CalcCentralInertia() - expected).norm(), 1e-13 * expected.norm());
}

TEST(MassProperties, OfATetrahedronAtTheOrigin) {
  // ∫x² = V a²/10 and ∫xy = V a b/20 for legs a, b, c along the axes.
  const MassProperties m = CalcMassProperties(MakeTetrahedron(), kDensity);
  EXPECT_NEAR(m.mass / kDensity, 1.0, 1e-14);
  EXPECT_LT((m.CalcCenter() - Vector3d(1, 2, 3) / 4).norm(), 1e-14);
  Matrix3d expected;
  expected << 1.3, -0.1, -0.15,  //
      -0.1, 1.0, -0.3,           //
      -0.15, -0.3, 0.5;
  EXPECT_LT((m.inertia / kDensity - expected).norm(), 1e-13);
}

TEST(MassProperties, FollowARigidMotionFarAway) {
  TriangleMesh mesh = MakeTetrahedron();
  const MassProperties before = CalcMassProperties(mesh, kDensity);
  const Matrix3d R = Eigen::AngleAxisd(0.8, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  for (Vector3d& v : mesh.vertices) v = R * v + Vector3d(1e3, -2e3, 5e2);
  const MassProperties after = CalcMassProperties(mesh, kDensity);
  EXPECT_NEAR(after.mass / before.mass, 1.0, 1e-11);
  EXPECT_LT((after.CalcCenter() - R * before.CalcCenter() - Vector3d(1e3, -2e3, 5e2)).norm(), 1e-9);
  // Taken back from a distance d the inertia loses (d/size)² of its digits: 1e6 × 1e-16 here.
  EXPECT_LT((after.CalcCentralInertia() - R * before.CalcCentralInertia() * R.transpose()).norm(),
            1e-8 * before.inertia.norm());
}

TEST(MassProperties, PullBackEqualsDifferences) {
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto u = [&] { return uniform(generator); };
  const auto vec = [&] { return Vector3d(Vector3d::NullaryExpr(u)); };
  for (int sample = 0; sample < 20; ++sample) {
    TriangleMesh mesh = MakeBox(Vector3d(0.8, 0.5, 1.1));
    for (Vector3d& v : mesh.vertices) v += 0.1 * vec() + Vector3d(0.4, -1.0, 0.2);
    const MassProperties bar{u(), vec(), Matrix3d::NullaryExpr(u)};
    const auto value = [&](const TriangleMesh& at) {
      const MassProperties m = CalcMassProperties(at, 2.0);
      return bar.mass * m.mass + bar.first_moment.dot(m.first_moment) + bar.inertia.cwiseProduct(m.inertia).sum();
    };
    const Eigen::Matrix3Xd g = PullBackMassProperties(mesh, 2.0, bar);
    double largest = 0.0;
    for (int i = 0; i < static_cast<int>(mesh.vertices.size()); ++i) {
      for (int k = 0; k < 3; ++k) {
        // Polynomials of the fifth degree: second-order differences with h = 1e-4 leave about 1e-8.
        TriangleMesh plus = mesh;
        TriangleMesh minus = mesh;
        plus.vertices[i](k) += 1e-4;
        minus.vertices[i](k) -= 1e-4;
        EXPECT_NEAR(g(k, i), (value(plus) - value(minus)) / 2e-4, 1e-7);
        largest = std::max(largest, std::abs(g(k, i)));
      }
    }
    EXPECT_GT(largest, 0.05);
  }
}

}  // namespace mass_properties_test
}  // namespace knap
