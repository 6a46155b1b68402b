#include "sim/morphology/cage_design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "sim/geometry/mesh_io.h"
#include "sim/morphology/mean_value_coordinates.h"

namespace knap {
namespace cage_design_test {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

TriangleMesh ReadConfigMesh(const std::string& name) {
  const std::string path = std::string(KNAP_CONFIGS) + "/meshes/" + name;
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return ReadMesh(path, std::string(std::istreambuf_iterator<char>(file), {}), 0.001);
}

// The pusher's parameters [m]: width of the middle, of the left and the right wing, depths of the tips, bows.
const VectorXd kInitial = (VectorXd(7) << 0.044, 0.030, 0.030, 0, 0, 0, 0).finished();
const VectorXd kLower = (VectorXd(7) << 0.020, 0.010, 0.010, -0.015, -0.015, -0.008, -0.008).finished();
const VectorXd kUpper = (VectorXd(7) << 0.056, 0.032, 0.032, 0.030, 0.030, 0.008, 0.008).finished();

std::vector<VertexMove> MakePusherMoves() {
  std::vector<VertexMove> moves;
  const auto move_station = [&moves](int parameter, int station, const Vector3d& direction) {
    for (int k = 0; k < 4; ++k) moves.push_back({parameter, 4 * station + k, direction});
  };
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  for (int s = 0; s < 3; ++s) {
    move_station(0, s, -x / 2);
    move_station(0, 5 - s, x / 2);
  }
  move_station(1, 0, -x);
  move_station(1, 1, -x / 2);
  move_station(2, 5, x);
  move_station(2, 4, x / 2);
  move_station(3, 0, y);
  move_station(3, 1, y / 2);
  move_station(4, 5, y);
  move_station(4, 4, y / 2);
  move_station(5, 1, y);
  move_station(6, 4, y);
  return moves;
}

CageDesign MakePusher() {
  return CageDesign(ReadConfigMesh("pusher.obj"), ReadConfigMesh("pusher_cage.obj"), kInitial, MakePusherMoves());
}

VectorXd DrawTheta(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  VectorXd theta(7);
  for (int j = 0; j < 7; ++j) theta[j] = kLower[j] + uniform(*random) * (kUpper[j] - kLower[j]);
  return theta;
}

TEST(CageDesign, StartsFromTheGivenMesh) {
  const CageDesign pusher = MakePusher();
  EXPECT_EQ(pusher.num_parameters(), 7);
  const TriangleMesh mesh = ReadConfigMesh("pusher.obj");
  EXPECT_EQ(pusher.CalcMesh(kInitial).vertices, mesh.vertices);
  EXPECT_EQ(pusher.CalcMesh(kInitial).triangles, mesh.triangles);
}

TEST(CageDesign, MatchesTheWeightsTimesTheDeformedCage) {
  const CageDesign pusher = MakePusher();
  const MatrixXd weights = CalcMeanValueWeights(pusher.initial_cage(), pusher.initial_mesh());
  std::mt19937 random(1);
  for (int i = 0; i < 10; ++i) {
    const VectorXd theta = DrawTheta(&random);
    const Matrix3Xd vertices = pusher.CalcVertices(theta);
    const TriangleMesh cage = pusher.CalcCage(theta);
    Matrix3Xd cage_vertices(3, cage.vertices.size());
    for (size_t j = 0; j < cage.vertices.size(); ++j) cage_vertices.col(static_cast<int>(j)) = cage.vertices[j];
    EXPECT_LT((cage_vertices * weights.transpose() - vertices).cwiseAbs().maxCoeff(), 1e-15);
    const TriangleMesh mesh = pusher.CalcMesh(theta);
    for (int v = 0; v < pusher.num_vertices(); ++v) {
      ASSERT_LT((mesh.vertices[static_cast<size_t>(v)] - vertices.col(v)).norm(), 1e-16);
    }
  }
}

// The map is affine, so central differences with a step of a millimetre are exact up to rounding.
TEST(CageDesign, DerivativeAgreesWithDifferences) {
  const CageDesign pusher = MakePusher();
  std::mt19937 random(2);
  const double h = 1e-3;
  for (int i = 0; i < 5; ++i) {
    const VectorXd theta = DrawTheta(&random);
    for (int j = 0; j < 7; ++j) {
      const Matrix3Xd plus = pusher.CalcVertices(theta + h * VectorXd::Unit(7, j));
      const Matrix3Xd minus = pusher.CalcVertices(theta - h * VectorXd::Unit(7, j));
      const Matrix3Xd difference = (plus - minus) / (2 * h);
      double largest = 0;
      for (int v = 0; v < pusher.num_vertices(); ++v) {
        const Vector3d derivative = pusher.dm_dtheta().col(j).segment<3>(3 * v);
        ASSERT_LT((difference.col(v) - derivative).norm(), 1e-13);
        largest = std::max(largest, derivative.norm());
      }
      EXPECT_GT(largest, 0.4) << "parameter " << j << " moves nothing";
    }
  }
}

TEST(CageDesign, PullBackIsTheTranspose) {
  const CageDesign pusher = MakePusher();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Matrix3Xd bar =
      Matrix3Xd::NullaryExpr(3, pusher.num_vertices(), [&](Eigen::Index, Eigen::Index) { return normal(random); });
  const VectorXd delta = VectorXd::NullaryExpr(7, [&](Eigen::Index) { return normal(random); });
  const Matrix3Xd moved = pusher.CalcVertices(kInitial + delta) - pusher.CalcVertices(kInitial);
  const double expected = bar.cwiseProduct(moved).sum();
  EXPECT_NEAR(pusher.PullBack(bar).dot(delta), expected, 1e-12 * bar.norm() * moved.norm());
}

TEST(CageDesign, TheVolumesGradientThroughPullBack) {
  const CageDesign pusher = MakePusher();
  std::mt19937 random(4);
  for (int i = 0; i < 5; ++i) {
    const VectorXd theta = DrawTheta(&random);
    const TriangleMesh mesh = pusher.CalcMesh(theta);
    Matrix3Xd bar = Matrix3Xd::Zero(3, pusher.num_vertices());
    for (const Eigen::Vector3i& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        bar.col(t[k]) += mesh.vertices[t[(k + 1) % 3]].cross(mesh.vertices[t[(k + 2) % 3]]) / 6;
      }
    }
    const VectorXd gradient = pusher.PullBack(bar);
    const double h = 1e-4;  // the volume is cubic in theta; its third derivatives are below 1
    for (int j = 0; j < 7; ++j) {
      const double difference = (CalcSignedVolume(pusher.CalcMesh(theta + h * VectorXd::Unit(7, j))) -
                                 CalcSignedVolume(pusher.CalcMesh(theta - h * VectorXd::Unit(7, j)))) /
                                (2 * h);
      EXPECT_NEAR(gradient[j], difference, 1e-8 * gradient.norm());
    }
  }
}

// Everywhere within the bounds the pusher stays a printable body. The plan view of its front face runs through
// the cage's stations; between them no part folds back.
TEST(CageDesign, ThePusherStaysABodyWithinItsBounds) {
  const CageDesign pusher = MakePusher();
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    VectorXd theta = DrawTheta(&random);
    if (i < 128) {  // the corners of the bounds
      for (int j = 0; j < 7; ++j) theta[j] = ((i >> j) & 1) != 0 ? kUpper[j] : kLower[j];
    }
    const TriangleMesh mesh = pusher.CalcMesh(theta);
    const MeshDefects defects = FindDefects(mesh);
    ASSERT_TRUE(defects.empty()) << defects.Describe() << " at " << theta.transpose();
    EXPECT_GT(CalcSignedVolume(mesh), 0.3 * CalcSignedVolume(pusher.initial_mesh()));
    // Width and tips follow the parameters, to the cage's margin.
    const Eigen::AlignedBox3d box = CalcBoundingBox(mesh);
    EXPECT_NEAR(box.sizes().x(), theta.head(3).sum(), 2e-3);
    EXPECT_NEAR(box.sizes().z(), 0.020, 1e-9);
    // A column of vertices across the bar keeps its place among its neighbours: no fold.
    const std::vector<Vector3d>& initial = pusher.initial_mesh().vertices;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const auto from = static_cast<size_t>(t[k]), to = static_cast<size_t>(t[(k + 1) % 3]);
        const double before = initial[to].x() - initial[from].x();
        if (std::abs(before) < 1e-6) continue;  // within one column
        ASSERT_GT((mesh.vertices[to].x() - mesh.vertices[from].x()) * before, 0);
      }
    }
  }
}

