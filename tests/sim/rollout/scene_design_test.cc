// Designed bodies that forces move: what follows theta, and gradients through masses, joints, contacts and actuators
// against differences.
#include "sim/rollout/scene_design.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>
#include <vector>

#include "sim/geometry/shape_measures.h"
#include "sim/rollout/control_commands.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace scene_design_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Files = std::map<std::string, std::string>;

// An arm with every law a joint can have, and a hand on it that beats the ground and pushes a ball. Gravity turns them
// down; both links are designed, the hand's joint rides on the arm's end.
constexpr char kArm[] = R"(schema: 2
name: arm
bodies:
  - name: ground
    joint: {type: fixed, position: [0 mm, 0 mm, -30 mm]}
    shapes: [{type: half_space}]
  - name: arm
    joint: {type: revolute, axis: [0, 1, 0], damping: 1e-4 N*m*s/rad, stiffness: 2e-3 N*m/rad, rest: 5 deg,
            limits: {lower: -40 deg, upper: 20 deg, stiffness: 0.5 N*m/rad, damping: 0.2 s/rad, width: 10 deg},
            actuator: {type: position, limit: 5 N*m, stiffness: 3e-3 N*m/rad, damping: 1e-5 N*m*s/rad,
                       lower: -20 deg, upper: 30 deg}}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 1 g/cm^3}
  - name: hand
    parent: arm
    joint: {type: revolute, axis: [0, 1, 0], position: [25 mm, 0 mm, 0 mm], damping: 1e-4 N*m*s/rad,
            attachment: {point: [23.4 mm, 0 mm, 0 mm]}, actuator: {type: force, limit: 5e-3 N*m}}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 1 g/cm^3}
    initial: {angle: 10 deg}
  - name: ball
    joint: {type: free}
    shapes: [{type: sphere, radius: 8 mm}]
    inertia: {type: solid, mass: 2 g}
    initial: {position: [56 mm, 3 mm, -22 mm]}
contacts:
CONTACTS
design:
  parameters:
    - {name: arm_length, initial: 23.4 mm, lower: 15 mm, upper: 40 mm}
    - {name: arm_width, kind: scale, initial: 1, lower: 0.5, upper: 2}
    - {name: hand_height, kind: scale, initial: 1, lower: 0.5, upper: 2}
    - {name: hand_length, kind: scale, initial: 1, lower: 0.5, upper: 2}
  bodies:
    - name: arm
      mesh: meshes/finger_phalanx.obj
      cage: meshes/finger_phalanx_cage.obj
      mesh_unit: 1 mm
      vertex_groups: [{name: arm_end, vertices: [4, 5, 6, 7]}]
      moves:
        - {parameter: arm_length, group: arm_end, direction: [1, 0, 0]}
        - {parameter: arm_width, group: arm_end, direction: [0, 1, 0]}
    - name: hand
      mesh: meshes/finger_tip.obj
      cage: meshes/finger_tip_cage.obj
      mesh_unit: 1 mm
      vertex_groups:
        - {name: hand_end, vertices: [8, 9, 10, 11]}
        - {name: hand_front, vertices: [4, 5, 6, 7, 8, 9, 10, 11]}
      moves:
        - {parameter: hand_height, group: hand_end, direction: [0, 0, 1]}
        - {parameter: hand_length, group: hand_front, direction: [1, 0, 0]}
controls: {actuators: [hand, arm], interval: 50 ms, initial: 0, lower: -2, upper: 2}
# Fixed steps: differences over chosen ones jump.
rollout: {horizon: 0.2 s, step: 1 ms, integrator: bdf2, newton_tolerance: 1e-13}
signals:
  - {name: u_hand, type: command, actuator: hand}
  - {name: u_arm, type: command, actuator: arm}
  - {name: hand_error, type: distance, body: hand, point: [20 mm, 0 mm, 4 mm],
     targets: [{position: [5 cm, 1 cm, 2 cm]}, {after: 90 ms, position: [4 cm, 0 cm, 3 cm]}]}
  - {name: ball_error, type: distance, body: ball, targets: [{position: [9 cm, 0 cm, -2 cm]}]}
loss:
  task:
    - {signals: [u_hand, u_arm], when: {type: samples, every: 50 ms}, weight: 0.02}
    - {signals: [hand_error], when: {type: samples, every: 20 ms}, shape: absolute, scale: 1 cm}
    - {signals: [ball_error], when: {type: samples, every: 50 ms}, shape: absolute, scale: 1 cm, weight: 3}
)";

