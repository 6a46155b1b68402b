// What a section `perturbation` makes of a scene: factors, moved starts, another pace, and gradients that follow.
#include "sim/rollout/perturb_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "sim/multibody/dynamics.h"
#include "sim/rollout/build_body.h"
#include "sim/rollout/known_numbers.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace perturb_scene_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

// A tilted world: gravity has no coordinate that is zero.
Scene MakeScene(const std::string& perturbation, const std::string& rope) {
  const std::string text = fmt::format(R"(schema: 2
name: perturbed
gravity: [2 m/s^2, -3 m/s^2, -6 m/s^2]
bodies:
  - name: arm
    joint:
      type: prescribed
      motion:
        type: constant_velocity
        velocity: [100 mm/s, 0 mm/s, 0 mm/s]
        angular_velocity: [0 rad/s, 0 rad/s, 2 rad/s]
    shapes: [{{type: box, size: [10 mm, 10 mm, 10 mm]}}]
  - name: block
    joint: {{type: free, orientation_rpy: [30 deg, 20 deg, 10 deg]}}
    shapes: [{{type: box, size: [10 mm, 20 mm, 30 mm]}}]
    inertia: {{type: density, density: 1000 kg/m^3}}
    initial: {{position: [1 mm, 2 mm, 300 mm], orientation_rpy: [0.1 rad, 0.2 rad, 0.3 rad]}}
ropes:
  - {{name: rope, links: 4, pitch: 30 mm, thickness: 5 mm, link_mass: 1 g, initial: {}}}
contacts:
  - {{bodies: [block, arm], stiffness: 1e7 N/m^3, friction: 0.4}}
grips:
  - {{body: arm, held: rope, held_point: [0 mm, 0 mm, 0 mm], stiffness: 10 N/m, from: 0.1 s, until: 0.6 s}}
signals:
  - {{name: x, type: position, body: block, axis: x}}
  - {{name: drift, type: drift, of: [rope], since: 0.2 s}}
loss:
  task:
    - {{signals: [x], when: {{type: samples, every: 20 ms, until: 0.8 s}}, scale: 1 m}}
success: {{type: within, signals: [x], above: 0 m, when: {{type: lasting, duration: 100 ms, from: 0.5 s}}}}
rollout: {{horizon: 1 s, step: 10 ms}}
{})",
                                       rope, perturbation);
  return ParseScenarioFiles({{kScenarioFileName, text}});
}

constexpr const char* kHelix = "{type: helix, links_per_side: 1, advance: 4 mm}";
constexpr const char* kStraight = "{type: straight, start: [1 mm, 2 mm, 3 mm], direction: [1, 2, 0]}";

Scene Perturb(const std::string& perturbation, const std::string& rope = kStraight) {
  Scene scene = MakeScene("perturbation: " + perturbation, rope);
  PerturbScene(&scene);
  return scene;
}

TEST(PerturbScene, ScalesFrictionAndMasses) {
  const Scene scene = Perturb("{friction: 0.8, mass: 1.25}");
  EXPECT_DOUBLE_EQ(scene.contacts[0].friction, 0.32);
  const SceneModel model = BuildModel(scene, {});
  EXPECT_NEAR(model.tree.bodies()[static_cast<std::size_t>(model.body_index.at("block"))].M(3, 3), 1.25 * 6e-3, 1e-15);
  EXPECT_NEAR(model.tree.bodies().back().M(3, 3), 1.25e-3, 1e-15);
}

TEST(PerturbScene, PlaysTheWholeSceneFaster) {
  const double s = 1.25;
  const Scene plain = MakeScene("", kStraight);
  const Scene scene = Perturb("{speed: 1.25}");
  EXPECT_DOUBLE_EQ(scene.rollout.horizon, 1.0 / s);
  EXPECT_DOUBLE_EQ(scene.rollout.step, 0.01 / s);
  EXPECT_DOUBLE_EQ(scene.grips[0].from, 0.1 / s);
  EXPECT_DOUBLE_EQ(scene.grips[0].until, 0.6 / s);
  EXPECT_DOUBLE_EQ(std::get<DriftSignal>(scene.signals[1].kind).since, 0.2 / s);
  EXPECT_DOUBLE_EQ(std::get<OverSamples>(scene.loss.task[0].when).until, 0.8 / s);
  const auto& lasting = std::get<Lasting>(std::get<Within>(scene.success->kind).when);
  EXPECT_DOUBLE_EQ(lasting.duration, 0.1 / s);
  EXPECT_DOUBLE_EQ(lasting.from, 0.5 / s);
  // Where the motion is at a time, it is at t/s, s times as fast, and its derivatives fit differences.
  const SceneModel slow = BuildModel(plain, {}), fast = BuildModel(scene, {});
  const PrescribedMotion& at_rest = slow.tree.bodies()[0].motion;
  const PrescribedMotion& motion = fast.tree.bodies()[0].motion;
  const double t = 0.3, h = 1e-4;
  EXPECT_LT((motion(t / s).X_FB.p - at_rest(t).X_FB.p).norm(), 1e-15);
  EXPECT_LT((motion(t / s).V - s * at_rest(t).V).norm(), 1e-15);
  EXPECT_LT(((motion(t + h).V - motion(t - h).V) / (2.0 * h) - motion(t).A).norm(), 1e-6);
  EXPECT_LT(((motion(t + h).A - motion(t - h).A) / (2.0 * h) - motion(t).jerk).norm(), 1e-6);
}

