// Bodies of several shapes, each with a pose: closed forms, bodies fixed to one another, meshes taken apart, gradients
// and what is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/built_scene.h"
#include "sim/rollout/check_model.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/rollout/designed_bar.h"
#include "tests/sim/rollout/expect_gradient.h"

namespace knap {
namespace shapes_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Files = std::map<std::string, std::string>;

std::vector<Pose> RecordPoses(const Files& files, const std::string& body) {
  RolloutModel model(files);
  const Recording recording = model.Record({}, 0.0).recording;
  return recording.Find(body).X_WB;
}

double FindLargestDifference(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    largest = std::max({largest, (a[k].p - b[k].p).norm(), 0.01 * (a[k].R - b[k].R).norm()});
  }
  return largest;
}

// Two balls of 10 mm on a rod of 3 mm, 60 mm apart along y.
Files MakeDumbbell(const std::string& gravity, double height_mm) {
  return {{kScenarioFileName, fmt::format(R"(schema: 2
name: dumbbell
gravity: {}
bodies:
  - {{name: floor, joint: {{type: fixed}}, shapes: [{{type: half_space}}]}}
  - name: dumbbell
    joint: {{type: free}}
    shapes:
      - {{type: sphere, radius: 10 mm, position: [0 mm, 30 mm, 0 mm]}}
      - {{type: sphere, radius: 10 mm, position: [0 mm, -30 mm, 0 mm]}}
      - {{type: capsule, radius: 3 mm, length: 34 mm, orientation_rpy: [90 deg, 0 deg, 0 deg]}}
    inertia: {{type: density, density: 1 g/cm^3}}
    initial: {{position: [0 mm, 0 mm, {} mm]}}
contacts: [{{bodies: [dumbbell, floor], stiffness: 1e10 N/m^3, damping: 5 s/m, friction: 0.5, stick_distance: 1 um}}]
rollout: {{horizon: 0.3 s, step: 1 ms, newton_tolerance: 1e-12}}
)",
                                          gravity, height_mm)}};
}

TEST(Shapes, ADumbbellWeighsTheSumOfItsParts) {
  RolloutModel model(MakeDumbbell("[0 m/s^2, 0 m/s^2, -9.81 m/s^2]", 10.0));
  const SceneModel built = BuildModel(model.scene(), {}, model.source().meshes());
  const double ball = 1000.0 * 4.0 / 3.0 * M_PI * 1e-6;
  const double rod = 1000.0 * M_PI * 9e-6 * 0.034;
  const double caps = 1000.0 * 4.0 / 3.0 * M_PI * 27e-9;
  const double along = 2.0 * ball * 0.4 * 1e-4 + rod * 0.5 * 9e-6 + caps * 0.4 * 9e-6;
  const double across = 2.0 * ball * (0.4 * 1e-4 + 9e-4) + rod * (0.034 * 0.034 / 12.0 + 9e-6 / 4.0) +
                        caps * (0.4 * 9e-6 + 0.017 * 0.017 + 0.75 * 0.017 * 0.003);
  const double mass = 2.0 * ball + rod + caps;
  const Matrix6d expected =
      MakeSpatialInertia(mass, Vector3d::Zero(), Eigen::Matrix3d(Vector3d(across, along, across).asDiagonal()));
  const Matrix6d& M = built.tree.bodies()[static_cast<std::size_t>(built.body_index.at("dumbbell"))].M;
  EXPECT_LE((M - expected).cwiseAbs().maxCoeff(), 1e-12 * mass) << M << "\n\n" << expected;
}

