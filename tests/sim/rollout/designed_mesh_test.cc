// Designed meshes from files to weights and losses: each scene of tests/data/mesh with the value that is right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/check_model.h"
#include "sim/rollout/design_corners.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace designed_mesh_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

LoadedScenario Load(const std::string& scene, const std::vector<std::string>& overrides = {}) {
  LoadedScenario scenario = LoadScenario(std::string(KNAP_TEST_DATA) + "/mesh/" + scene, overrides);
  CheckModel(scenario);
  return scenario;
}

// What is wrong with the scene, "" when it is valid.
std::string FindErrors(const std::string& scene, const std::vector<std::string>& overrides = {}) {
  return Load(scene, overrides).parsed.FormatErrors();
}

RolloutInput MakeInput(const RolloutModel& model) {
  RolloutInput input;
  input.theta = model.initial_theta();
  return input;
}

// Where a body's origin is at the end.
Eigen::Vector3d RecordEnd(RolloutModel* model, const std::string& body) {
  return model->Record(MakeInput(*model), 0.0).recording.Find(body).X_WB.back().p;
}

// [g], of the tool in weighed.yaml with another mesh.
double Weigh(const std::string& mesh) {
  const LoadedScenario scenario = Load("weighed.yaml", {"design.bodies.tool.mesh=" + mesh});
  EXPECT_EQ(scenario.parsed.FormatErrors(), "");
  RolloutModel model(scenario.files);
  return -1000.0 * RecordEnd(&model, "tool").z() * 100.0 / 10.0;
}

// After 1 s the motion has decayed by e^-50 or more.
TEST(DesignedMesh, WeighsWhatItsPartsWeigh) {
  EXPECT_NEAR(Weigh("box.obj"), 1.920, 1e-6);
  EXPECT_NEAR(Weigh("two_parts.obj"), 2.560, 1e-6);
  EXPECT_NEAR(Weigh("hollow.obj"), 1.760, 1e-6);
}

TEST(DesignedMesh, PartsThatBoundNoBodyAreRefusedByName) {
  EXPECT_THAT(FindErrors("weighed.yaml", {"design.bodies.tool.mesh=overlapping_parts.obj"}),
              AllOf(HasSubstr("part 1 of 2"), HasSubstr("meets part 2 of 2")));
  EXPECT_THAT(FindErrors("weighed.yaml", {"design.bodies.tool.mesh=inward_part.obj"}),
              HasSubstr("part 2 of 2 (12 triangles, from (10, -4, 0) to (18, 4, 10) mm) faces inwards"));
  EXPECT_THAT(FindErrors("weighed.yaml", {"design.bodies.tool.mesh=filled.obj"}),
              HasSubstr("faces outwards and lies inside part 1 of 2"));
}

TEST(DesignedMesh, AConcaveFaceWithCornersInLineIsWhatItsTrianglesAre) {
  const LoadedScenario polygons = Load("notch.yaml");
  const LoadedScenario triangles = Load("notch.yaml", {"design.bodies.bar.mesh=notched_bar_triangles.obj"});
  ASSERT_EQ(polygons.parsed.FormatErrors() + triangles.parsed.FormatErrors(), "");
  RolloutModel of_polygons(polygons.files);
  RolloutModel of_triangles(triangles.files);
  const TriangleMesh& mesh = of_polygons.design()->Find("bar")->initial_mesh();
  double area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  EXPECT_NEAR(1e6 * area, 2 * 552 + 158 * 8, 1e-9);  // two caps, and the outline's length times the height
  EXPECT_NEAR(1e9 * CalcSignedVolume(mesh), 552 * 8, 1e-9);

  // A triangle over the notch would hold the ball above 8 mm.
  const Eigen::Vector3d end = RecordEnd(&of_polygons, "ball");
  EXPECT_EQ(end, RecordEnd(&of_triangles, "ball"));
  EXPECT_NEAR(end.z(), 0.020 - 0.5 * 9.81 * 0.1 * 0.1,
              9.81 * 0.1 * 0.002);  // of the first order in the step
}

