// Terms of losses: crossings of a ballistic path against their closed form, what they cost, sums over samples, and for
// every kind of signal, moment, shape, side and target the gradient in design and controls against differences.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/box_mesh.h"
#include "tests/sim/rollout/differences.h"

namespace knap {
namespace loss_terms_test {

using Eigen::VectorXd;

// A ball thrown from (x, 100, 300) mm with (50, vy, 200) mm/s; nothing touches it.
RolloutModel MakeThrow(const std::string& loss, double x_mm, double vy_mm, double horizon_s, const std::string& step) {
  const std::string text = fmt::format(
      R"(schema: 2
name: throw
bodies:
  - name: ball
    joint: {{type: free}}
    shapes: [{{type: sphere, radius: 7 mm}}]
    inertia: {{type: solid, mass: 2 g}}
    initial: {{position: [{} mm, 100 mm, 300 mm], velocity: [50 mm/s, {} mm/s, 200 mm/s]}}
signals:
  - {{name: x, type: position, body: ball, axis: x}}
  - {{name: y, type: position, body: ball, axis: y}}
  - {{name: z, type: position, body: ball, axis: z}}
rollout: {{horizon: {} s, step: {}, newton_tolerance: 1e-14}}
loss: {{task: [{}]}}
)",
      x_mm, vy_mm, horizon_s, step, loss);
  return RolloutModel({{kScenarioFileName, text}});
}

double Evaluate(RolloutModel model) { return model.Run({}, {}).loss; }

// A cubic through position and velocity is exact on a ballistic path, whatever the step, and so is TR-BDF2 but for its
// first step.
TEST(Crossing, OfABallisticPathIsExact) {
  for (const auto& [step, h] : {std::pair{"50 ms", 0.05}, {"10 ms", 0.01}, {"1 ms", 1e-3}}) {
    // Up through z = 301 mm at 0.2 t - g t²/2 = 1 mm, the first of two passages.
    const double up = (0.2 - std::sqrt(0.04 - 2.0 * 9.81 * 1e-3)) / 9.81;
    const std::string at = "{signals: [x], when: {type: crossing, signal: z, at: 301 mm}, shape: absolute}";
    EXPECT_NEAR(Evaluate(MakeThrow(at, 10.0, 400.0, 0.8, step)), 0.01 + 0.05 * up, 3e-5 * h * h) << step;
    const std::string y = "{signals: [y], when: {type: crossing, signal: z, at: 0 mm}, shape: absolute}";
    const double down = (0.2 + std::sqrt(0.04 + 2.0 * 9.81 * 0.3)) / 9.81;
    EXPECT_NEAR(Evaluate(MakeThrow(y, 10.0, 400.0, 0.8, step)), 0.1 + 0.4 * down, 3e-5 * h * h) << step;
  }
}

TEST(Crossing, CostsTheDistanceBeyondTheMargin) {
  const std::string term =
      "{signals: [x], when: {type: crossing, signal: y, at: 370 mm}, target: {type: number, value: 4 mm}, "
      "margin: 20 mm, scale: 100 mm, weight: 2}";
  for (const double x : {-50.0, -17.0, -15.0, 0.0, 23.0, 25.0, 60.0}) {
    // The plane is crossed at 0.54 s, 27 mm further along x; the margin reaches from −16 to 24 mm.
    const double there = 1e-3 * x + 27e-3;
    const double beyond = std::max(0.0, std::abs(there - 4e-3) - 20e-3);
    EXPECT_NEAR(Evaluate(MakeThrow(term, x, 500.0, 0.8, "10 ms")), 200.0 * beyond * beyond, 1e-9) << x;
  }
}

TEST(Crossing, AShortfallIsQuadraticAtFirstAndLevelsOff) {
  const auto evaluate = [](double missing) {
    const std::string term = fmt::format(
        "{{signals: [x], when: {{type: crossing, signal: y, at: {} mm, never_cost: 7, never_scale: 50 mm}}, "
        "margin: 1 m}}",
        1e3 * (0.2 + missing));
    return Evaluate(MakeThrow(term, 0.0, 500.0, 0.2, "10 ms"));
  };
  EXPECT_NEAR(evaluate(1e-4), 7.0 * 1e-8 / 2.5e-3, 1e-4 * 7.0 * 1e-8 / 2.5e-3);
  EXPECT_NEAR(evaluate(50.0), 7.0, 1e-5);
  double previous = 0.0;
  for (const double missing : {1e-3, 0.01, 0.05, 0.2, 1.0}) {
    EXPECT_GT(evaluate(missing), previous);
    previous = evaluate(missing);
  }
}

TEST(Samples, DoNotDependOnTheStep) {
  // x = 0.05 t at 0.02 … 0.8 s, in centimetres.
  const double sum = 25.0 * 0.02 * 0.02 * 40.0 * 41.0 * 81.0 / 6.0;
  const std::map<std::string, double> expected = {
      {"sum", sum}, {"mean", sum / 40.0}, {"largest", 25.0 * 0.8 * 0.8}, {"least", 25.0 * 0.02 * 0.02}};
  for (const auto& [reduce, value] : expected) {
    const std::string term =
        fmt::format("{{signals: [x], when: {{type: samples, every: 20 ms, reduce: {}}}, scale: 1 cm}}", reduce);
    for (const char* step : {"20 ms", "5 ms", "1 ms"}) {
      EXPECT_NEAR(Evaluate(MakeThrow(term, 0.0, 400.0, 0.8, step)), value, 1e-8 * value) << reduce << step;
    }
  }
}

TEST(Terms, HaveTheirShapesSidesAndTargets) {
  const auto evaluate = [](const std::string& rest) {
    return Evaluate(MakeThrow("{signals: [x], scale: 10 mm, " + rest + "}", 0.0, 0.0, 0.8, "20 ms"));
  };
  // x = 40 mm at the end, 20 mm at 0.4 s.
  EXPECT_NEAR(evaluate("shape: square"), 16.0, 1e-8);
  EXPECT_NEAR(evaluate("shape: absolute, margin: 5 mm"), 3.5, 1e-8);
  EXPECT_NEAR(evaluate("shape: log"), std::log(17.0), 1e-8);
  EXPECT_NEAR(evaluate("shape: saturating"), 16.0 / 17.0, 1e-8);
  EXPECT_NEAR(evaluate("when: {type: at, time: 400 ms}"), 4.0, 1e-8);
  EXPECT_NEAR(evaluate("target: {type: number, value: 50 mm}"), 1.0, 1e-8);
  EXPECT_EQ(evaluate("target: {type: number, value: 50 mm}, side: above"), 0.0);
  EXPECT_NEAR(evaluate("target: {type: number, value: 50 mm}, side: below, weight: 3"), 3.0, 1e-8);
  EXPECT_NEAR(evaluate("target: {type: signal, signal: y}"), 36.0, 1e-8);
  // The sample at the very time of a change belongs to what was before.
  const std::string schedule = "target: {type: schedule, values: [{value: 10 mm}, {after: 400 ms, value: 40 mm}]}";
  EXPECT_NEAR(evaluate(schedule), 0.0, 1e-20);
  EXPECT_NEAR(evaluate("when: {type: at, time: 400 ms}, " + schedule), 1.0, 1e-8);
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

// A slider along x carries a hinge, which carries a designed box; both are driven. A ball flies by, and a rope falls.
constexpr char kArm[] = R"(schema: 2
name: arm
gravity: [1 m/s^2, 0 m/s^2, -9.81 m/s^2]
bodies:
  - name: slider
    joint: {type: prismatic, axis: [1, 0, 0], damping: 3 N*s/m, stiffness: 4 N/m,
            actuator: {type: force, limit: 2 N}}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 100 g}
    initial: {speed: 100 mm/s}
  - name: tool
    parent: slider
    joint: {type: revolute, axis: [0, 1, 0], damping: 1e-3 N*m*s/rad, actuator: {type: force, limit: 0.05 N*m}}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 2 g/cm^3}
    initial: {angle: 20 deg, rate: 1 rad/s}
  - name: ball
    joint: {type: free}
    shapes: [{type: sphere, radius: 7 mm}]
    inertia: {type: solid, mass: 2 g}
    initial: {position: [50 mm, 100 mm, 30 mm], velocity: [100 mm/s, -200 mm/s, 700 mm/s]}
  - name: weight
    parent: tool
    joint: {type: fixed, position: [10 mm, 0 mm, 0 mm], attachment: {point: [20 mm, 0 mm, 0 mm]}}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 10 g}
  - name: floor
    joint: {type: fixed, position: [0 mm, 0 mm, 60 mm], orientation_rpy: [7 deg, 5 deg, 0 deg]}
    shapes: [{type: half_space}]
  - name: bubble
    joint: {type: fixed, position: [40 mm, 15 mm, 20 mm]}
    shapes: [{type: sphere, radius: 60 mm}]