TEST(Shapes, ADumbbellFallsAndRolls) {
  const std::vector<Pose> falling = RecordPoses(MakeDumbbell("[0 m/s^2, 0 m/s^2, -9.81 m/s^2]", 600.0), "dumbbell");
  EXPECT_NEAR(falling.back().p.z(), 0.6 - 0.5 * 9.81 * 0.09, 1e-6);

  const std::vector<Pose> rolling = RecordPoses(MakeDumbbell("[1 m/s^2, 0 m/s^2, -9.76 m/s^2]", 10.0), "dumbbell");
  const double ball = 4.0 / 3.0 * M_PI * 1e-6;
  const double rod = M_PI * 9e-6 * 0.034;
  const double caps = 4.0 / 3.0 * M_PI * 27e-9;
  const double mass = 2.0 * ball + rod + caps;
  const double along = 2.0 * ball * 0.4 * 1e-4 + rod * 0.5 * 9e-6 + caps * 0.4 * 9e-6;
  const double way = 0.5 * 0.09 / (1.0 + along / (mass * 1e-4));
  // It settles by some micrometres and gives way by one before it sticks.
  EXPECT_NEAR(rolling.back().p.x(), way, 0.003 * way);
  EXPECT_NEAR(rolling.back().p.y(), 0.0, 1e-9);
  EXPECT_NEAR(rolling.back().p.z(), 0.01, 2e-5);
  EXPECT_NEAR(std::atan2(rolling.back().R(0, 2), rolling.back().R(0, 0)), std::remainder(way / 0.01, 2.0 * M_PI), 0.02);
}

struct Part {
  std::string shape;  // without braces
  std::string position, orientation_rpy;
};

// A body of these parts, as its shapes or as bodies fixed to a first one; it falls on a floor and a post.
Files MakeComposite(const std::vector<Part>& parts, bool as_bodies, const Files& meshes) {
  std::string shapes, bodies, contacts;
  const char* material = "stiffness: 1e8 N/m^3, damping: 3 s/m, friction: 0.3, stick_distance: 10 um";
  const auto touch = [&](const std::string& name) {
    for (const char* other : {"floor", "post"}) {
      contacts += fmt::format("  - {{bodies: [{}, {}], {}}}\n", name, other, material);
    }
  };
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    const std::string pose = fmt::format("position: {}, orientation_rpy: {}", part.position, part.orientation_rpy);
    if (as_bodies) {
      bodies += fmt::format(
          "  - {{name: part_{}, parent: whole, joint: {{type: fixed, {}}}, shapes: [{{{}}}],\n"
          "     inertia: {{type: density, density: 1 g/cm^3}}}}\n",
          i, pose, part.shape);
      touch(fmt::format("part_{}", i));
    } else {
      shapes += fmt::format("      - {{{}, {}}}\n", part.shape, pose);
    }
  }
  if (!as_bodies) touch("whole");
  const std::string own = as_bodies ? "    inertia: {type: explicit, mass: 1e-9 kg, moments: [1e-15 kg*m^2, 1e-15 "
                                      "kg*m^2, 1e-15 kg*m^2]}\n"
                                    : "    shapes:\n" + shapes + "    inertia: {type: density, density: 1 g/cm^3}\n";
  Files files = meshes;
  files[kScenarioFileName] =
      "schema: 2\nname: composite\nbodies:\n"
      "  - {name: floor, joint: {type: fixed}, shapes: [{type: half_space}]}\n"
      "  - {name: post, joint: {type: fixed, position: [20 mm, 0 mm, 0 mm]}, shapes: [{type: box, size: [20 mm, 20 mm, "
      "20 mm]}]}\n"
      "  - name: whole\n    joint: {type: free}\n" +
      own + "    initial: {position: [0 mm, 0 mm, 55 mm], orientation_rpy: [20 deg, 30 deg, 10 deg]}\n" + bodies +
      "contacts:\n" + contacts +
      "rollout: {horizon: 0.15 s, step: 0.5 ms, integrator: bdf2, newton_tolerance: 1e-12}\n";
  return files;
}

void ExpectTheSame(const std::vector<Part>& parts, const Files& meshes) {
  const std::vector<Pose> one = RecordPoses(MakeComposite(parts, false, meshes), "whole");
  const std::vector<Pose> several = RecordPoses(MakeComposite(parts, true, meshes), "whole");
  // A free fall would end below the floor.
  EXPECT_GT(one.back().p.z(), 0.0);
  // The bodies' frame weighs a microgram.
  EXPECT_LE(FindLargestDifference(one, several), 1e-6);
}

