// Measures of shapes against closed forms, their gradients against differences, and the rays that find walls against
// all triangles one by one.
#include "sim/geometry/shape_measures.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace knap {
namespace shape_measures_test {

using Eigen::Vector3d;
using Eigen::Vector3i;

TriangleMesh MakeBox(const Vector3d& low, const Vector3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh MakeHollowBox(double inner, double outer) {
  TriangleMesh mesh = MakeBox(Vector3d::Constant(-outer), Vector3d::Constant(outer));
  const TriangleMesh cavity = MakeBox(Vector3d::Constant(-inner), Vector3d::Constant(inner));
  mesh.vertices.insert(mesh.vertices.end(), cavity.vertices.begin(), cavity.vertices.end());
  for (const Vector3i& t : cavity.triangles) mesh.triangles.emplace_back(t[0] + 8, t[2] + 8, t[1] + 8);
  return mesh;
}

// A prism along z over the triangle with its apex at the origin and sides of length 1 at `angle`.
TriangleMesh MakeWedge(double angle) {
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    mesh.vertices.emplace_back(0.0, 0.0, z);
    mesh.vertices.emplace_back(1.0, 0.0, z);
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), z);
  }
  mesh.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
  return mesh;
}

// Of rings of vertices around the z axis, all at random distances from it that keep them apart.
TriangleMesh MakeBumpyBall(int rings, int sides, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> radius(0.8, 1.2);
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, -1.0);
  for (int i = 1; i < rings; ++i) {
    for (int k = 0; k < sides; ++k) {
      const double polar = std::numbers::pi * (1.0 - static_cast<double>(i) / rings);
      const double azimuth = 2.0 * std::numbers::pi * k / sides;
      const Vector3d n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
      mesh.vertices.push_back(radius(random) * n);
    }
  }
  mesh.vertices.emplace_back(0.0, 0.0, 1.0);
  const int top = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [&](int ring, int k) { return 1 + (ring - 1) * sides + k % sides; };
  for (int k = 0; k < sides; ++k) {
    mesh.triangles.emplace_back(0, at(1, k + 1), at(1, k));
    mesh.triangles.emplace_back(top, at(rings - 1, k), at(rings - 1, k + 1));
    for (int i = 1; i + 1 < rings; ++i) {
      mesh.triangles.emplace_back(at(i, k), at(i, k + 1), at(i + 1, k + 1));
      mesh.triangles.emplace_back(at(i, k), at(i + 1, k + 1), at(i + 1, k));
    }
  }
  return mesh;
}

// Every entry of the gradient by differences of fourth order over a share of the mesh's size.
void ExpectGradient(const TriangleMesh& mesh, const std::function<ShapeMeasure(const TriangleMesh&)>& measure,
                    double step, double tolerance) {
  const ShapeMeasure at = measure(mesh);
  const double h = step * CalcBoundingBox(mesh).diagonal().norm();
  const double largest = at.gradient.cwiseAbs().maxCoeff();
  ASSERT_GT(largest, 0.0);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto central = [&](double d) {
        TriangleMesh above = mesh, below = mesh;
        above.vertices[i][k] += d;
        below.vertices[i][k] -= d;
        return (measure(above).value - measure(below).value) / (2.0 * d);
      };
      const double difference = (4.0 * central(0.5 * h) - central(h)) / 3.0;
      EXPECT_NEAR(at.gradient(k, static_cast<Eigen::Index>(i)), difference, tolerance * largest) << i << " " << k;
    }
  }
}

TEST(ShapeMeasures, OfABox) {
  const Vector3d size(0.040, 0.012, 0.020);
  const TriangleMesh box = MakeBox(Vector3d(-0.01, 0.3, 0.0), Vector3d(-0.01, 0.3, 0.0) + size);
  EXPECT_NEAR(MeasureVolume(box).value, size.prod(), 1e-12 * size.prod());
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(MeasureExtent(box, k).value, size[k], 1e-15);
  // Each pair of sides is a wall, by area.
  for (const double blend : {0.5e-3, 5e-3, 0.1}) {
    double sum = 0.0, weighted = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double weight = size.prod() / size[k] * std::exp(-size[k] / blend);
      sum += weight;
      weighted += weight * size[k];
    }
    EXPECT_NEAR(MeasureThickness(box, blend).value, weighted / sum, 1e-12) << blend;
  }
  EXPECT_NEAR(MeasureThickness(box, 0.2e-3).value, 0.012, 1e-15);
}

