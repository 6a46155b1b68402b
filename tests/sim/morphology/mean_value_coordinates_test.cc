#include "sim/morphology/mean_value_coordinates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>

namespace knap {
namespace mean_value_coordinates_test {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigen::VectorXd;
using ::testing::HasSubstr;

TriangleMesh MakeTetrahedron() {
  return {{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0.2, 1.1, 0), Vector3d(0.3, 0.2, 0.9)},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

// A prism over the polygon that is a fan about its first corner, z 0..height.
TriangleMesh MakePrism(const std::vector<Eigen::Vector2d>& polygon, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(polygon.size());
  for (const Eigen::Vector2d& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), 0);
  for (const Eigen::Vector2d& p : polygon) mesh.vertices.emplace_back(p.x(), p.y(), height);
  for (int i = 1; i + 1 < n; ++i) {
    mesh.triangles.emplace_back(0, i + 1, i);
    mesh.triangles.emplace_back(n, n + i, n + i + 1);
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.emplace_back(i, j, n + j);
    mesh.triangles.emplace_back(i, n + j, n + i);
  }
  return mesh;
}

TriangleMesh MakeBox() { return MakePrism({{0, 0}, {1.5, 0}, {1.5, 1}, {0, 1}}, 0.8); }

// Like the letter L; its inner corner is at (1, 1).
TriangleMesh MakeConcaveCage() { return MakePrism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 1); }

std::vector<TriangleMesh> MakeCages() { return {MakeTetrahedron(), MakeBox(), MakeConcaveCage()}; }

Vector3d DrawPoint(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double x = uniform(*random), y = uniform(*random), z = uniform(*random);
  return {x, y, z};
}

// A point of the box around the cage blown up by a half: inside or outside.
Vector3d DrawNear(const TriangleMesh& cage, std::mt19937* random) {
  const Eigen::AlignedBox3d box = CalcBoundingBox(cage);
  return box.center() + 0.75 * box.sizes().cwiseProduct(DrawPoint(random));
}

// A convex combination of all vertices.
Vector3d DrawInsideConvex(const TriangleMesh& cage, std::mt19937* random) {
  std::exponential_distribution<double> exponential;
  Vector3d sum = Vector3d::Zero();
  double total = 0;
  for (const Vector3d& v : cage.vertices) {
    const double weight = exponential(*random);
    sum += weight * v;
    total += weight;
  }
  return sum / total;
}

Vector3d Combine(const VectorXd& weights, const TriangleMesh& cage) {
  Vector3d sum = Vector3d::Zero();
  for (size_t j = 0; j < cage.vertices.size(); ++j) sum += weights[static_cast<int>(j)] * cage.vertices[j];
  return sum;
}

TriangleMesh Transform(TriangleMesh mesh, const Eigen::Affine3d& map) {
  for (Vector3d& v : mesh.vertices) v = map * v;
  return mesh;
}

double MaxDifference(const VectorXd& a, const VectorXd& b) { return (a - b).lpNorm<Eigen::Infinity>(); }

TEST(MeanValueCoordinates, SumToOneAndReproduceThePoint) {
  std::mt19937 random(1);
  for (const TriangleMesh& cage : MakeCages()) {
    for (int i = 0; i < 500; ++i) {
      const Vector3d p = DrawNear(cage, &random);
      const VectorXd weights = CalcMeanValueCoordinates(cage, p);
      // Outside the total before normalisation may be small and the weights large: rounding scales with them.
      const double scale = weights.lpNorm<1>();
      EXPECT_NEAR(weights.sum(), 1, 1e-14 * scale);
      EXPECT_LT((Combine(weights, cage) - p).norm(), 1e-13 * scale);
    }
  }
}

// Height h above the inside of a face, from far away down to the snap: the weights of the published form lose
// up to eight digits here.
TEST(MeanValueCoordinates, StayExactNearFaces) {
  std::mt19937 random(2);
  for (const TriangleMesh& cage : MakeCages()) {
    for (const Vector3i& t : cage.triangles) {
      const Vector3d a = cage.vertices[t[0]], b = cage.vertices[t[1]], c = cage.vertices[t[2]];
      const Vector3d inward = -(b - a).cross(c - a).normalized();
      for (double h = 0.1; h > 1e-15; h /= 10) {
        const Vector3d s = (DrawPoint(&random) + Vector3d::Constant(1.1)).normalized().cwiseAbs2();
        const Vector3d p = s[0] * a + s[1] * b + s[2] * c + h * inward;
        const VectorXd weights = CalcMeanValueCoordinates(cage, p);
        EXPECT_NEAR(weights.sum(), 1, 1e-14) << h;
        // Within the snap the weights are those of the face's nearest point, at distance h.
        const double snapped = h < 1e-11 ? 1.1 * h : 0;
        EXPECT_LT((Combine(weights, cage) - p).norm(), 1e-14 + snapped) << h;
      }
    }
  }
}

TEST(MeanValueCoordinates, MoveByTheCagesAffineMap) {
  std::mt19937 random(3);
  for (const TriangleMesh& cage : MakeCages()) {
    for (int i = 0; i < 20; ++i) {
      Eigen::Affine3d map;
      map.linear() << DrawPoint(&random), DrawPoint(&random), DrawPoint(&random);
      map.translation() = DrawPoint(&random);
      const Vector3d p = DrawNear(cage, &random);
      const VectorXd weights = CalcMeanValueCoordinates(cage, p);
      EXPECT_LT((Combine(weights, Transform(cage, map)) - map * p).norm(), 1e-13 * weights.lpNorm<1>());
    }
  }
}

TEST(MeanValueCoordinates, AreOneAtTheirOwnVertexAndZeroAtOthers) {
  for (const TriangleMesh& cage : MakeCages()) {
    for (size_t j = 0; j < cage.vertices.size(); ++j) {
      const VectorXd weights = CalcMeanValueCoordinates(cage, cage.vertices[j]);
      EXPECT_EQ(weights, VectorXd::Unit(weights.size(), static_cast<int>(j)));
    }
  }
}

TEST(MeanValueCoordinates, AreBarycentricOnFacesAndEdges) {
  std::mt19937 random(4);
  for (const TriangleMesh& cage : MakeCages()) {
    for (const Vector3i& t : cage.triangles) {
      for (int on_edge = 0; on_edge < 2; ++on_edge) {
        Vector3d s = (DrawPoint(&random) + Vector3d::Constant(1.1));
        if (on_edge == 1) s[static_cast<int>(random() % 3)] = 0;
        s /= s.sum();
        VectorXd expected = VectorXd::Zero(static_cast<int>(cage.vertices.size()));
        Vector3d p = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
          expected[t[k]] = s[k];
          p += s[k] * cage.vertices[t[k]];
        }
        EXPECT_LT(MaxDifference(CalcMeanValueCoordinates(cage, p), expected), 1e-14);
      }
    }
  }
}

