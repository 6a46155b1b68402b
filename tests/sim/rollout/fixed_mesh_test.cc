// Bodies with meshes that nobody designs: what they weigh, what boxes of triangles do beside boxes, and what designed
// meshes, balls and boxes do on them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/build_body.h"
#include "sim/rollout/check_model.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/rollout/designed_bar.h"
#include "tests/sim/rollout/expect_gradient.h"

namespace knap {
namespace fixed_mesh_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Files = std::map<std::string, std::string>;

std::string MakeObj(const TriangleMesh& mesh) { return WriteObj(mesh, 1e-3); }

// A prism of 16 mm, 10 mm and 20 mm along x, z and y, whose ends are triangles.
TEST(FixedMesh, WeighsWhatItsPrismWeighs) {
  const Files files = {{kScenarioFileName,
                        "schema: 2\nname: prism\nbodies:\n"
                        "  - {name: dense, joint: {type: free}, shapes: [{type: mesh, file: prism.obj, unit: 1 mm}],\n"
                        "     inertia: {type: density, density: 2 g/cm^3}}\n"
                        "  - {name: heavy, joint: {type: free}, shapes: [{type: mesh, file: prism.obj, unit: 2 mm}],\n"
                        "     inertia: {type: solid, mass: 5 g}}\n"
                        "rollout: {horizon: 1 ms, step: 1 ms}\n"},
                       {"prism.obj", MakeObj(test::MakeWedge())}};
  const Scene scene = ParseScenarioFiles(files);
  const SceneModel model = BuildModel(scene, {}, ReadFixedMeshes(scene, files));
  const auto expect = [&](const char* name, double mass, double scale) {
    const double b = 0.016 * scale, h = 0.010 * scale, l = 0.020 * scale;
    // About the centroid of a triangle of equal sides: b h³/36 and h b³/48, over its area.
    const double of_height = h * h / 18.0;
    const double of_base = b * b / 24.0;
    const double of_length = l * l / 12.0;
    const Vector3d moments = mass * Vector3d(of_height + of_length, of_height + of_base, of_base + of_length);
    const Matrix6d expected =
        MakeSpatialInertia(mass, Vector3d(0.0, 0.0, scale * (-0.004 + 0.010 / 3.0)), moments.asDiagonal());
    const Matrix6d& M = model.tree.bodies()[static_cast<std::size_t>(model.body_index.at(name))].M;
    EXPECT_LE((M - expected).cwiseAbs().maxCoeff(), 1e-12 * mass) << name << "\n" << M << "\n\n" << expected;
  };
  // The file has nine digits.
  expect("dense", 0.0032, 1.0);
  expect("heavy", 0.005, 2.0);
}

std::vector<Vector3d> RecordPath(RolloutModel* model, const std::string& body) {
  const Recording recording = model->Record({}, 0.0).recording;
  std::vector<Vector3d> p_W;
  for (const Pose& X_WB : recording.Find(body).X_WB) p_W.push_back(X_WB.p);
  return p_W;
}

// A cube that falls on a corner of its own onto another body: its path.
std::vector<Vector3d> DropCube(const std::string& shape, const std::string& other, double other_z) {
  const std::string text =
      "schema: 2\nname: cube\ngravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]\nbodies:\n"
      "  - {name: other, joint: {type: fixed, position: [3 mm, 1 mm, " +
      std::to_string(other_z) + " mm]}, shapes: [" + other +
      "]}\n"
      "  - name: cube\n    joint: {type: free}\n    shapes: [" +
      shape +
      "]\n    inertia: {type: solid, mass: 8 g}\n"
      "    initial: {position: [0 mm, 0 mm, 19 mm], orientation_rpy: [10 deg, 20 deg, 30 deg]}\n"
      "contacts: [{bodies: [cube, other], stiffness: 1e8 N/m^3, damping: 5 s/m, friction: 0.3, stick_distance: 10 "
      "um}]\n"
      "rollout: {horizon: 0.1 s, step: 1 ms, newton_tolerance: 1e-12}\n";
  Files files{{kScenarioFileName, text}};
  const auto add = [&](const std::string& name, const TriangleMesh& mesh) {
    if (text.find(name) != text.npos) files[name] = MakeObj(mesh);
  };
  add("cube.obj", test::MakeBoxMesh(Vector3d::Constant(0.01), Vector3d::Zero()));
  add("pyramid.obj", test::MakePyramid());
  RolloutModel model(files);
  return RecordPath(&model, "cube");
}

TEST(FixedMesh, ACubeOfTrianglesMovesAsABoxDoes) {
  for (const auto& [other, z] : {std::pair{"{type: half_space}", 0.0},
                                 {"{type: sphere, radius: 8 mm}", -8.0},
                                 {"{type: box, size: [30 mm, 30 mm, 10 mm]}", -5.0},
                                 {"{type: mesh, file: pyramid.obj, unit: 1 mm}", -8.0}}) {
    const std::vector<Vector3d> box = DropCube("{type: box, size: [20 mm, 20 mm, 20 mm]}", other, z);
    const std::vector<Vector3d> mesh = DropCube("{type: mesh, file: cube.obj, unit: 1 mm}", other, z);
    ASSERT_EQ(box.size(), mesh.size());
    double difference = 0.0;
    for (std::size_t k = 0; k < box.size(); ++k) difference = std::max(difference, (box[k] - mesh[k]).norm());
    // A free fall would be 49 mm; and steps are held to 1e-12.
    EXPECT_GT(box.back().z(), -0.02) << other;
    EXPECT_LE(difference, 1e-9) << other;
  }
}

LoadedScenario Load(const std::string& scene, const std::vector<std::string>& overrides = {}) {
  LoadedScenario scenario = LoadScenario(std::string(KNAP_TEST_DATA) + "/mesh/" + scene, overrides);
  CheckModel(scenario);
  return scenario;
}

TEST(FixedMesh, IsAFileOfTheScenario) {
  const LoadedScenario scenario = Load("trough.yaml");
  ASSERT_EQ(scenario.parsed.FormatErrors(), "");
  EXPECT_EQ(scenario.files.size(), 2u);
  EXPECT_EQ(scenario.files.count("trough.obj"), 1u);
  const Scene again = ParseScenarioFiles(scenario.files);
  EXPECT_EQ(std::get<MeshShape>(again.bodies[0].shapes[0].kind).file, "trough.obj");
  EXPECT_EQ(std::get<MeshShape>(again.bodies[0].shapes[0].kind).unit, 1e-3);
  Files bent = scenario.files;
  bent["trough.obj"] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  try {
    RolloutModel model(bent);
    FAIL() << "takes an open mesh";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("mesh of 'trough': must be closed and face outwards; it has "));
  }
}