TEST(ShapeMeasures, TheWallOfAHollowBodyIsItsThickness) {
  EXPECT_NEAR(MeasureThickness(MakeHollowBox(0.018, 0.020), 0.1e-3).value, 0.002, 1e-12);
}

TEST(ShapeMeasures, AWallThatOpensIsLessAndLessOne) {
  for (const double degrees : {10.0, 30.0, 45.0, 60.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const TriangleMesh wedge = MakeWedge(angle);
    ASSERT_TRUE(FindDefects(wedge).empty()) << FindDefects(wedge).Describe();
    const RayCaster caster(wedge);
    std::vector<int> scratch;
    // From the side along x, at the distance s from the apex.
    const double s = 0.3;
    const auto hit =
        caster.FindNext(Vector3d(s, 0.0, 0.4), Vector3d::UnitY(), 2, RayCaster::Crossing::kLeaving, &scratch);
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->distance, s * std::tan(angle), 1e-14);
    EXPECT_NEAR(CalcWall(*hit), s * std::tan(angle) / std::pow(std::cos(angle), 2), 1e-13) << degrees;
  }
}

TEST(ShapeMeasures, HaveExactGradients) {
  TriangleMesh box = MakeBox(Vector3d::Zero(), Vector3d(0.040, 0.012, 0.020));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
  for (Vector3d& v : box.vertices) v += Vector3d(shift(random), shift(random), shift(random));
  const TriangleMesh ball = MakeBumpyBall(5, 7, 3);
  ASSERT_TRUE(FindDefects(ball).empty()) << FindDefects(ball).Describe();
  for (const TriangleMesh* mesh : std::initializer_list<const TriangleMesh*>{&box, &ball}) {
    const double size = CalcBoundingBox(*mesh).diagonal().norm();
    ExpectGradient(*mesh, MeasureVolume, 1e-3, 1e-9);
    for (int k = 0; k < 3; ++k) {
      ExpectGradient(
          *mesh, [k](const TriangleMesh& m) { return MeasureExtent(m, k); }, 1e-4, 1e-9);
    }
    // Small steps: the slope jumps where a ray comes to another triangle.
    for (const double blend : {0.02, 0.1, 1.0}) {
      ExpectGradient(
          *mesh, [=](const TriangleMesh& m) { return MeasureThickness(m, blend * size); }, 1e-7, 1e-7);
    }
  }
}

TEST(RayCaster, FindsWhatAllTrianglesOneByOneHave) {
  const TriangleMesh mesh = MakeBumpyBall(12, 20, 5);
  const RayCaster caster(mesh);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<int> scratch;
  int hits = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const int from = static_cast<int>(random() % mesh.triangles.size());
    const Vector3i& t = mesh.triangles[static_cast<std::size_t>(from)];
    const Vector3d p = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
    const Vector3d direction = Vector3d(normal(random), normal(random), normal(random)).normalized();
    for (const auto crossing : {RayCaster::Crossing::kLeaving, RayCaster::Crossing::kEntering}) {
      // By barycentric coordinates from a linear system, not by edges.
      int best = -1;
      double distance = 1e9;
      for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
        if (i == from) continue;
        const Vector3i& u = mesh.triangles[static_cast<std::size_t>(i)];
        Eigen::Matrix3d A;
        A << mesh.vertices[u[1]] - mesh.vertices[u[0]], mesh.vertices[u[2]] - mesh.vertices[u[0]], -direction;
        const Vector3d n = A.col(0).cross(A.col(1));
        if ((n.dot(direction) > 0.0) != (crossing == RayCaster::Crossing::kLeaving)) continue;
        const Vector3d x = A.inverse() * (p - mesh.vertices[u[0]]);
        if (x[0] < 0.0 || x[1] < 0.0 || x[0] + x[1] > 1.0 || x[2] <= 1e-12 || x[2] >= distance) continue;
        best = i;
        distance = x[2];
      }
      const auto hit = caster.FindNext(p, direction, from, crossing, &scratch);
      ASSERT_EQ(hit.has_value(), best >= 0) << trial;
      if (!hit) continue;
      ++hits;
      EXPECT_EQ(hit->triangle, best) << trial;
      EXPECT_NEAR(hit->distance, distance, 1e-12);
    }
  }
  EXPECT_GT(hits, 1000);
}

}  // namespace shape_measures_test
}  // namespace knap
