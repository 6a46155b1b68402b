// What the simulator refuses of scenarios whose format is right, each with its place in the file.
#include "sim/rollout/check_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "sim/rollout/built_scene.h"
#include "sim/rollout/rollout.h"
#include "tests/sim/scenarios/edited_scene.h"

namespace knap {
namespace check_model_test {

namespace fs = std::filesystem;

std::string ReadPushing() {
  std::ifstream file(KNAP_CONFIGS "/pushing.yaml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// configs/pushing.yaml with edits, beside its meshes.
class CheckModelTest : public testing::TestWithParam<SceneErrorCase> {
 protected:
  void SetUp() override {
    std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = fs::path(testing::TempDir()) / ("knap_check_model_" + std::to_string(getpid()) + name);
    fs::create_directories(folder_);
    fs::copy(KNAP_CONFIGS "/meshes", folder_ / "meshes");
  }
  void TearDown() override { fs::remove_all(folder_); }

  LoadedScenario Load(const std::string& text) {
    std::ofstream(folder_ / "p.yaml") << text;
    LoadedScenario scenario = LoadScenario(folder_ / "p.yaml");
    CheckModel(scenario);
    return scenario;
  }

  // The errors, without the folder.
  std::string FindErrors(const std::string& text) {
    std::string errors = Load(text).parsed.FormatErrors();
    const std::string prefix = folder_.string() + "/";
    for (std::size_t at = errors.find(prefix); at != std::string::npos; at = errors.find(prefix)) {
      errors.erase(at, prefix.size());
    }
    return errors;
  }

  fs::path folder_;
};

TEST_F(CheckModelTest, TheSimulatorTakesPushing) {
  const LoadedScenario scenario = Load(ReadPushing());
  EXPECT_EQ(scenario.parsed.FormatErrors(), "");
  EXPECT_NO_THROW(RolloutModel(scenario.files));
}

TEST_P(CheckModelTest, ReportsOnceAtItsPlace) {
  const EditedScene scene = EditScene(ReadPushing(), GetParam().original, GetParam().edited);
  // Where the error stands far from the edit, the case itself says at which line and column.
  const std::string place = scene.place.empty() ? "" : scene.place + ": ";
  EXPECT_EQ(FindErrors(scene.text), "p.yaml:" + place + GetParam().error + "\n");
}

const SceneErrorCase kRefused[] = {
    {"GripOfWhatNothingMoves",
     "contacts:", "grips:\n  - {body: pusher, held: @table, stiffness: 1 N/m, until: 1 s}\ncontacts:",
     "grips[0].held: value 'table': forces move neither pusher nor table, so this grip does nothing"},
    {"TwoSurfaces", "bodies: [pea, table]", "bodies: @[pusher, table]",
     "contacts[0].bodies: forces move neither pusher nor table, so their contact does nothing; a signal could "
     "watch its depth"},
    {"SolidMesh", "shapes: [{type: designed_mesh}]",
     "shapes: [{type: designed_mesh}]\n    inertia: {type: @solid, mass: 1 g}",
     "bodies.pusher.inertia.type: value 'solid': the mass of a designed mesh follows from a density, or is given by an "
     "explicit inertia and stays"},
    {"VertexBeyondTheCage", "vertices: [20, 21, 22, 23]", "vertices: [20, 21, @24, 23]",
     "design.bodies.pusher.vertex_groups.right_tip.vertices[2]: value '24': the cage has 24 vertices, 0 to 23"},
    {"BoxWithoutAVertex", "{name: right_tip, vertices: [20, 21, 22, 23]}",
     "{name: right_tip, box: @{lower: [0 m, 0 m, 0 m], upper: [1 mm, 1 mm, 1 mm]}}",
     "design.bodies.pusher.vertex_groups.right_tip.box: has none of the cage's vertices"},
    {"PlaneWithoutAVertex", "{name: right_tip, vertices: [20, 21, 22, 23]}",
     "{name: right_tip, plane: @{point: [1 m, 0 m, 0 m], normal: [1, 0, 0]}}",
     "design.bodies.pusher.vertex_groups.right_tip.plane: has none of the cage's vertices"},
    {"RefinedBeyondTheLimit", "mesh_unit: 1 mm", "mesh_unit: 1 mm\n      refine: @1 um",
     "design.bodies.pusher.refine: value '1 um': more than 20000 triangles would come of the 880 of meshes/pusher.obj; "
     "0, or 2.1 mm and more are allowed"},
    {"NoMesh", "mesh: meshes/pusher.obj", "mesh: @meshes/make_pusher.py",
     "design.bodies.pusher.mesh: value 'meshes/make_pusher.py': meshes/make_pusher.py: cannot read '.py' files as "
     "meshes; save it as "
     ".obj or .stl"},
};

INSTANTIATE_TEST_SUITE_P(All, CheckModelTest, testing::ValuesIn(kRefused),
                         [](const auto& the_case) { return std::string(the_case.param.name); });

TEST_F(CheckModelTest, AMeshMustBeClosed) {
  std::ofstream(folder_ / "meshes/open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  const EditedScene scene = EditScene(ReadPushing(), "cage: meshes/pusher_cage.obj", "cage: @meshes/open.obj");
  EXPECT_THAT(FindErrors(scene.text),
              testing::StartsWith(
                  "p.yaml:" + scene.place +
                  ": design.bodies.pusher.cage: value 'meshes/open.obj': must be closed and face outwards; it has "));
}

// The pea of configs/pushing.yaml, which meets the pusher, as another body.
TEST_F(CheckModelTest, MeshesThatAreNotDesigned) {
  for (const char* name : {"box.obj", "notched_bar.obj"}) {
    fs::copy(fs::path(KNAP_TEST_DATA) / "mesh" / name, folder_ / "meshes" / name);
  }
  std::ofstream(folder_ / "meshes/open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  const auto with = [](const std::string& shape) {
    return EditScene(ReadPushing(), "{type: sphere, radius: 7 mm}", shape);
  };
  const EditedScene convex = with("{type: mesh, file: meshes/box.obj, unit: 1 mm}");
  EXPECT_EQ(FindErrors(convex.text), "");
  EXPECT_NO_THROW(RolloutModel(Load(convex.text).files));
  const EditedScene notched = with("{type: mesh, file: meshes/notched_bar.obj, unit: 1 mm}");
  EXPECT_EQ(FindErrors(notched.text), "");
  const RolloutModel apart(Load(notched.text).files);
  EXPECT_GT(apart.source().meshes().at({"pea", 0}).pieces.size(), 1u);
  const EditedScene open = with("{type: mesh, file: @meshes/open.obj, unit: 1 mm}");
  EXPECT_THAT(FindErrors(open.text),
              testing::StartsWith(
                  "p.yaml:" + open.place +
                  ": bodies.pea.shapes[0].file: value 'meshes/open.obj': must be closed and face outwards; it has "));
  const EditedScene no_mesh = with("{type: mesh, file: @meshes/make_pusher.py, unit: 1 mm}");
  EXPECT_EQ(
      FindErrors(no_mesh.text),
      "p.yaml:" + no_mesh.place +
          ": bodies.pea.shapes[0].file: value 'meshes/make_pusher.py': meshes/make_pusher.py: cannot read '.py' files "
          "as meshes; save it as .obj or .stl\n");
}

// A linear policy of one motor: two inputs and a bias.
TEST_F(CheckModelTest, WeightsMustFitTheNetwork) {
  constexpr char kCrank[] = R"(schema: 2
name: crank
bodies:
  - name: crank
    joint: {type: revolute, axis: [0, 1, 0], actuator: {type: force, limit: 1 N*m}}
    shapes: [{type: sphere, radius: 20 mm}]
    inertia: {type: solid, mass: 1 kg}
rollout: {horizon: 1 s, step: 5 ms}
policy:
  actuators: [crank]
  interval: 50 ms
  observations: [{signal: angle}, {signal: rate}]
  hidden: []
  initial: {type: file, file: weights.txt}
signals: [{name: angle, type: angle, joint: crank}, {name: rate, type: rate, joint: crank}]
learning: {method: diffhand, optimize: [policy]}
)";
  std::ofstream(folder_ / "weights.txt") << "0.5 -0.25\n0.125\n";
  EXPECT_EQ(FindErrors(kCrank), "");
  std::ofstream(folder_ / "weights.txt") << "0.5 -0.25\n";
  EXPECT_EQ(FindErrors(kCrank),
            "p.yaml:14:31: policy.initial.file: value 'weights.txt': weights.txt:2:1: has 2 weights; the policy's "
            "network has 3\n");
  std::ofstream(folder_ / "weights.txt") << "0.5 -9\n0.125\n";
  EXPECT_EQ(FindErrors(kCrank),
            "p.yaml:14:31: policy.initial.file: value 'weights.txt': weights.txt:1:5: value '-9': must lie from lower, "
            "-3, to upper, 3\n");
}

// Errors of the format and of the model come together, and one does not cause another.
TEST_F(CheckModelTest, AllErrorsAtOnce) {
  EditedScene scene = EditScene(ReadPushing(), "vertices: [20, 21, 22, 23]", "vertices: [20, 21, 22, @99]");
  const std::string vertex = scene.place;
  scene = EditScene(scene.text, "bodies: [pea, table]", "bodies: @[pusher, table]");
  const std::string contact = scene.place;
  scene = EditScene(scene.text, "period: 3 s", "period: @3 m");
  const std::string errors = FindErrors(scene.text);
  for (const std::string& place : {vertex, contact, scene.place}) {
    EXPECT_THAT(errors, testing::HasSubstr("p.yaml:" + place + ": "));
  }
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 3) << errors;
}

TEST_F(CheckModelTest, AShapeThatIsWrongCausesNoFurtherErrors) {
  const EditedScene scene = EditScene(ReadPushing(), "shapes: [{type: half_space}]", "shapes: [{type: @halfspace}]");
  const std::string errors = FindErrors(scene.text);
  EXPECT_THAT(errors, testing::StartsWith("p.yaml:" + scene.place + ": bodies.table.shapes[0].type"));
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
}

}  // namespace check_model_test
}  // namespace knap