// Walks away from points inside faces, on edges and on vertices, to both sides, through the snap's radius of
// 1e-12 diagonals: the weights differ from those on the surface by no more than a slope times the distance.
// At vertices and edges the slope is steeper but finite.
TEST(MeanValueCoordinates, AreContinuousAcrossTheSnap) {
  std::mt19937 random(5);
  for (const TriangleMesh& cage : MakeCages()) {
    for (const Vector3i& t : cage.triangles) {
      for (int zeros = 0; zeros < 3; ++zeros) {
        Vector3d s = (DrawPoint(&random) + Vector3d::Constant(1.5));
        for (int k = 0; k < zeros; ++k) s[k] = 0;
        s /= s.sum();
        const Vector3d p = s[0] * cage.vertices[t[0]] + s[1] * cage.vertices[t[1]] + s[2] * cage.vertices[t[2]];
        const VectorXd on_surface = CalcMeanValueCoordinates(cage, p);
        const Vector3d direction = DrawPoint(&random).normalized();
        for (double h = 1e-4; h > 1e-14; h /= 3) {
          EXPECT_LT(MaxDifference(CalcMeanValueCoordinates(cage, p + h * direction), on_surface), 50 * h + 1e-14)
              << "distance " << h << ", " << zeros << " zeros";
        }
      }
    }
  }
}