TEST(Shapes, ARingOfEightCapsulesIsEightBodies) {
  std::vector<Part> parts;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * M_PI / 4.0;
    parts.push_back({"type: capsule, radius: 4 mm, length: 20 mm",
                     fmt::format("[{} mm, {} mm, 0 mm]", 25.0 * std::cos(angle), 25.0 * std::sin(angle)),
                     fmt::format("[90 deg, 0 deg, {} deg]", 45.0 * i)});
  }
  ExpectTheSame(parts, {});
}

TEST(Shapes, APosedShapeIsAPosedBody) {
  const Files meshes = {{"pyramid.obj", WriteObj(test::MakePyramid(), 1e-3)}};
  for (const char* shape : {"type: box, size: [30 mm, 20 mm, 10 mm]", "type: capsule, radius: 8 mm, length: 20 mm",
                            "type: cylinder, radius: 12 mm, length: 20 mm", "type: sphere, radius: 15 mm",
                            "type: mesh, file: pyramid.obj, unit: 2 mm"}) {
    SCOPED_TRACE(shape);
    const bool needs = std::string(shape).find("mesh") != std::string::npos;
    ExpectTheSame({{shape, "[5 mm, -4 mm, 8 mm]", "[40 deg, 25 deg, -30 deg]"}}, needs ? meshes : Files{});
  }
}