constexpr char kTouching[] =
    "  - {bodies: [hand, ground], stiffness: 1e7 N/m^3, damping: 2 s/m, friction: 0.6, slip_speed: 1 cm/s, "
    "stick_distance: 50 um}\n"
    "  - {bodies: [ball, ground], stiffness: 1e8 N/m^3, damping: 2 s/m, friction: 0.3, slip_speed: 1 cm/s}\n"
    "  - {bodies: [ball, hand], stiffness: 1e8 N/m^3, damping: 2 s/m, friction: 0.3, slip_speed: 1 cm/s}\n";

// The hand in a closed loop, beside the arm's open-loop controls. It sees points that move with the meshes, and the
// ball from the hand.
constexpr char kSeen[] = R"(signals:
  - {name: arm_angle, type: angle, joint: arm}
  - {name: hand_rate, type: rate, joint: hand}
  - {name: hand_z, type: position, body: hand, point: [20 mm, 0 mm, 4 mm], axis: z}
  - {name: ball_seen, type: position, body: ball, in: hand, axis: x}
  - {name: hand_speed, type: velocity, body: hand, point: [20 mm, 0 mm, 4 mm], axis: z}
  - {name: ball_tilt, type: direction, body: ball, of: x, in: hand, axis: z}
  - {name: ball_spin, type: angular_velocity, body: ball, axis: y}
  - {name: clock, type: time}
)";
constexpr char kControls[] = "controls: {actuators: [hand, arm], interval";
constexpr char kLoop[] = R"(policy:
  actuators: [hand]
  interval: 50 ms
  observations:
    - {signal: arm_angle, offset: 3 deg}
    - {signal: hand_rate, scale: 5 rad/s}
    - {signal: hand_z, scale: 2 cm}
    - {signal: ball_seen, scale: 2 cm}
    - {signal: hand_speed, scale: 50 cm/s}
    - {signal: ball_tilt}
    - {signal: ball_spin, offset: 5 rad/s, scale: 20 rad/s}
    - {signal: clock, offset: 0.1 s, scale: 0.1 s}
  hidden: [3]
  initial: {type: random}
  lower: -2
  upper: 2
controls: {actuators: [arm], interval)";

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

Files MakeFiles(bool touching, bool closed_loop = false) {
  std::string text = kArm;
  const std::string mark = "contacts:\nCONTACTS\n";
  text.replace(text.find(mark), mark.size(), touching ? "contacts:\n" + std::string(kTouching) : "");
  if (closed_loop) {
    text.replace(text.find(kControls), std::string(kControls).size(), kLoop);
    const std::string signals = "signals:\n";
    text.replace(text.find(signals), signals.size(), kSeen);
  }
  Files files{{kScenarioFileName, text}};
  for (const char* name : {"finger_phalanx", "finger_phalanx_cage", "finger_tip", "finger_tip_cage"}) {
    const std::string path = std::string("meshes/") + name + ".obj";
    files[path] = ReadFile(std::string(KNAP_CONFIGS "/") + path);
  }
  return files;
}

const VectorXd kTheta = (VectorXd(4) << 0.028, 1.2, 0.9, 1.3).finished();