contacts:  # too soft to be felt
  - {bodies: [tool, floor], stiffness: 1e-3 N/m^3}
  - {bodies: [tool, bubble], stiffness: 1e-3 N/m^3}
ropes:
  - {name: cord, links: 2, pitch: 20 mm, thickness: 4 mm, link_mass: 1 g,
     initial: {type: straight, start: [0 mm, 50 mm, 0 mm], direction: [1, 2, 0]}}
controls: {actuators: [slider, tool], interval: 80 ms, initial: 0.3}
rollout: {horizon: 160 ms, step: 4 ms, integrator: bdf2, newton_tolerance: 1e-13}
signals:
  - {name: way, type: displacement, joint: slider}
  - {name: speed, type: speed, joint: slider}
  - {name: angle, type: angle, joint: tool}
  - {name: rate, type: rate, joint: tool}
  - {name: tip_x, type: position, body: tool, point: [20 mm, 1 mm, 5 mm], axis: x}
  - {name: tip_z, type: position, body: tool, point: [20 mm, 1 mm, 5 mm], axis: z}
  - {name: ball_in_tool, type: position, body: ball, in: tool, axis: z}
  - {name: tip_speed, type: velocity, body: tool, point: [20 mm, 1 mm, 5 mm], axis: z}
  - {name: tilt, type: direction, body: tool, of: x, axis: z}
  - {name: tilt_in_ball, type: direction, body: tool, of: x, in: ball, axis: z}
  - {name: spin, type: angular_velocity, body: tool, axis: y}
  - name: miss
    type: distance
    body: tool
    point: [20 mm, 1 mm, 5 mm]
    in: slider
    targets: [{position: [0 mm, 10 mm, 0 mm]}, {after: 80 ms, position: [5 mm, 10 mm, 20 mm]}]
  - {name: centre, type: center_of_mass, of: [weight, slider, cord], axis: x}
  - {name: centre_in_tool, type: center_of_mass, of: [weight, ball], in: tool, axis: z}
  - {name: height, type: height, of: [weight, slider]}
  - {name: drift, type: drift, of: [weight, ball], carried_by: tool, since: 40 ms}
  - {name: rise, type: drift, of: [weight, cord]}
  - {name: u, type: command, actuator: tool}
  - {name: now, type: time}
  - {name: mass, type: number, key: "bodies.ball.inertia.mass"}
  - {name: gap, type: difference, of: [tip_x, centre]}
  - {name: size, type: norm, of: [tip_x, gap, miss]}
  - {name: least, type: least, of: [tip_x, tip_z, gap]}
  - {name: largest, type: largest, of: [tip_x, tip_z, gap]}
  - {name: ball_z, type: position, body: ball, axis: z}
  - {name: bulk, type: volume, body: tool}
  - {name: wide, type: extent, body: tool, axis: x}
  - {name: wall, type: thickness, body: tool, blend: 20 mm}
  - {name: sunk, type: depth, bodies: [floor, tool]}
  - {name: in_bubble, type: depth, bodies: [tool, bubble]}
)";

