// Contact does not depend on how finely a mesh is cut.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace mesh_refinement_test {

using Eigen::Vector3d;
using test::BallSample;
using test::BallScene;

// What a ball in one state feels from a flat bar's face (normal +y) of cells × cells; 0: from a half-space.
BallSample Touch(int cells, const ContactMaterial& material, double depth, const Vector3d& v, const Vector3d& w) {
  BallScene scene;
  const double c = 0.03;
  std::shared_ptr<const ContactMesh> mesh;
  if (cells > 0) mesh = std::make_shared<ContactMesh>(test::MakeBar(0.015, 0.02, c, cells, cells));
  scene.AddGround(cells > 0 ? test::MakeFloorPose(c) : Pose{});
  scene.AddBall();
  scene.Touch(scene.ground, material, mesh);
  // Off the diagonal of the coarse face, so that the patch lies in one triangle there.
  scene.Start(Vector3d(0.00413, 0.00371, scene.radius - depth), v, w);
  return RunBall(scene, test::MakeOptions(1e-3, 0.0, 1)).front();
}

TEST(MeshRefinement, ElasticForceIsTheSame) {
  const ContactMaterial material{1.3e8, 0.0, 0.0, 0.0, 1e-3};
  for (const double depth : {8e-5, 4e-4}) {
    const BallSample plane = Touch(1, material, depth, Vector3d(0.1, -0.05, 0.02), Vector3d(1, 2, 3));
    EXPECT_GT(plane.f.z(), 0.02);
    for (const int cells : {2, 10, 37}) {
      const BallSample mesh = Touch(cells, material, depth, Vector3d(0.1, -0.05, 0.02), Vector3d(1, 2, 3));
      EXPECT_LT((mesh.f - plane.f).norm(), 1e-9 * plane.f.norm()) << cells;
    }
  }
}

struct Motion {
  const char* name;
  Vector3d v;
  Vector3d w;
};

class MotionTest : public testing::TestWithParam<Motion> {};

// With the material of configs/pushing.yaml, at rest depth.
TEST_P(MotionTest, WrenchIsTheSame) {
  const ContactMaterial material{1.3e8, 2.0, 0.4, 0.03, 1e-3};
  const BallSample plane = Touch(1, material, 1e-4, GetParam().v, GetParam().w);
  for (const int cells : {1, 10, 30}) {
    const BallSample mesh = Touch(cells, material, 1e-4, GetParam().v, GetParam().w);
    EXPECT_LT((mesh.f - plane.f).norm(), 1e-9 * plane.f.norm())
        << GetParam().name << ", " << cells << " cells: " << mesh.f.transpose() << " against " << plane.f.transpose();
    EXPECT_LT((mesh.m - plane.m).norm(), 1e-9 * 0.01 * plane.f.norm())
        << GetParam().name << ", " << cells << " cells: " << mesh.m.transpose() << " against " << plane.m.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, MotionTest,
                         testing::Values(Motion{"sliding", {0.1, 0.05, 0}, {0, 0, 0}},
                                         Motion{"rolling", {0.1, 0, 0}, {0, 10, 0}},
                                         Motion{"approaching", {0, 0, -0.1}, {0, 0, 0}},
                                         Motion{"separating", {0, 0, 0.1}, {0, 0, 0}}),
                         [](const auto& motion) { return std::string(motion.param.name); });

// A frictional, undamped bounce straight onto a face: nothing slips, so nothing is lost.
TEST(MeshRefinement, AStraightBounceLosesNoEnergy) {
  for (const int cells : {1, 10, 30}) {
    BallScene scene;
    scene.tree.gravity.setZero();
    const double c = 0.03;
    scene.AddGround(test::MakeFloorPose(c));
    scene.AddBall();
    scene.Touch(scene.ground, {1.3e8, 0.0, 0.4, 0.0, 1e-3},
                std::make_shared<ContactMesh>(test::MakeBar(0.015, 0.02, c, cells, cells)));
    scene.Start(Vector3d(0.00413, 0.00371, scene.radius + 1e-5), Vector3d(0, 0, -0.2), Vector3d::Zero());
    const auto samples = RunBall(scene, test::MakeOptions(1e-5, 0.01, 2));
    ASSERT_EQ(samples.back().f.norm(), 0.0);
    // The integrator's loss at 600 steps a contact is below 1e-3.
    EXPECT_NEAR(samples.back().v.z() / 0.2, 1.0, 1e-3) << cells;
    EXPECT_LT(samples.back().v.head<2>().norm(), 1e-3 * 0.2) << cells;
  }
}

}  // namespace mesh_refinement_test
}  // namespace knap