TEST(SceneDesign, WhatHangsOnABodyMovesWithItsMesh) {
  const Files files = MakeFiles(true);
  Scene scene = ParseScenarioFiles(files);
  const SceneDesign design(scene, files);
  const Vector3d before = std::get<DistanceSignal>(scene.signals[2].kind).point;
  design.MoveAttachments(kTheta, &scene);
  // The arm's end has moved by 4.6 mm, and with it the joint, 1.6 mm beyond it; the ball hangs on nothing.
  EXPECT_LT((scene.bodies[2].joint.position - Vector3d(0.0296, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_EQ(scene.bodies[1].joint.position, Vector3d::Zero());
  const Vector3d after = std::get<DistanceSignal>(scene.signals[2].kind).point;
  // Near the end of the hand, whose length grows by 30% and whose height shrinks by 10% there.
  EXPECT_NEAR(after.x() - before.x(), 0.3 * before.x(), 1e-12);
  EXPECT_LT(after.z(), before.z());
  EXPECT_EQ(std::get<DistanceSignal>(scene.signals[3].kind).point, Vector3d::Zero());
}

TEST(SceneDesign, MassAndInertiaAreThoseOfTheMesh) {
  const Files files = MakeFiles(true);
  const Scene scene = ParseScenarioFiles(files);
  const SceneDesign design(scene, files);
  const DesignedShapes shapes = design.CalcShapes(kTheta);
  const SceneModel model = BuildModel(scene, shapes);
  for (const char* name : {"arm", "hand"}) {
    const MassProperties expected = CalcMassProperties(design.Find(name)->CalcMesh(kTheta), 1000.0);
    const Matrix6d& M = model.tree.bodies()[static_cast<std::size_t>(model.body_index.at(name))].M;
    EXPECT_NEAR(M(3, 3), expected.mass, 1e-14);
    EXPECT_LT((M.topLeftCorner<3, 3>() - expected.inertia).norm(), 1e-12 * expected.inertia.norm());
    EXPECT_NEAR(M(1, 3), expected.first_moment.z(), 1e-16);
    EXPECT_NEAR(M(2, 4), expected.first_moment.x(), 1e-14);
    EXPECT_NE(shapes.at(name).contact.mesh != nullptr, std::string(name) == "arm");  // nothing touches the arm
  }
}

TEST(SceneDesign, JointsHaveTheLawsOfTheFile) {
  const Files files = MakeFiles(false);
  const Scene scene = ParseScenarioFiles(files);
  const SceneModel model = BuildModel(scene, SceneDesign(scene, files).CalcShapes(kTheta));
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  const JointLaw& law = model.tree.bodies()[static_cast<std::size_t>(model.body_index.at("arm"))].law;
  EXPECT_EQ(law.damping, 1e-4);
  EXPECT_EQ(law.stiffness, 2e-3);
  EXPECT_NEAR(law.rest(0), 5.0 * kDegree, 1e-15);
  EXPECT_NEAR(law.limit.lower, -40.0 * kDegree, 1e-15);
  EXPECT_EQ(law.limit.stiffness, 0.5);
  EXPECT_EQ(law.limit.damping, 0.2);
  EXPECT_NEAR(law.limit.width, 10.0 * kDegree, 1e-15);
  ASSERT_EQ(model.tree.num_controls(), 2);
  const Actuator& position = model.tree.actuators()[0];
  EXPECT_EQ(position.kind, ActuatorKind::kPosition);
  EXPECT_EQ(position.body, model.body_index.at("arm"));
  EXPECT_EQ(position.stiffness, 3e-3);
  // Commands of hand and arm; the arm's stand for targets from −20 to 30 degrees.
  const Eigen::MatrixXd u = (Eigen::MatrixXd(2, 1) << 0.5, -1.0).finished();
  const ControlSequence sequence = MakeControlSequence(scene, model, u);
  EXPECT_NEAR(sequence.values(0, 0), -20.0 * kDegree, 1e-15);
  EXPECT_EQ(sequence.values(1, 0), 0.5);
  EXPECT_EQ(sequence.steps_per_interval, 50);
  // Undriven, a position actuator holds the middle of its range.
  Scene undriven = scene;
  undriven.controls.reset();
  EXPECT_NEAR(MakeControlSequence(undriven, model, {}).values(0, 0), 5.0 * kDegree, 1e-15);
}

struct ArmCase {
  const char* name;
  bool touching, closed_loop;
};

class ArmGradient : public testing::TestWithParam<ArmCase> {};

TEST_P(ArmGradient, IsThatOfDifferences) {
  const bool touching = GetParam().touching;
  RolloutModel model(MakeFiles(touching, GetParam().closed_loop));
  const int n = model.num_controls();
  ASSERT_EQ(n, GetParam().closed_loop ? 4 + 31 : 8);
  VectorXd a(n);
  a.head(8) << 0.5, -0.3, 0.7, 0.2, -0.6, 0.4, 0.9, -0.8;
  for (Eigen::Index i = 8; i < n; ++i) a(i) = std::sin(2.0 + 1.9 * static_cast<double>(i));
  const auto run = [&](const VectorXd& x, bool gradient) {
    RolloutInput input;
    input.theta = x.head(4);
    input.controls = x.tail(n);
    input.want_gradient = gradient;
    return model.Run(input, {});
  };
  VectorXd x(4 + n), g(4 + n);
  x << kTheta, a;
  const RolloutOutput out = run(x, true);
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_EQ(out.certificate.contact_onsets > 2, touching);
  g << out.gradient, out.control_gradient;
  // In parts of each parameter's range.
  VectorXd range = VectorXd::Constant(4 + n, 4.0);
  range(0) = 0.025;
  range.segment<3>(1).setConstant(1.5);
  g.array() *= range.array();
  double worst = 0.0;
  for (Eigen::Index i = 0; i < 4 + n; ++i) {
    EXPECT_NE(g(i), 0.0) << i;
    // Curvature asks for small steps, rounding for large ones; no one step suits all, but one has to.
    double best = 1e300;
    for (const double h : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
      const auto evaluate = [&](const VectorXd& at) { return run(at, false).loss; };
      best = std::min(best, std::abs(test::CalcDifference(evaluate, x, i, h * range(i)) * range(i) - g(i)));
    }
    worst = std::max(worst, best);
  }
  EXPECT_LE(worst, (touching ? 1e-5 : 1e-7) * g.lpNorm<Eigen::Infinity>());
}

constexpr ArmCase kArmCases[] = {{"InAir", false, false},
                                 {"InContact", true, false},
                                 {"InAirUnderAPolicy", false, true},
                                 {"InContactUnderAPolicy", true, true}};
INSTANTIATE_TEST_SUITE_P(OpenAndClosedLoop, ArmGradient, testing::ValuesIn(kArmCases),
                         [](const auto& at) { return at.param.name; });

// ---- Pushing's bar
// ---------------------------------------------------------------------------------------------------

SceneDesign MakePusher(const std::vector<std::string>& overrides = {}) {
  const LoadedScenario scenario = LoadScenario(std::string(KNAP_CONFIGS) + "/pushing.yaml", overrides);
  EXPECT_TRUE(scenario.parsed.ok()) << scenario.parsed.FormatErrors();
  return SceneDesign(scenario.parsed.scene, scenario.files);
}

// Volume, extents and thickness of the bent bar, in all seven parameters, to seven digits.
TEST(PusherShape, MeasuresHaveTheirGradientsInTheta) {
  const SceneDesign design = MakePusher();
  const CageDesign& cage = *design.Find("pusher");
  std::vector<std::function<ShapeMeasure(const TriangleMesh&)>> measures = {MeasureVolume};
  for (int k = 0; k < 3; ++k) measures.emplace_back([k](const TriangleMesh& m) { return MeasureExtent(m, k); });
  for (const double blend : {0.2e-3, 1e-3}) {
    measures.emplace_back([blend](const TriangleMesh& m) { return MeasureThickness(m, blend); });
  }
  const std::vector<VectorXd> thetas = {
      (VectorXd(7) << 0.0413, 0.0276, 0.0312, 0.0121, 0.0263, 0.0031, -0.0017).finished(),
      (VectorXd(7) << 0.0371, 0.0291, 0.0237, -0.0083, 0.0187, -0.0024, 0.0038).finished()};
  for (const VectorXd& theta : thetas) {
    for (std::size_t m = 0; m < measures.size(); ++m) {
      const VectorXd gradient = cage.PullBack(measures[m](cage.CalcMesh(theta)).gradient);
      const double largest = gradient.lpNorm<Eigen::Infinity>();
      // The bar is as high everywhere, whatever its parameters.
      EXPECT_EQ(largest > 1e-12, m != 3) << m;
      const auto evaluate = [&](const VectorXd& at) { return measures[m](cage.CalcMesh(at)).value; };
      // Small steps for the thickness, whose slope jumps where a ray comes to another triangle.
      for (Eigen::Index i = 0; i < 7; ++i) {
        EXPECT_NEAR(gradient(i), test::CalcDifference(evaluate, theta, i, m < 4 ? 1e-5 : 1e-7), 1e-7 * largest + 1e-12)
            << m << " " << i;
      }
    }
  }
}

TEST(PusherShape, GroupsByBoxAndPlaneAreThoseByNumber) {
  const SceneDesign by_number = MakePusher();
  const SceneDesign chosen = MakePusher(
      {"design.bodies.pusher.vertex_groups.left_tip.vertices=[]",
       "design.bodies.pusher.vertex_groups.left_tip.box={lower: [-53 mm, -13 mm, -1 mm], upper: [-53 mm, 1 mm, 21 mm]}",
       "design.bodies.pusher.vertex_groups.right_tip.vertices=[]",
       "design.bodies.pusher.vertex_groups.right_tip.plane={point: [53 mm, 0 mm, 0 mm], normal: [2, 0, 0]}"});
  EXPECT_EQ(by_number.Find("pusher")->dc_dtheta(), chosen.Find("pusher")->dc_dtheta());
}

}  // namespace scene_design_test
}  // namespace knap