RolloutModel MakeArm(const std::string& loss) {
  return RolloutModel({{kScenarioFileName, std::string(kArm) + test::kBoxDesign + "loss: {" + loss + "}\n"},
                       {"box.obj", test::MakeBoxObj(-20, 20, -12, 0, 0, 20)},
                       {"cage.obj", test::MakeBoxObj(-21, 21, -13, 1, -1, 21)}});
}

// All parameters: theta, then controls.
RolloutInput MakeInput(const RolloutModel& model, const VectorXd& x, bool distils) {
  RolloutInput input;
  input.theta = x.head(model.num_parameters());
  input.controls = x.tail(model.num_controls());
  if (distils) {
    input.theta_reference = VectorXd::Constant(model.num_parameters(), 0.035);
    input.controls_reference = VectorXd::Constant(model.num_controls(), -0.2);
  }
  return input;
}

// Whether the gradient has an entry that is not zero.
bool ExpectGradient(const std::string& loss) {
  RolloutModel model = MakeArm(loss);
  const bool distils = loss.starts_with("distillation");
  VectorXd x(model.num_parameters() + model.num_controls());
  x << 0.043, VectorXd::LinSpaced(model.num_controls(), 0.4, -0.3);
  const RolloutOutput out = model.Run(MakeInput(model, x, distils), {});
  EXPECT_TRUE(out.certificate.converged && out.certificate.finite) << loss;
  VectorXd gradient(x.size());
  gradient << out.gradient, out.control_gradient;
  const double largest =
      std::max(0.02 * out.gradient.lpNorm<Eigen::Infinity>(), out.control_gradient.lpNorm<Eigen::Infinity>());
  const auto evaluate = [&](const VectorXd& at) {
    RolloutInput input = MakeInput(model, at, distils);
    input.want_gradient = false;
    return model.Run(input, {}).loss;
  };
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double h = i < model.num_parameters() ? 2e-5 : 1e-3;
    // Over a range.
    const double range = i < model.num_parameters() ? 0.02 : 1.0;
    EXPECT_NEAR(range * gradient(i), range * test::CalcDifference(evaluate, x, i, h), 1e-7 + 1e-6 * largest)
        << loss << " entry " << i;
  }
  return gradient.norm() > 0.0;
}