// An angle of 30 x 40 mm, 10 mm wide and 8 mm thick, around its corner.
TriangleMesh MakeAngle() {
  const Eigen::Vector2d outline[] = {{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 40}, {0, 40}};
  TriangleMesh mesh;
  for (const double z : {0.0, 0.008}) {
    for (const Eigen::Vector2d& p : outline) mesh.vertices.emplace_back(1e-3 * p.x(), 1e-3 * p.y(), z);
  }
  for (const Eigen::Vector3i& t : {Eigen::Vector3i(0, 1, 2), {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.emplace_back(t[2], t[1], t[0]);
    mesh.triangles.emplace_back(t[0] + 6, t[1] + 6, t[2] + 6);
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.emplace_back(i, j, j + 6);
    mesh.triangles.emplace_back(i, j + 6, i + 6);
  }
  return mesh;
}

// Elastic and without friction what presses on a half-space is the volume below it, however it is cut into pieces.
TEST(Shapes, AMeshTakenApartPressesAsItsBoxesDo) {
  const auto make = [](const std::string& shapes) {
    Files files = {{kScenarioFileName,
                    "schema: 2\nname: angle\nbodies:\n"
                    "  - {name: floor, joint: {type: fixed}, shapes: [{type: half_space}]}\n"
                    "  - name: angle\n    joint: {type: free}\n    shapes: [" +
                        shapes +
                        "]\n    inertia: {type: density, density: 1 g/cm^3}\n"
                        "    initial: {position: [0 mm, 0 mm, 30 mm], orientation_rpy: [20 deg, 30 deg, 10 deg]}\n"
                        "contacts: [{bodies: [angle, floor], stiffness: 1e8 N/m^3}]\n"
                        "rollout: {horizon: 0.1 s, step: 0.5 ms, integrator: bdf2, newton_tolerance: 1e-13}\n"}};
    if (shapes.find("angle.obj") != shapes.npos) files["angle.obj"] = WriteObj(MakeAngle(), 1e-3);
    return files;
  };
  const Files mesh = make("{type: mesh, file: angle.obj, unit: 1 mm}");
  const Files boxes = make(
      "{type: box, size: [30 mm, 10 mm, 8 mm], position: [15 mm, 5 mm, 4 mm]}, "
      "{type: box, size: [10 mm, 30 mm, 8 mm], position: [5 mm, 25 mm, 4 mm]}");
  RolloutModel model(mesh);
  const FixedMesh& fixed = model.source().meshes().at({"angle", 0});
  EXPECT_EQ(fixed.pieces.size(), 2u);
  ASSERT_EQ(fixed.volumes.size(), 2u);
  EXPECT_NEAR(fixed.volumes[0] + fixed.volumes[1], 600.0 * 8.0 * 1e-9, 1e-15);
  const std::vector<Pose> of_mesh = RecordPoses(mesh, "angle");
  EXPECT_GT(of_mesh.back().p.z(), -0.02);
  // What a file in nine digits leaves.
  EXPECT_LE(FindLargestDifference(of_mesh, RecordPoses(boxes, "angle")), 1e-7);
}

// A designed box beside a ball and an askew box, all of one density, falls on a floor.
TEST(Shapes, GradientOfADesignedMeshBesideOtherShapes) {
  const std::string text = R"(schema: 2
name: mixed
bodies:
  - {name: floor, joint: {type: fixed}, shapes: [{type: half_space, orientation_rpy: [5 deg, 10 deg, 0 deg]}]}
  - name: tool
    joint: {type: free}
    shapes:
      - {type: sphere, radius: 6 mm, position: [-24 mm, 1 mm, 4 mm]}
      - {type: designed_mesh}
      - {type: box, size: [10 mm, 8 mm, 6 mm], position: [0 mm, 2 mm, 10 mm], orientation_rpy: [30 deg, 20 deg, 0 deg]}
    inertia: {type: density, density: 1 g/cm^3}
    initial: {position: [0 mm, 0 mm, 8 mm], orientation_rpy: [2 deg, 3 deg, 1 deg]}
contacts: [{bodies: [tool, floor], stiffness: 1e8 N/m^3, damping: 5 s/m, friction: 0.3, stick_distance: 20 um}]
)" + std::string(test::kDesignedBar);
  const Vector3d center(-0.006, 0.0, 0.005);
  RolloutModel model({{kScenarioFileName, text},
                      {"tool.obj", WriteObj(test::MakeBoxMesh({0.012, 0.004, 0.005}, center), 1e-3)},
                      {"cage.obj", WriteObj(test::MakeBoxMesh({0.013, 0.005, 0.006}, center), 1e-3)}});
  test::ExpectGradient(&model, Eigen::Vector2d(0.0243, 0.0002), 4e-7);
}

// A designed angle falls with its inner corner over a designed box, and both shapes count.
TEST(Shapes, GradientOfTwoDesignedMeshesOnOneAnother) {
  const std::string text = R"(schema: 2
name: two_designed
bodies:
  - {name: stand, joint: {type: fixed}, shapes: [{type: designed_mesh}]}
  - name: tool
    joint: {type: free}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 1 g/cm^3}
    initial: {position: [0 mm, 0 mm, 4.5 mm], orientation_rpy: [5 deg, 4 deg, 1 deg]}
contacts: [{bodies: [tool, stand], stiffness: 1e8 N/m^3, damping: 5 s/m, friction: 0.3, stick_distance: 20 um}]
design:
  parameters:
    - {name: width, initial: 30 mm, lower: 20 mm, upper: 40 mm}
    - {name: slant, initial: 0 mm, lower: -1 mm, upper: 1 mm}
    - {name: top, initial: 0 mm, lower: -1 mm, upper: 1 mm}
  bodies:
    - name: tool
      mesh: angle.obj
      cage: around_angle.obj
      mesh_unit: 1 mm
      vertex_groups:
        - {name: right, vertices: [1, 3, 5, 7]}
        - {name: lower_right, vertices: [1, 3]}
      moves:
        - {parameter: width, group: right, direction: [1, 0, 0]}
        - {parameter: slant, group: lower_right, direction: [0, 0, 1]}
    - name: stand
      mesh: box.obj
      cage: around_box.obj
      mesh_unit: 1 mm
      vertex_groups: [{name: end, vertices: [5, 7]}]
      moves: [{parameter: top, group: end, direction: [0, 0, 1]}]
rollout: {horizon: 60 ms, step: 1 ms, integrator: bdf2, newton_tolerance: 1e-12}
signals:
  - {name: off, type: distance, body: tool, point: [6 mm, 1 mm, 0 mm], targets: [{position: [0 m, 0 m, 0 m]}]}
  - {name: press, type: depth, bodies: [tool, stand]}
loss: {task: [{signals: [off], shape: absolute}, {signals: [press], shape: absolute, weight: 100}]}
)";
  const Vector3d middle(0.015, 0.02, 0.004);
  const Files files = {
      {kScenarioFileName, text},
      {"angle.obj", WriteObj(MakeAngle(), 1e-3)},
      {"around_angle.obj", WriteObj(test::MakeBoxMesh({0.016, 0.021, 0.005}, middle), 1e-3)},
      {"box.obj", WriteObj(test::MakeBoxMesh({0.03, 0.03, 0.002}, {0.01, 0.01, -0.002}), 1e-3)},
      {"around_box.obj", WriteObj(test::MakeBoxMesh({0.031, 0.031, 0.003}, {0.01, 0.01, -0.002}), 1e-3)}};
  RolloutModel model(files);
  const std::vector<double> volumes = model.design()->CalcPieceVolumes("tool");
  ASSERT_EQ(volumes.size(), 2u);
  EXPECT_NEAR(volumes[0] + volumes[1], 600.0 * 8.0 * 1e-9, 1e-15);
  EXPECT_EQ(model.design()->CalcPieceVolumes("stand").size(), 1u);
  test::ExpectGradient(&model, Eigen::Vector3d(0.0303, 0.0002, 0.0001), 3e-8);
}

