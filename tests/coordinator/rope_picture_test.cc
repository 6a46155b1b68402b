// Pictures of ropes: the eye stands upright, faces hide what lies behind them, and a whole picture has all its panels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "coordinator/cli/loaded_run.h"
#include "coordinator/cli/problem_from_scene.h"
#include "coordinator/report/picture.h"
#include "coordinator/report/rope_view.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

TEST(RopeView, TheEyeStandsUprightWhereverGravityPoints) {
  for (const Vector3d& g : {Vector3d(0, 0, -9.81), Vector3d(5, -3, 1), Vector3d(-9.81, 0, 0), Vector3d(9.81, 0, 0)}) {
    const Matrix3d eye = CalcEye(g);
    EXPECT_NEAR((eye * eye.transpose() - Matrix3d::Identity()).norm(), 0.0, 1e-14);
    EXPECT_NEAR(eye.determinant(), 1.0, 1e-14);
    const Vector3d down = eye * g.normalized();
    EXPECT_NEAR(down.x(), 0.0, 1e-14);
    EXPECT_LT(down.y(), -0.95);
  }
}

// A cube 20 mm wide with one link before and one behind it: of each three faces are seen (a link's long ones in
// pieces), and the cube's come between those of the links.
TEST(RopeView, FacesComeFromTheFarthestToTheNearest) {
  TriangleMesh cube;
  for (const double z : {-0.01, 0.01}) {
    for (const double y : {-0.01, 0.01}) {
      for (const double x : {-0.01, 0.01}) cube.vertices.emplace_back(x, y, z);
    }
  }
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  Rope rope;
  rope.pitch = 0.01;
  rope.gap = 0.001;
  rope.thickness = 0.004;
  const Matrix3d eye = CalcEye(Vector3d(0, 0, -9.81));
  const Vector3d to_eye = eye.row(2);
  const std::vector<ShownFace> faces =
      CalcShownFaces(cube, {{Matrix3d::Identity(), 0.04 * to_eye}, {Matrix3d::Identity(), -0.04 * to_eye}}, rope, eye);
  ASSERT_EQ(faces.size(), 2u * (2u * 4u + 1u) + 6u);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    EXPECT_EQ(faces[i].of_rope, i < 9 || i >= 15) << i;
    if (i > 0) {
      EXPECT_GE(faces[i].depth, faces[i - 1].depth);
    }
  }
}

TEST(RopePicture, HasThreeStartsAndTheirEnds) {
  const LoadedScenario loaded =
      LoadValidScenario(KNAP_SOURCE_DIR "/configs/winding.yaml",
                        std::vector<std::string>{"rollout.horizon=0.02 s", "loss.task[0].until=0.02 s",
                                                 "loss.distillation[0].until=0.02 s"});
  RolloutModel model(loaded.files);
  const Problem problem = MakeProblem(loaded.parsed.scene);
  PictureFigures figures;
  figures.learned = problem.parameters.upper;
  figures.test_initial.variations = figures.test_learned.variations = 200;
  figures.test_learned.success_rate = 0.98;
  const std::optional<std::string> svg = DrawPicture(model, problem.variations, figures);
  ASSERT_TRUE(svg);
  EXPECT_THAT(*svg, HasSubstr("Initial: 0.0% of 200 held after 0.02 s"));
  EXPECT_THAT(*svg, HasSubstr("Learned: 98.0% of 200 held after 0.02 s"));
  EXPECT_THAT(*svg, HasSubstr("id=\"panel8\""));
  EXPECT_LT(svg->size(), 1'000'000u);
}

}  // namespace
}  // namespace knap