std::vector<std::string> ListSignals() {
  std::vector<std::string> names;
  const RolloutModel model = MakeArm("");
  for (const Signal& signal : model.scene().signals) names.push_back(signal.name);
  return names;
}

class EverySignal : public testing::TestWithParam<std::string> {};

TEST_P(EverySignal, HasItsGradientAtTheEndOverSamplesAndAtACrossing) {
  const std::string s = GetParam();
  const bool is_constant = s == "now" || s == "mass" || s == "ball_z";
  EXPECT_NE(ExpectGradient("task: [{signals: [" + s + "]}]"), is_constant);
  EXPECT_NE(ExpectGradient("task: [{signals: [" + s + "], when: {type: samples, every: 40 ms}, shape: log}]"),
            is_constant);
  // The ball crosses a plane whatever the tool does, and the tool a height of its own.
  EXPECT_NE(ExpectGradient("task: [{signals: [" + s + "], when: {type: crossing, signal: ball_z, at: 50 mm}}]"),
            is_constant);
  ExpectGradient("task: [{signals: [" + s + "], when: {type: crossing, signal: angle, at: 0.45 rad}}]");
}

INSTANTIATE_TEST_SUITE_P(All, EverySignal, testing::ValuesIn(ListSignals()),
                         [](const auto& the_case) { return the_case.param; });

