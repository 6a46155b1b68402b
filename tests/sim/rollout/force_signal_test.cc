// The force of a contact as a signal: against the spring behind what is pressed, and its gradient in design and
// controls against differences, with friction that sticks and slips, damping, and either kind of steps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/box_mesh.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace force_signal_test {

using Eigen::VectorXd;

// A designed block is driven along x onto a button on a spring, and its upper side slides along a slanting wall.
constexpr char kPress[] = R"(schema: 2
name: press
gravity: [0 m/s^2, 0 m/s^2, 0 m/s^2]
bodies:
  - name: tool
    joint: {type: prismatic, axis: [1, 0, 0], damping: 2 N*s/m, actuator: {type: force, limit: 4 N}}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 3 g/cm^3}
  - name: button
    joint: {type: prismatic, axis: [1, 0, 0], position: [26 mm, 2 mm, 9 mm], stiffness: 400 N/m, damping: 1 N*s/m}
    shapes: [{type: sphere, radius: 6 mm}]
    inertia: {type: solid, mass: 10 g}
  - name: wall
    joint: {type: fixed, position: [0 mm, 0 mm, 20.5 mm], orientation_rpy: [0 deg, 182 deg, 0 deg]}
    shapes: [{type: half_space}]
contacts:
  - {bodies: [tool, button], stiffness: 3e7 N/m^3, damping: 2 s/m, friction: 0.4, stick_distance: 50 um}
  - {bodies: [wall, tool], stiffness: 2e6 N/m^3, damping: 1 s/m, friction: 0.2, stick_distance: 200 um}
controls: {actuators: [tool], interval: 80 ms, initial: 0.3}
signals:
  - {name: press, type: force, bodies: [button, tool]}
  - {name: rub, type: force, bodies: [tool, wall]}
  - {name: way, type: displacement, joint: button}
  - {name: speed, type: speed, joint: button}
)";

RolloutModel MakePress(const std::string& rest) {
  return RolloutModel({{kScenarioFileName, std::string(kPress) + test::kBoxDesign + rest},
                       {"box.obj", test::MakeBoxObj(-20, 20, -10, 10, 0, 20)},
                       {"cage.obj", test::MakeBoxObj(-21, 21, -11, 11, -1, 21)}});
}

class ForceSignals : public testing::TestWithParam<const char*> {};

TEST_P(ForceSignals, HasItsGradient) {
  for (const char* term :
       {"{signals: [press]}", "{signals: [rub], shape: absolute}",
        "{signals: [press, rub], when: {type: samples, every: 40 ms}}",
        "{signals: [press], when: {type: samples, every: 8 ms, reduce: largest}, scale: 0.1 N, shape: log}",
        "{signals: [press], when: {type: at, time: 80 ms}, target: {type: number, value: 0.5 N}, side: above}"}) {
    RolloutModel model =
        MakePress(fmt::format("loss: {{task: [{}]}}\nrollout: {{horizon: 240 ms, step: 4 ms, {}, "
                              "newton_tolerance: 1e-13}}\n",
                              term, GetParam()));
    VectorXd x(model.num_parameters() + model.num_controls());
    x << 0.0409, 0.5, 0.35, 0.2;
    const auto make = [&](const VectorXd& at) {
      RolloutInput input;
      input.theta = at.head(1);
      input.controls = at.tail(model.num_controls());
      return input;
    };
    const RolloutOutput out = model.Run(make(x), {});
    ASSERT_TRUE(out.certificate.converged && out.certificate.finite) << term;
    EXPECT_GT(out.loss, 1e-4) << term;
    VectorXd gradient(x.size());
    gradient << out.gradient, out.control_gradient;
    const auto evaluate = [&](const VectorXd& at) {
      RolloutInput input = make(at);
      input.want_gradient = false;
      input.theta_nodes = make(x).theta;
      input.controls_nodes = make(x).controls;
      return model.Run(input, {}).loss;
    };
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double range = i == 0 ? 0.02 : 1.0;
      const double difference = range * test::CalcDifference(evaluate, x, i, i == 0 ? 1e-6 : 1e-4);
      EXPECT_NEAR(range * gradient(i), difference, 1e-7 + 3e-6 * (range * gradient).lpNorm<Eigen::Infinity>())
          << term << " entry " << i;
    }
    EXPECT_GT(gradient.head(2).cwiseAbs().minCoeff(), 0.0) << term;
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, ForceSignals,
                         testing::Values("integrator: bdf1", "integrator: bdf2", "integrator: tr_bdf2"),
                         [](const auto& the_case) { return std::string(the_case.param).substr(12); });

// At rest the spring bears the whole of what presses along x; friction at the wall does not.
TEST(ForceSignalAtRest, IsWhatTheSpringBears) {
  RolloutModel model = MakePress("rollout: {horizon: 2 s, step: 4 ms}\n");
  RolloutInput input;
  input.theta = model.initial_theta();
  input.controls = VectorXd::Constant(model.num_controls(), 0.3);
  const Recording recording = model.Record(input, 2.0).recording;
  const auto last = [&](const std::string& name) {
    for (const Recording::Signal& signal : recording.signals) {
      if (signal.name == name) return signal.values.back();
    }
    return -1.0;
  };
  EXPECT_LT(std::abs(last("speed")), 1e-6);
  EXPECT_GT(last("press"), 0.3);
  EXPECT_NEAR(last("press"), 400.0 * last("way"), 1e-4);
}

}  // namespace force_signal_test
}  // namespace knap
