// A coarse designed mesh that is refined bends with its cage: shape, contact and gradients.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "sim/geometry/mesh_refinement.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/box_mesh.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace refined_mesh_test {

using Eigen::VectorXd;

// A ball on a plate of two triangles a side, beside its middle, which the cage can lift.
const char kBallOnPlate[] = R"(schema: 2
name: plate
gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]
bodies:
  - name: plate
    joint: {type: fixed}
    shapes: [{type: designed_mesh}]
  - name: ball
    joint: {type: free}
    shapes: [{type: sphere, radius: 6 mm}]
    inertia: {type: solid, mass: 5 g}
    initial: {position: [7 mm, 1 mm, 9.5 mm]}
contacts:
  - {bodies: [ball, plate], stiffness: 3e7 N/m^3, damping: 5 s/m, friction: 0.3, stick_distance: 50 um}
signals:
  - {name: x, type: position, body: ball, axis: x}
  - {name: z, type: position, body: ball, axis: z}
loss: {task: [{signals: [x, z], shape: square, scale: 1 mm}]}
rollout: {horizon: 80 ms, step: 2 ms, integrator: bdf2, newton_tolerance: 1e-13}
design:
  parameters:
    - {name: arch, initial: 0 mm, lower: -2 mm, upper: 2 mm}
    - {name: width, initial: 20 mm, lower: 16 mm, upper: 24 mm}
  bodies:
    - name: plate
      mesh: plate.obj
      cage: cage.obj
      mesh_unit: 1 mm
      vertex_groups:
        - {name: middle, vertices: [4, 5, 6, 7]}
        - {name: far_side, box: {lower: [-1 m, 11 mm, -1 m], upper: [1 m, 11 mm, 1 m]}}
      moves:
        - {parameter: arch, group: middle, direction: [0, 0, 1]}
        - {parameter: width, group: far_side, direction: [0, 1, 0]}
)";

// A cage with a ring in the middle, from -y to y: vertices 4 to 7.
std::string MakeCageObj(int middle_y = 11) {
  std::string text;
  for (const int x : {-31, 0, 31}) {
    const int side = x == 0 ? middle_y : 11;
    for (const auto& [y, z] : {std::pair{-side, -1}, {side, -1}, {side, 4}, {-side, 4}}) {
      text += fmt::format("v {} {} {}\n", x, y, z);
    }
  }
  text += "f 1 3 2\nf 1 4 3\nf 9 10 11\nf 9 11 12\n";
  for (const int k : {0, 4}) {
    for (const auto& [a, b, c] :
         {std::array{1, 2, 6}, {1, 6, 5}, {4, 8, 7}, {4, 7, 3}, {2, 3, 7}, {2, 7, 6}, {1, 5, 8}, {1, 8, 4}}) {
      text += fmt::format("f {} {} {}\n", a + k, b + k, c + k);
    }
  }
  return text;
}

RolloutModel MakeModel(const std::string& refine, const std::string& cage = MakeCageObj()) {
  std::string scene = kBallOnPlate;
  if (!refine.empty()) scene.insert(scene.find("      vertex_groups"), "      refine: " + refine + "\n");
  return RolloutModel(
      {{kScenarioFileName, scene}, {"plate.obj", test::MakeBoxObj(-30, 30, -10, 10, 0, 3)}, {"cage.obj", cage}});
}

RolloutInput MakeInput(double arch, double width) {
  RolloutInput input;
  input.theta = Eigen::Vector2d(arch, width);
  return input;
}

const TriangleMesh& GetMesh(const RolloutModel& model) { return model.design()->Find("plate")->initial_mesh(); }

// The height of the surface's upper side half-way along, where a plate of two triangles has no vertex.
double FindRise(const RolloutModel& model, double arch) {
  double rise = 0.0;
  for (const Eigen::Vector3d& v : model.design()->Find("plate")->CalcMesh(MakeInput(arch, 0.02).theta).vertices) {
    rise = std::max(rise, v.z());
  }
  return rise - 0.003;
}

TEST(RefinedMesh, BendsWithItsCage) {
  const RolloutModel coarse = MakeModel(""), fine = MakeModel("3 mm");
  EXPECT_EQ(GetMesh(coarse).triangles.size(), 12u);
  EXPECT_GT(GetMesh(fine).triangles.size(), 200u);
  EXPECT_LE(CalcLongestEdge(GetMesh(fine)), 0.003);
  EXPECT_LT(FindRise(coarse, 0.002), 0.0002);
  EXPECT_GT(FindRise(fine, 0.002), 0.0015);
  EXPECT_TRUE(FindDefects(fine.design()->Find("plate")->CalcMesh(MakeInput(0.002, 0.024).theta)).empty());
}

// Forces are integrals over the surface, the same however it is cut: only rounding differs.
TEST(RefinedMesh, TouchesAsBeforeWhereItDoesNotBend) {
  RolloutModel coarse = MakeModel(""), fine = MakeModel("3 mm");
  const RolloutOutput a = coarse.Run(MakeInput(0.0, 0.02), {});
  const RolloutOutput b = fine.Run(MakeInput(0.0, 0.02), {});
  ASSERT_TRUE(a.certificate.converged && b.certificate.converged);
  EXPECT_GT(a.certificate.largest_force, 0.01);
  EXPECT_NEAR(a.loss, b.loss, 1e-9 * a.loss);
  EXPECT_NE(coarse.Run(MakeInput(0.002, 0.02), {}).loss, fine.Run(MakeInput(0.002, 0.02), {}).loss);
}

TEST(RefinedMesh, HasItsGradient) {
  for (const char* refine : {"8 mm", "3 mm"}) {
    RolloutModel model = MakeModel(refine);
    const RolloutInput input = MakeInput(0.0011, 0.0207);
    const RolloutOutput out = model.Run(input, {});
    ASSERT_TRUE(out.certificate.converged && out.certificate.finite);
    const auto evaluate = [&](const VectorXd& theta) {
      RolloutInput at = input;
      at.theta = theta;
      at.want_gradient = false;
      at.theta_nodes = input.theta;
      return model.Run(at, {}).loss;
    };
    const double difference = test::CalcDifference(evaluate, input.theta, 0, 4e-7);
    EXPECT_GT(std::abs(difference), 1e2);  // [1/m]: a coarse plate has next to none
    EXPECT_NEAR(out.gradient(0), difference, 1e-6 * std::abs(difference)) << refine;
    EXPECT_NEAR(out.gradient(1), test::CalcDifference(evaluate, input.theta, 1, 4e-7), 1e-6 * std::abs(difference))
        << refine;
  }
}

// The corners of the plate lie in a cage with a waist, and the middles of its edges do not.
TEST(RefinedMesh, WhatReachesOutOfTheCageOnceRefinedIsRefused) {
  const std::string cage = MakeCageObj(8);
  EXPECT_NO_THROW(MakeModel("", cage));
  EXPECT_THAT([&] { MakeModel("5 mm", cage); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("the mesh lies outside its cage")));
}

TEST(RefinedMesh, TooManyTrianglesAreRefusedWithWhatIsAllowed) {
  try {
    MakeModel("1 um");
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::MatchesRegex("design of 'plate': more than 20000 triangles would come of the 12 "
                                                    "of plate.obj; 0, or [0-9.]+ mm and more are allowed"));
    const std::string line = error.what();
    const std::size_t begin = line.find(" or ") + 4;
    EXPECT_NO_THROW(MakeModel(line.substr(begin, line.find(" and") - begin)));
  }
}

}  // namespace refined_mesh_test
}  // namespace knap