TEST(DesignedMesh, AMeshOutsideItsCageIsRefusedWithBothSizes) {
  EXPECT_THAT(
      FindErrors("weighed.yaml", {"design.bodies.tool.cage=cage_in_metres.obj"}),
      AllOf(HasSubstr("the mesh lies outside its cage: 16 of its 16 vertices"), HasSubstr("the mesh is 36 x 8 x 10 mm"),
            HasSubstr("the cage 0.04 x 0.012 x 0.014 mm"), HasSubstr("same unit?")));
  // On the cage is inside, beside it is not.
  EXPECT_EQ(FindErrors("weighed.yaml", {"design.bodies.tool.mesh=box.obj", "design.bodies.tool.cage=box.obj"}), "");
  EXPECT_THAT(FindErrors("weighed.yaml", {"design.bodies.tool.cage=box.obj"}), HasSubstr("8 of its 16 vertices"));
}

TEST(DesignedMesh, ADesignThatTurnsTheToolInsideOutIsAnOutcome) {
  const LoadedScenario scenario = Load("turned_over.yaml");
  ASSERT_EQ(scenario.parsed.FormatErrors(), "");
  RolloutModel model(scenario.files);
  const RolloutInput good = MakeInput(model);
  RolloutInput bad = good;
  bad.theta(0) = -0.030;
  const RolloutOutput out = model.Run(bad, {});
  EXPECT_THAT(out.failure, AllOf(HasSubstr("'tool'"), HasSubstr("inside out")));
  EXPECT_FALSE(out.certificate.finite);
  EXPECT_FALSE(out.certificate.converged);
  EXPECT_TRUE(std::isnan(out.loss));
  ASSERT_EQ(out.gradient.size(), 1);  // whoever asked for one counts its values
  EXPECT_TRUE(std::isnan(out.gradient(0)));
  EXPECT_THROW(model.Record(bad, 0.0), std::invalid_argument);
  EXPECT_THROW(WriteStl(model.design()->Find("tool")->CalcMesh(bad.theta)), std::runtime_error);

  RolloutInput against_bad = good;
  against_bad.theta_reference = bad.theta;
  EXPECT_FALSE(model.Run(against_bad, {}).certificate.converged);
  const RolloutOutput fine = model.Run(good, {});
  EXPECT_EQ(fine.failure, "");
  EXPECT_TRUE(fine.certificate.converged);
}

TEST(DesignCorners, CountsThoseThatFoldTheMesh) {
  const LoadedScenario scenario = Load("turned_over.yaml");
  const RolloutModel model(scenario.files);
  const FoldedCorners corners = FindFoldedCorners(*model.design(), *model.scene().design);
  EXPECT_EQ(corners.tried, 4);  // each bound alone, and as a corner
  EXPECT_EQ(corners.folded, 2);
  EXPECT_EQ(corners.example(0), -0.030);
  EXPECT_THAT(corners.fault, HasSubstr("inside out"));
  // Nearer to the initial design there is none, and one percent farther there is.
  const auto is_folded = [&](double percent) {
    const Eigen::VectorXd initial = model.design()->initial_theta();
    return !model.design()->FindFault(initial + percent / 100.0 * (corners.example - initial)).empty();
  };
  EXPECT_GT(corners.safe_percent, 0);
  EXPECT_LT(corners.safe_percent, 100);
  EXPECT_FALSE(is_folded(corners.safe_percent));
  EXPECT_TRUE(is_folded(corners.safe_percent + 1));
  const LoadedScenario sound = Load("weighed.yaml");
  const RolloutModel other(sound.files);
  EXPECT_EQ(FindFoldedCorners(*other.design(), *other.scene().design).folded, 0);
  EXPECT_EQ(FindFoldedCorners(*other.design(), *other.scene().design).safe_percent, 100);
}

}  // namespace designed_mesh_test
}  // namespace knap
