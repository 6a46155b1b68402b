#include "coordinator/report/silhouette.h"

#include <gtest/gtest.h>

#include <cmath>

#include "coordinator/cli/loaded_run.h"
#include "sim/rollout/rollout.h"

namespace knap {
namespace {

double CalcArea(const Outline& outline) {
  double area = 0.0;
  for (const auto& loop : outline) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Eigen::Vector2d& a = loop[i];
      const Eigen::Vector2d& b = loop[(i + 1) % loop.size()];
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
  }
  return area;
}

TEST(SilhouetteTest, TetrahedronCastsItsShadow) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Outline outline = CalcSilhouette(mesh, 0, 1);
  ASSERT_EQ(outline.size(), 1u);
  EXPECT_EQ(outline[0].size(), 3u);
  EXPECT_NEAR(CalcArea(outline), 1.0, 1e-12);
  EXPECT_NEAR(CalcArea(CalcSilhouette(mesh, 0, 2)), 1.0, 1e-12);  // corners (0,0), (2,0), (0.3,1)
}

TEST(SilhouetteTest, PusherIsOneLoopOfItsWidthTimesItsDepth) {
  RolloutModel model(LoadValidScenario(KNAP_SOURCE_DIR "/configs/pushing.yaml", {}).files);
  const TriangleMesh& bar = model.design()->Find("pusher")->initial_mesh();
  const Outline outline = CalcSilhouette(bar, 0, 1);
  ASSERT_EQ(outline.size(), 1u);
  const Eigen::Vector3d size = CalcBoundingBox(bar).sizes();
  EXPECT_NEAR(CalcArea(outline), size.x() * size.y(), 1e-9);
}

}  // namespace
}  // namespace knap