// Inside the L, points may lie in the plane of a face without being near it; the face is then seen edge-on.
TEST(MeanValueCoordinates, AreContinuousWhereAFaceIsSeenEdgeOn) {
  const TriangleMesh cage = MakeConcaveCage();
  const Vector3d p(1, 0.4, 0.3);
  const VectorXd in_plane = CalcMeanValueCoordinates(cage, p);
  ASSERT_TRUE(in_plane.allFinite());
  for (double h = 1e-3; h > 1e-16; h /= 3) {
    for (const double side : {-1.0, 1.0}) {
      const VectorXd beside = CalcMeanValueCoordinates(cage, p + Vector3d(side * h, 0, 0));
      // Below 1e-8 of the distance the face is left out, which costs as much as its rounding there.
      EXPECT_LT(MaxDifference(beside, in_plane), 2 * h + 2e-8) << side * h;
    }
  }
}

TEST(MeanValueCoordinates, AreNotNegativeInsideConvexCages) {
  std::mt19937 random(6);
  for (const TriangleMesh& cage : {MakeTetrahedron(), MakeBox()}) {
    for (int i = 0; i < 1000; ++i) {
      EXPECT_GE(CalcMeanValueCoordinates(cage, DrawInsideConvex(cage, &random)).minCoeff(), -1e-15);
    }
  }
}

TEST(MeanValueCoordinates, DoNotDependOnFrameAndUnit) {
  std::mt19937 random(7);
  for (const TriangleMesh& cage : MakeCages()) {
    for (const double scale : {1e-6, 1.0, 1e6}) {
      Eigen::Affine3d map;
      map.linear() = scale * Eigen::Quaterniond::FromTwoVectors(DrawPoint(&random), DrawPoint(&random)).matrix();
      map.translation() = scale * DrawPoint(&random);
      const TriangleMesh moved = Transform(cage, map);
      for (int i = 0; i < 50; ++i) {
        const Vector3d p = DrawNear(cage, &random);
        const VectorXd weights = CalcMeanValueCoordinates(cage, p);
        EXPECT_LT(MaxDifference(CalcMeanValueCoordinates(moved, map * p), weights), 1e-11 * weights.lpNorm<1>());
      }
    }
  }
}