// The rest of the loss is a constant of the rollout, so that differences are good to nine digits; the arm need not
// move.
TEST(ShapeSignals, HaveTheirGradientToSevenDigits) {
  for (const char* term :
       {"signals: [bulk], scale: 1 cm^3", "signals: [wide], scale: 1 mm", "signals: [wall], scale: 1 mm",
        "signals: [wall], scale: 1 mm, shape: log, side: below, "
        "target: {type: number, value: 40 mm}"}) {
    RolloutModel model = MakeArm(std::string("task: [{") + term + "}]");
    const auto evaluate = [&](const VectorXd& theta) {
      return model
          .Run(MakeInput(model,
                         (VectorXd(1 + model.num_controls()) << theta, VectorXd::Zero(model.num_controls())).finished(),
                         false),
               {})
          .loss;
    };
    for (const double width : {0.0352, 0.043, 0.0487}) {
      const VectorXd theta = VectorXd::Constant(1, width);
      VectorXd x(1 + model.num_controls());
      x << theta, VectorXd::Zero(model.num_controls());
      const RolloutOutput out = model.Run(MakeInput(model, x, false), {});
      EXPECT_TRUE(out.control_gradient.isZero(0.0));
      EXPECT_TRUE(out.gradient_reliable);
      EXPECT_GT(std::abs(out.gradient(0)), 1.0) << term;
      EXPECT_NEAR(out.gradient(0), test::CalcDifference(evaluate, theta, 0, 1e-5), 1e-7 * std::abs(out.gradient(0)))
          << term;
    }
  }
}

TEST(EveryKind, OfSignalIsAmongThem) {
  std::set<std::size_t> kinds;
  const RolloutModel model = MakeArm("");
  for (const Signal& signal : model.scene().signals) kinds.insert(signal.kind.index());
  // All but a contact's force: force_signal_test.cc.
  EXPECT_EQ(kinds.size(), std::variant_size_v<SignalKind> - 1);
}

TEST(EveryKind, OfTermHasItsGradient) {
  const std::vector<std::string> shapes = {"square", "absolute", "log", "saturating"};
  for (const std::string& shape : shapes) {
    const std::string term = "signals: [tip_x, tip_z], scale: 10 mm, shape: " + shape;
    EXPECT_TRUE(ExpectGradient("task: [{" + term + "}]"));
    EXPECT_TRUE(ExpectGradient("task: [{" + term + ", margin: 3 mm, weight: 2}]"));
    for (const char* when :
         {"{type: at, time: 120 ms}", "{type: samples, every: 20 ms, from: 40 ms, until: 120 ms}",
          "{type: samples, every: 40 ms, reduce: mean}", "{type: samples, every: 40 ms, reduce: largest}",
          "{type: samples, every: 40 ms, reduce: least}",
          // Never: by what is missing, on both sides.
          "{type: crossing, signal: tip_x, at: 200 mm, never_cost: 3, never_scale: 100 mm}",
          "{type: crossing, signal: tip_x, at: -200 mm, never_cost: 3, never_scale: 100 mm}"}) {
      EXPECT_TRUE(ExpectGradient("task: [{" + term + ", when: " + when + "}]")) << when;
    }
  }
  for (const char* target :
       {"{type: number, value: 30 mm}", "{type: schedule, values: [{value: 30 mm}, {after: 80 ms, value: 40 mm}]}",
        "{type: signal, signal: gap}"}) {
    for (const char* side : {"both", "above", "below"}) {
      ExpectGradient(std::string("task: [{signals: [tip_x, tip_z], scale: 10 mm, target: ") + target +
                     ", side: " + side + ", when: {type: samples, every: 40 ms}}]");
    }
  }
  for (const char* when : {"{type: end}", "{type: at, time: 120 ms}", "{type: samples, every: 40 ms, reduce: mean}"}) {
    EXPECT_TRUE(ExpectGradient(std::string("distillation: [{signals: [tip_x, drift], scale: 10 mm, when: ") + when +
                               ", target: {type: reference}}, {signals: [u], target: {type: reference}}]"))
        << when;
  }
}

}  // namespace loss_terms_test
}  // namespace knap