// It is read once, not with every draw.
TEST(FixedMesh, HasOneUnitInAllVariations) {
  const LoadedScenario scenario =
      Load("trough.yaml",
           {"variation=[{key: \"bodies.trough.shapes[0].unit\", distribution: uniform, lower: 1 mm, upper: 2 mm}]"});
  EXPECT_THAT(scenario.parsed.FormatErrors(),
              testing::HasSubstr("variation[0].key: value 'bodies.trough.shapes[0].unit': may not vary; "));
}

TEST(FixedMesh, ABallRollsDownATroughToItsWall) {
  const double g = 9.81;
  const double slope = 5.0 * M_PI / 180.0;
  const Vector3d along(std::cos(slope), 0.0, -std::sin(slope));
  const Vector3d up(std::sin(slope), 0.0, std::cos(slope));
  RolloutModel rolling(Load("trough.yaml").files);
  const Vector3d after = RecordPath(&rolling, "ball").back();
  // 5/7 g sin(slope); it sinks in by 8 um.
  const double way = 0.5 * 5.0 / 7.0 * g * std::sin(slope) * 0.5 * 0.5;
  EXPECT_NEAR(after.dot(along), 0.050 + way, 0.005 * way);
  EXPECT_NEAR(after.dot(up), 0.007, 5e-5);

  RolloutModel resting(Load("trough.yaml", {"rollout.horizon=4 s"}).files);
  const Vector3d end = RecordPath(&resting, "ball").back();
  EXPECT_NEAR(end.dot(along), 0.193, 5e-5);
  EXPECT_NEAR(end.dot(up), 0.007, 5e-5);
}

// The designed box lands on the ridge of a prism.
TEST(FixedMesh, GradientOfADesignedMeshOnAConvexOne) {
  const std::string text = R"(schema: 2
name: ridge
gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]
bodies:
  - name: ridge
    joint: {type: fixed, position: [-5 mm, 0 mm, 0 mm]}
    shapes: [{type: mesh, file: ridge.obj, unit: 1 mm}]
  - name: tool
    joint: {type: free}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 1 g/cm^3}
    initial: {position: [0 mm, 0 mm, 6.2 mm], orientation_rpy: [2 deg, 3 deg, 1 deg]}
contacts: [{bodies: [tool, ridge], stiffness: 1e8 N/m^3, damping: 5 s/m, friction: 0.3, stick_distance: 20 um}]
)" + std::string(test::kDesignedBar);
  const Vector3d center(-0.006, 0.0, 0.005);
  RolloutModel model({{kScenarioFileName, text},
                      {"ridge.obj", MakeObj(test::MakeWedge())},
                      {"tool.obj", MakeObj(test::MakeBoxMesh({0.012, 0.004, 0.005}, center))},
                      {"cage.obj", MakeObj(test::MakeBoxMesh({0.013, 0.005, 0.006}, center))}});
  test::ExpectGradient(&model, Eigen::Vector2d(0.0243, 0.0002), 4e-7);
}

}  // namespace fixed_mesh_test
}  // namespace knap