// Gauss-Legendre nodes and weights on 0..1, by Newton's method on the Legendre polynomial.
std::vector<std::pair<double, double>> MakeGaussRule(int n) {
  std::vector<std::pair<double, double>> rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 0;
    for (int step = 0; step < 50; ++step) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= n; ++k) p0 = std::exchange(p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k);
      slope = n * (x * p1 - p0) / (x * x - 1);
      x -= p1 / slope;
    }
    rule.emplace_back((1 + x) / 2, 1 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

// The definition, with the sphere of directions mapped to the surface, dS = (p - x) . n / |p - x|^3 dA, and
// integrated triangle by triangle.
VectorXd IntegrateOverSurface(const TriangleMesh& cage, const Vector3d& x) {
  static const std::vector<std::pair<double, double>> rule = MakeGaussRule(60);
  VectorXd weights = VectorXd::Zero(static_cast<int>(cage.vertices.size()));
  for (const Vector3i& t : cage.triangles) {
    const Vector3d a = cage.vertices[t[0]], b = cage.vertices[t[1]], c = cage.vertices[t[2]];
    const Vector3d area = (b - a).cross(c - a);  // dA n = area (1 - r) dr ds below
    for (const auto& [r, weight_r] : rule) {
      for (const auto& [s, weight_s] : rule) {
        const Vector3d barycentric(r, (1 - r) * (1 - s), (1 - r) * s);
        const Vector3d offset = barycentric[0] * a + barycentric[1] * b + barycentric[2] * c - x;
        const double value = weight_r * weight_s * (1 - r) * offset.dot(area) / std::pow(offset.norm(), 4);
        for (int k = 0; k < 3; ++k) weights[t[k]] += value * barycentric[k];
      }
    }
  }
  return weights / weights.sum();
}

// The definition as it stands: rays in directions spread evenly over the sphere (a Fibonacci spiral), each
// intersected with every triangle by Cramer's rule.
VectorXd IntegrateOverDirections(const TriangleMesh& cage, const Vector3d& x, int num_rays) {
  VectorXd weights = VectorXd::Zero(static_cast<int>(cage.vertices.size()));
  for (int i = 0; i < num_rays; ++i) {
    const double z = 1 - (2 * i + 1.0) / num_rays;
    const double turn = M_PI * (3 - std::sqrt(5.0)) * i;
    const Vector3d ray(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
    for (const Vector3i& t : cage.triangles) {
      Matrix3d corners;
      for (int k = 0; k < 3; ++k) corners.col(k) = cage.vertices[t[k]] - x;
      // corners * s = ray: the ray leaves through the triangle's plane at distance 1 / sum(s).
      const Vector3d s = corners.inverse() * ray;
      if (!(s.minCoeff() >= 0)) continue;
      const double sign = corners.determinant() > 0 ? 1 : -1;
      for (int k = 0; k < 3; ++k) weights[t[k]] += sign * s[k];
    }
  }
  return weights / weights.sum();
}

TEST(MeanValueCoordinates, AgreeWithTheDefinitionIntegratedOverTheSurface) {
  const std::vector<std::pair<TriangleMesh, Vector3d>> cases = {
      {MakeTetrahedron(), {0.35, 0.3, 0.25}},
      {MakeBox(), {0.4, 0.6, 0.5}},
      {MakeBox(), {2.0, -0.5, 0.5}},  // outside
      {MakeConcaveCage(), {0.5, 0.6, 0.4}},
      {MakeConcaveCage(), {1.6, 0.4, 0.5}},  // part of the L hides behind its corner
      {MakeConcaveCage(), {0.6, 1.6, 0.3}},
      {MakeConcaveCage(), {1.4, 1.5, 0.5}},  // in the L's arms, outside
  };
  for (const auto& [cage, p] : cases) {
    const VectorXd expected = IntegrateOverSurface(cage, p);
    EXPECT_LT(MaxDifference(CalcMeanValueCoordinates(cage, p), expected), 1e-9 * expected.lpNorm<1>()) << p.transpose();
  }
}

TEST(MeanValueCoordinates, AgreeWithTheDefinitionIntegratedOverDirections) {
  const std::vector<std::pair<TriangleMesh, Vector3d>> cases = {
      {MakeTetrahedron(), {0.35, 0.3, 0.25}}, {MakeBox(), {0.4, 0.6, 0.5}}, {MakeConcaveCage(), {1.6, 0.4, 0.5}}};
  for (const auto& [cage, p] : cases) {
    // The error of an even rule with n points on an integrand with kinks falls like 1 / n; jumps (the L's
    // inner corner) leave n^(-3/4).
    EXPECT_LT(MaxDifference(CalcMeanValueCoordinates(cage, p), IntegrateOverDirections(cage, p, 100000)), 1e-3);
  }
}

TEST(MeanValueCoordinates, RejectOpenFlippedAndInsideOutCages) {
  const auto error_of = [](const TriangleMesh& cage) -> std::string {
    try {
      CalcMeanValueWeights(cage, MakeTetrahedron());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of(MakeBox()), "");
  TriangleMesh cage = MakeBox();
  cage.triangles.pop_back();
  EXPECT_THAT(error_of(cage), HasSubstr("3 open edges"));
  cage = MakeBox();
  std::swap(cage.triangles[0][0], cage.triangles[0][1]);
  EXPECT_THAT(error_of(cage), HasSubstr("opposite orientation"));
  cage = MakeBox();
  for (Vector3i& t : cage.triangles) std::swap(t[0], t[1]);
  EXPECT_THAT(error_of(cage), HasSubstr("face inwards"));
  cage = MakeBox();
  cage.vertices.emplace_back(0, 0, 0);
  EXPECT_THAT(error_of(cage), HasSubstr("1 vertex without a triangle"));
}

TEST(MeanValueCoordinates, WeightsOfAMeshAreThoseOfItsVertices) {
  const TriangleMesh cage = MakeBox();
  const TriangleMesh mesh = MakeTetrahedron();
  const MatrixXd weights = CalcMeanValueWeights(cage, mesh);
  ASSERT_EQ(weights.rows(), 4);
  ASSERT_EQ(weights.cols(), 8);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(VectorXd(weights.row(i)), CalcMeanValueCoordinates(cage, mesh.vertices[static_cast<size_t>(i)]));
  }
}

}  // namespace mean_value_coordinates_test
}  // namespace knap