std::string FindErrors(const std::string& shapes, const std::string& others, const std::string& inertia) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "knap_shapes";
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / "s.yaml";
  std::ofstream(file) << "schema: 2\nname: s\nbodies:\n"
                         "  - {name: other, joint: {type: fixed}, shapes: [" +
                             others + "]}\n  - {name: thing, joint: {type: free}, shapes: [" + shapes +
                             "], inertia: " + inertia + "}\n" +
                             "contacts: [{bodies: [thing, other], stiffness: 1e8 N/m^3}]\n"
                             "rollout: {horizon: 1 s, step: 1 ms}\n";
  LoadedScenario scenario = LoadScenario(file.string(), {});
  CheckModel(scenario);
  return scenario.parsed.FormatErrors();
}

TEST(Shapes, RefusesByName) {
  using testing::HasSubstr;
  const std::string half_space = "{type: half_space}";
  const std::string solid = "{type: solid, mass: 1 g}";
  EXPECT_EQ(FindErrors("{type: sphere, radius: 1 mm}, {type: box, size: [1 mm, 1 mm, 1 mm]}", half_space, solid), "");
  EXPECT_THAT(FindErrors("{type: designed_mesh, position: [1 mm, 0 mm, 0 mm]}", half_space, solid),
              HasSubstr("bodies.thing.shapes[0].position: unknown key"));
  EXPECT_THAT(FindErrors("{type: designed_mesh}, {type: designed_mesh}", half_space, solid),
              HasSubstr("bodies.thing.shapes[1].type: value 'designed_mesh': a body has at most one designed_mesh"));
  EXPECT_THAT(
      FindErrors("{type: sphere, radius: 1 mm}, {type: half_space}", "{type: box, size: [1 mm, 1 mm, 1 mm]}", solid),
      HasSubstr("bodies.thing.inertia.type: value 'solid': needs shapes with a volume (sphere, capsule, "
                "cylinder, box, designed_mesh or mesh) and no other"));
  EXPECT_THAT(FindErrors(half_space, half_space + ", {type: sphere, radius: 1 mm}",
                         "{type: explicit, mass: 1 g, moments: [1 kg*m^2, 1 kg*m^2, 1 kg*m^2]}"),
              HasSubstr("contacts[0].bodies: half_space and half_space do not touch; a half_space touches sphere, "
                        "capsule, cylinder, box, mesh, designed_mesh"));
  EXPECT_THAT(FindErrors("", half_space, "{type: explicit, mass: 1 g, moments: [1 kg*m^2, 1 kg*m^2, 1 kg*m^2]}"),
              HasSubstr("this body has no shape to touch with"));
}

}  // namespace shapes_test
}  // namespace knap
