// Checks the closed-form integrals against brute-force quadrature, against cutting the triangle, and against
// differences.
#include "sim/contact/sphere_triangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadius = 10.0;

struct Case {
  TriangleFrame triangle;
  Vector3d c;
};

Case MakeRandomCase(std::mt19937_64* generator) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto random = [&] { return Vector3d(u(*generator), u(*generator), u(*generator)); };
  const Vector3d v0 = 4.0 * random();
  const Vector3d v1 = v0 + 5.0 * random();
  const Vector3d v2 = v0 + 5.0 * random();
  const TriangleFrame triangle = TriangleFrame::Make(v0, v1, v2);
  const Vector3d centroid = (v0 + v1 + v2) / 3.0;
  // Depths up to 0.8 mm at a radius of 10 mm: discs of up to 4 mm, about the triangle's size.
  const double depth = 0.4 + 0.4 * u(*generator);
  return {triangle, centroid + triangle.n * (kRadius - depth) + 2.0 * random().cross(triangle.n)};
}

struct Quadrature {
  double W = 0.0;
  Vector3d g = Vector3d::Zero();
};

// Midpoint rule on n² small triangles, an independent evaluation of the definition.
Quadrature Integrate(const TriangleFrame& t, const Vector3d& c, int n) {
  Quadrature out;
  const Vector3d e1 = (t.v[1] - t.v[0]) / n;
  const Vector3d e2 = (t.v[2] - t.v[0]) / n;
  const double area = 0.5 * e1.cross(e2).norm();
  const auto add = [&](const Vector3d& x) {
    const double f = kRadius * kRadius - (x - c).squaredNorm();
    if (f <= 0.0) return;
    out.W += f * area;
    out.g += f * area * (c - x);
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n - i; ++j) {
      const Vector3d corner = t.v[0] + i * e1 + j * e2;
      add(corner + (e1 + e2) / 3.0);
      if (i + j < n - 1) add(corner + 2.0 * (e1 + e2) / 3.0);
    }
  }
  return out;
}

TEST(SphereTriangle, EqualsQuadrature) {
  std::mt19937_64 generator(1);
  int active = 0;
  for (int i = 0; i < 200; ++i) {
    const Case test = MakeRandomCase(&generator);
    const SphereTriangleIntegrals exact = CalcSphereTriangle(test.triangle, test.c, kRadius);
    const Quadrature numeric = Integrate(test.triangle, test.c, 400);
    // The midpoint rule with 400 divisions leaves about 1e-4 of the largest value at the disc's edge.
    EXPECT_NEAR(exact.W, numeric.W, 2e-4 * (1.0 + numeric.W)) << "case " << i;
    EXPECT_LT((exact.g - numeric.g).norm(), 2e-4 * (1.0 + numeric.g.norm())) << "case " << i;
    active += exact.active;
  }
  EXPECT_GT(active, 100);
}

TEST(SphereTriangle, CuttingATriangleChangesNothing) {
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> u(0.05, 0.95);
  for (int i = 0; i < 500; ++i) {
    const Case test = MakeRandomCase(&generator);
    const auto& v = test.triangle.v;
    const double s = u(generator);
    const double t = u(generator) * (1.0 - s);
    const Vector3d inner = v[0] + s * (v[1] - v[0]) + t * (v[2] - v[0]);
    const SphereTriangleIntegrals whole = CalcSphereTriangle(test.triangle, test.c, kRadius);
    double W = 0.0;
    Vector3d g = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const auto part = CalcSphereTriangle(TriangleFrame::Make(v[k], v[(k + 1) % 3], inner), test.c, kRadius);
      W += part.W;
      g += part.g;
    }
    // Rounding of sums of terms up to 1e3.
    EXPECT_NEAR(whole.W, W, 1e-10) << "case " << i;
    EXPECT_LT((whole.g - g).norm(), 1e-9) << "case " << i;
  }
}

