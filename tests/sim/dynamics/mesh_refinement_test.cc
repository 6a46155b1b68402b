// Contact does not depend on how finely a mesh is cut.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace {

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
    const BallSample plane = Touch(0, material, depth, Vector3d(0.1, -0.05, 0.02), Vector3d(1, 2, 3));
    EXPECT_GT(plane.f.z(), 0.02);
    for (const int cells : {1, 10, 37}) {
      const BallSample mesh = Touch(cells, material, depth, Vector3d(0.1, -0.05, 0.02), Vector3d(1, 2, 3));
      EXPECT_LT((mesh.f - plane.f).norm(), 1e-9 * plane.f.norm()) << cells;
    }
  }
}

}  // namespace
}  // namespace knap