TEST(PerturbScene, MovesABodyOnTheLevelAndTurnsItAboutTheVertical) {
  const Scene before = MakeScene("", kStraight);
  const Scene after = Perturb("{starts: [{name: block, along: 2 mm, across: -1 mm, turn: 2 deg}]}");
  const auto place = [](const Scene& scene) {
    const SceneModel model = BuildModel(scene, {});
    Dynamics dynamics(model.tree);
    dynamics.CalcKinematics(model.q0, model.v0, model.v0, 0.0);
    return dynamics.kinematics()[static_cast<std::size_t>(model.body_index.at("block"))].X_WB;
  };
  const Pose a = place(before), b = place(after);
  const Vector3d up = Vector3d(-2.0, 3.0, 6.0).normalized();
  EXPECT_NEAR((b.p - a.p).dot(up), 0.0, 1e-15);
  EXPECT_NEAR((b.p - a.p).norm(), std::sqrt(5.0) * 1e-3, 1e-15);
  EXPECT_GT((b.p - a.p).x(), 0.0);
  const Eigen::AngleAxisd turn(Matrix3d(b.R * a.R.transpose()));
  EXPECT_NEAR(turn.angle(), 2.0 * kDegree, 1e-12);
  EXPECT_LT((turn.axis() - up).norm(), 1e-9);
}

TEST(PerturbScene, MovesRopesWhereNothingIsInTheirWay) {
  const Scene straight = Perturb("{starts: [{name: rope, along: 2 mm, across: 1 mm, turn: 2 deg}]}");
  const auto& state = std::get<StraightState>(straight.ropes[0].initial);
  EXPECT_NEAR(state.start.z(), 3e-3, 1e-15);  // its links' z axis is the world's
  EXPECT_NEAR((state.start - Vector3d(1e-3, 2e-3, 3e-3)).norm(), std::sqrt(5.0) * 1e-3, 1e-15);
  EXPECT_NEAR(state.direction.normalized().dot(Vector3d(1.0, 2.0, 0.0).normalized()), std::cos(2.0 * kDegree), 1e-12);
  const auto list_joints = [](const Scene& scene) {
    const SceneModel model = BuildModel(scene, {});
    Dynamics dynamics(model.tree);
    dynamics.CalcKinematics(model.q0, model.v0, model.v0, 0.0);
    std::vector<Vector3d> joints;
    for (const int link : model.links.at("rope")) {
      joints.push_back(dynamics.kinematics()[static_cast<std::size_t>(link)].X_WB.p);
    }
    return joints;
  };
  const std::vector<Vector3d> before = list_joints(MakeScene("", kHelix));
  const std::vector<Vector3d> after =
      list_joints(Perturb("{starts: [{name: rope, along: 2 mm, turn: 2 deg}]}", kHelix));
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vector3d expected =
        Eigen::AngleAxisd(2.0 * kDegree, Vector3d::UnitX()) * before[i] + Vector3d(2e-3, 0.0, 0.0);
    EXPECT_LT((after[i] - expected).norm(), 1e-15) << i;
  }
}

TEST(PerturbScene, RollPitchAndYawComeBack) {
  for (int i = 0; i < 50; ++i) {
    const Vector3d rpy(3.0 * std::sin(1.0 + i), 1.5 * std::sin(2.0 + 3.0 * i), 3.0 * std::cos(5.0 * i));
    EXPECT_LT((CalcRpy(RotationFromRpy(rpy)) - rpy).norm(), 1e-9) << i;
  }
}

TEST(PerturbScene, RefusesAHelixAcrossAndWhatIsNotFree) {
  EXPECT_THROW(Perturb("{starts: [{name: rope, across: 1 mm}]}", kHelix), std::runtime_error);
  EXPECT_THROW(Perturb("{starts: [{name: arm, along: 1 mm}]}"), std::runtime_error);
  EXPECT_THROW(Perturb("{starts: [{name: block}, {name: block}]}"), std::runtime_error);
}

// The known rollout at another pace, friction and mass: its gradient is that of what is simulated.
TEST(PerturbScene, GradientsFollow) {
  std::map<std::string, std::string> files = MakeKnownScenario();
  std::string& text = files.at(kScenarioFileName);
  text +=
      "perturbation: {friction: 0.8, mass: 1.2, speed: 1.2, starts: [{name: pea, along: 1 mm, across: 1 mm, turn: 2 "
      "deg}]}\n";
  RolloutModel model(files), plain(MakeKnownScenario());
  RolloutInput input;
  input.theta = model.initial_theta();
  input.variation = {0.002};
  const RolloutOutput out = model.Run(input, {});
  ASSERT_TRUE(out.certificate.converged);
  EXPECT_NE(out.loss, plain.Run(input, {}).loss);
  ASSERT_GT(out.gradient.norm(), 0.0);
  RolloutInput beside = input;
  beside.want_gradient = false;
  beside.theta_nodes = input.theta;
  for (int i = 0; i < 2; ++i) {
    const double h = 1e-6;
    beside.theta = input.theta;
    beside.theta(i) += h;
    const double more = model.Run(beside, {}).loss;
    beside.theta(i) -= 2.0 * h;
    const double less = model.Run(beside, {}).loss;
    EXPECT_NEAR((more - less) / (2.0 * h), out.gradient(i), 1e-4 * out.gradient.lpNorm<Eigen::Infinity>()) << i;
  }
}

}  // namespace perturb_scene_test
}  // namespace knap