// Station by station, the middle of the front face moves with its cage station, to 2.5 mm where the moves of
// neighbouring stations differ by up to 40 mm (the face lies 1 mm inside the cage, which rounds the kinks).
TEST(CageDesign, ThePushersFaceFollowsTheStations) {
  const CageDesign pusher = MakePusher();
  std::mt19937 random(6);
  const std::array<double, 6> stations = {-0.052, -0.037, -0.022, 0.022, 0.037, 0.052};
  for (int i = 0; i < 50; ++i) {
    const VectorXd theta = DrawTheta(&random);
    const Matrix3Xd vertices = pusher.CalcVertices(theta);
    const TriangleMesh cage = pusher.CalcCage(theta);
    for (size_t s = 0; s < stations.size(); ++s) {
      const Vector3d moved = cage.vertices[4 * s + 1] - pusher.initial_cage().vertices[4 * s + 1];
      int found = 0;
      for (int v = 0; v < pusher.num_vertices(); ++v) {
        const Vector3d& initial = pusher.initial_mesh().vertices[static_cast<size_t>(v)];
        if ((initial - Vector3d(stations[s], 0, 0.010)).norm() > 1e-9) continue;
        ++found;
        EXPECT_LT((vertices.col(v) - initial - moved).norm(), 2.5e-3) << "station " << s;
      }
      EXPECT_EQ(found, 1);
    }
  }
}