TEST(SphereTriangle, ALargeTriangleIsAPlane) {
  const TriangleFrame triangle =
      TriangleFrame::Make(Vector3d(-300, -200, 1), Vector3d(400, -200, 1), Vector3d(0, 500, 1));
  const Vector3d c(3.0, 4.0, 10.5);
  const auto a = CalcSphereTriangle(triangle, c, kRadius);
  const auto b = CalcSpherePlane(Vector3d::UnitZ(), 9.5, kRadius);
  EXPECT_NEAR(a.W, b.W, 1e-12 * b.W);
  EXPECT_LT((a.g - b.g).norm(), 1e-12 * b.g.norm());
  // Closed form: W = π a⁴ / 2 with a² = r² − h² = 9.75.
  EXPECT_NEAR(b.W, std::acos(-1.0) * 9.75 * 9.75 / 2.0, 1e-10);
}

TEST(SphereTriangle, JacobianEqualsDifferences) {
  std::mt19937_64 generator(3);
  const double step = 1e-5;
  int active = 0;
  for (int i = 0; i < 300; ++i) {
    const Case test = MakeRandomCase(&generator);
    const auto at = CalcSphereTriangle(test.triangle, test.c, kRadius);
    if (!at.active || at.W < 1e-2) continue;
    ++active;
    const SphereTriangleJacobian jacobian = CalcSphereTriangleJacobian(at, test.triangle.n);
    for (int k = 0; k < 3; ++k) {
      const Vector3d d = step * Vector3d::Unit(k);
      const auto plus = CalcSphereTriangle(test.triangle, test.c + d, kRadius);
      const auto minus = CalcSphereTriangle(test.triangle, test.c - d, kRadius);
      // Central differences: rounding 1e-12/step, truncation step² times a third derivative of order 1e2.
      EXPECT_NEAR(jacobian.dW_dc(k), (plus.W - minus.W) / (2 * step), 1e-6 * (1 + jacobian.dW_dc.norm()));
      EXPECT_LT((jacobian.dg_dc.col(k) - (plus.g - minus.g) / (2 * step)).norm(), 1e-6 * (1.0 + jacobian.dg_dc.norm()));
    }
  }
  EXPECT_GT(active, 100);
}

TEST(SphereTriangle, PullBackEqualsDifferencesForEveryVertex) {
  std::mt19937_64 generator(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const double step = 1e-5;
  int active = 0;
  for (int i = 0; i < 300; ++i) {
    const Case test = MakeRandomCase(&generator);
    const auto at = CalcSphereTriangle(test.triangle, test.c, kRadius);
    if (!at.active || at.W < 1e-2) continue;
    ++active;
    const double bar_W = u(generator);
    const Vector3d bar_g(u(generator), u(generator), u(generator));
    const auto bar_v = PullBackSphereTriangle(test.triangle, at, test.c, kRadius, bar_W, bar_g);
    for (int vertex = 0; vertex < 3; ++vertex) {
      for (int k = 0; k < 3; ++k) {
        const auto phi = [&](double s) {
          auto v = test.triangle.v;
          v[vertex][k] += s;
          const auto moved = CalcSphereTriangle(TriangleFrame::Make(v[0], v[1], v[2]), test.c, kRadius);
          return bar_W * moved.W + bar_g.dot(moved.g);
        };
        const double scale = 1.0 + bar_v[0].norm() + bar_v[1].norm() + bar_v[2].norm();
        EXPECT_NEAR(bar_v[vertex][k], (phi(step) - phi(-step)) / (2 * step), 2e-6 * scale) << "case " << i;
      }
    }
  }
  EXPECT_GT(active, 100);
}

TEST(SphereTriangle, OnsetIsSmooth) {
  // At the first touch both integrals rise from zero with zero slope.
  const TriangleFrame triangle = TriangleFrame::Make(Vector3d(0, 0, 0), Vector3d(3, 0, 0), Vector3d(0, 3, 0));
  for (const double depth : {1e-3, 1e-4, 1e-5}) {
    const auto face = CalcSphereTriangle(triangle, Vector3d(1, 1, kRadius - depth), kRadius);
    EXPECT_NEAR(face.W / (depth * depth), 2.0 * std::acos(-1.0) * kRadius * kRadius, 0.01 * 628.0);
    const auto corner = CalcSphereTriangle(triangle, Vector3d(-(kRadius - depth), 0, 0) / std::sqrt(1.0), kRadius);
    EXPECT_LT(corner.W, 1e3 * depth * depth);
  }
}

}  // namespace
}  // namespace knap