TEST(CageDesign, RejectsBadInput) {
  const TriangleMesh mesh = ReadConfigMesh("pusher.obj");
  const TriangleMesh cage = ReadConfigMesh("pusher_cage.obj");
  const auto error_of = [](const TriangleMesh& m, const TriangleMesh& c, const VectorXd& theta,
                           const std::vector<VertexMove>& moves) -> std::string {
    try {
      CageDesign(m, c, theta, moves);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const Vector3d x = Vector3d::UnitX();
  EXPECT_EQ(error_of(mesh, cage, kInitial, {{0, 0, x}}), "");
  EXPECT_THAT(error_of(mesh, cage, kInitial, {{7, 0, x}}), HasSubstr("parameter 7; there are 7"));
  EXPECT_THAT(error_of(mesh, cage, kInitial, {{-1, 0, x}}), HasSubstr("parameter -1"));
  EXPECT_THAT(error_of(mesh, cage, kInitial, {{0, 24, x}}), HasSubstr("cage vertex 24; there are 24"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of(mesh, cage, kInitial, {{0, 0, nan * x}}), HasSubstr("not finite"));
  EXPECT_THAT(error_of(mesh, cage, nan * kInitial, {}), HasSubstr("initial parameter is not finite"));
  TriangleMesh open = mesh;
  open.triangles.pop_back();
  EXPECT_THAT(error_of(open, cage, kInitial, {}), HasSubstr("mesh must be closed"));
  open = cage;
  open.triangles.pop_back();
  EXPECT_THAT(error_of(mesh, open, kInitial, {}), HasSubstr("cage must be closed"));
}

}  // namespace cage_design_test
}  // namespace knap
