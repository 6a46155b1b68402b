// Whatever a variation draws, for every number of a scene that may vary: it is refused by key, or a rollout comes out
// that is finite or says that it is not to be trusted. Never a crash, never a loop without end.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/parse_scene.h"
#include "sim/scenarios/scenario_paths.h"
#include "sim/scenarios/units.h"
#include "tests/sim/rollout/box_mesh.h"

namespace knap {
namespace extreme_values_test {

// Joints, motions, shapes, inertias, contacts, grips, signals, terms of the loss and conditions that have numbers which
// may vary.
constexpr char kScene[] = R"(schema: 2
name: extremes
gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]
gravity_direction: {azimuth: 10 deg, rise: -0.9}
bodies:
  - name: ground
    joint: {type: fixed}
    shapes: [{type: half_space}]
  - name: tool
    joint:
      type: prescribed
      motion: {type: zigzag, amplitude: 6 mm, period: 1 s, sharpness: 0.9, forward_speed: 60 mm/s, stop_at: 37 cm}
    shapes: [{type: designed_mesh}]
  - name: wall
    joint:
      type: prescribed
      motion: {type: constant_velocity, velocity: [1 m/s, 0 m/s, 0 m/s], angular_velocity: [0 rad/s, 0 rad/s, 9 deg/s]}
  - name: hand
    joint:
      type: prescribed
      motion:
        type: segments
        segments:
          - {duration: 20 ms, ramp: 5 ms, shift: [1 cm, 2 cm, 0 cm], angle: 90 deg, axis: [0, 0, 3]}
          - {duration: 20 ms, ramp: 5 ms, angle: 1 rad, tips: [1, 0, 0]}
  - name: hinge
    parent: wall
    joint: {type: revolute, axis: [1, 1, 0], damping: 0.2 N*m*s/rad, stiffness: 0.1 N*m/rad, rest: 5 deg,
            limits: {lower: -90 deg, upper: 40 deg, stiffness: 2 N*m/rad, damping: 0.1 s/rad, width: 1 deg},
            actuator: {type: force, limit: 0.06 N*m}}
    inertia: {type: explicit, mass: 3 g, center: [1 mm, 2 mm, 3 mm],
              moments: [3e-6 kg*m^2, 3e-6 kg*m^2, 3e-6 kg*m^2], products: [1e-7 kg*m^2, 0 kg*m^2, 0 kg*m^2]}
    initial: {angle: 45 deg, rate: 1 rad/s}
  - name: slider
    parent: hinge
    joint: {type: prismatic, axis: [0, 0, 2], damping: 3 N*s/m, stiffness: 4 N/m, rest: 5 mm,
            limits: {lower: -1 cm, upper: 1 mm, stiffness: 200 N/m, damping: 2 s/m, width: 1 mm},
            actuator: {type: position, limit: 5 N, stiffness: 80 N/m, damping: 1 N*s/m, lower: -9 mm, upper: 9 mm}}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {displacement: 3 mm, speed: 1 mm/s}
  - name: swivel
    parent: slider
    joint: {type: ball, damping: 0.1 N*m*s/rad, stiffness: 0.2 N*m/rad, rest_rpy: [1 deg, 2 deg, 3 deg]}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {orientation_rpy: [10 deg, 20 deg, 30 deg], angular_velocity: [1 rad/s, 2 rad/s, 3 rad/s]}
  - name: puck
    joint: {type: planar, linear_damping: 1 N*s/m, angular_damping: 1 N*m*s/rad}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {position: [50 mm, 2 mm], angle: 3 deg, velocity: [4 mm/s, 5 mm/s], angular_velocity: 6 deg/s}
  - name: brick
    joint: {type: free}
    shapes: [{type: box, size: [29 mm, 8 mm, 9 mm], rounding: 1 mm, position: [15 mm, 0 mm, 0 mm]}]
    inertia: {type: solid, mass: 1.5 g}
    initial: {position: [0 mm, 60 mm, 4.4 mm]}
  - name: pill
    joint: {type: free}
    shapes: [{type: capsule, radius: 4 mm, length: 2 cm, position: [0 mm, 0 mm, 1 cm]}]
    inertia: {type: density, density: 1 g/cm^3}
    initial: {position: [0 mm, 60 mm, 12.5 mm], orientation_rpy: [90 deg, 0 deg, 0 deg]}
  - name: pea
    joint: {type: free}
    shapes: [{type: sphere, radius: 7 mm}]
    inertia: {type: solid, mass: 1.4 g}
    initial: {position: [0 mm, 6.9 mm, 7 mm], velocity: [1 mm/s, 2 mm/s, 3 mm/s],
              angular_velocity: [1 rad/s, 0 rad/s, 0 rad/s]}
ropes:
  - name: cord
    links: 3
    pitch: 20 mm
    thickness: 4 mm
    rounding: 1 mm
    link_mass: 1 g
    initial: {type: straight, start: [100 mm, 0 mm, 30 mm], direction: [0, 2, 0]}
contacts:
  - {bodies: [pea, ground], stiffness: 3e7 N/m^3, damping: 10 s/m, friction: 0.4, rolling_resistance: 0.03,
     slip_speed: 1 mm/s}
  - {bodies: [pea, tool], stiffness: 3e7 N/m^3, damping: 10 s/m, friction: 0.4, stick_distance: 20 um}
  - {bodies: [brick, ground], stiffness: 1e8 N/m^3, damping: 2 s/m, friction: 0.4, stick_distance: 20 um}
  - {bodies: [brick, pill], stiffness: 1e8 N/m^3, friction: 0.2}
  - {bodies: [brick, tool], stiffness: 1e8 N/m^3}
  - {bodies: [pill, tool], stiffness: 1e8 N/m^3}
  - {bodies: [cord, brick], stiffness: 1e8 N/m^3}
grips:
  - {body: hand, point: [1 mm, 2 mm, 3 mm], held: cord, held_point: [50 mm, 1 mm, 0 mm], stiffness: 200 N/m,
     damping: 0.1 N*s/m, limit: 2 N, from: 4 ms, until: 12 ms}
  - {body: wall, held: pill, stiffness: 10 N/m, until: 2 s}
rollout: {horizon: 16 ms, step: 4 ms, integrator: bdf2, newton_tolerance: 1e-10, newton_max_iterations: 30}
signals:
  - {name: hinge_angle, type: angle, joint: hinge}
  - {name: hinge_rate, type: rate, joint: hinge}
  - {name: slid, type: displacement, joint: slider}
  - {name: sliding, type: speed, joint: slider}
  - {name: x, type: position, body: pea, point: [0 mm, 1 mm, 0 mm], in: hand, axis: x}
  - {name: y, type: position, body: pea, axis: y}
  - {name: speed, type: velocity, body: tool, point: [18 mm, -1 mm, 2 mm], axis: y}
  - {name: facing, type: direction, body: swivel, of: z, in: slider, axis: x}
  - {name: spin, type: angular_velocity, body: brick, axis: y}
  - {name: error, type: distance, body: pill, point: [0 mm, 0 mm, 1 cm], in: tool,
     targets: [{position: [1 cm, 2 cm, 3 cm]}, {after: 10 ms, position: [0 m, 0 m, 1 m]}]}
  - {name: center, type: center_of_mass, of: [cord, brick], in: hand, axis: z}
  - {name: height, type: height, of: [cord]}
  - {name: rise, type: drift, of: [cord, pea], carried_by: hand, since: 4 ms}
  - {name: sunk, type: depth, bodies: [brick, ground]}
  - {name: push, type: force, bodies: [pea, tool]}
  - {name: command, type: command, actuator: hinge}
  - {name: clock, type: time}
  - {name: goal, type: number, key: "signals.error.targets[0].position[0]"}
  - {name: off, type: difference, of: [x, goal]}
  - {name: away, type: norm, of: [off, y]}
  - {name: nearest, type: least, of: [away, error]}
  - {name: farthest, type: largest, of: [away, center]}
loss:
  task:
    - signals: [x]
      when: {type: crossing, signal: y, at: 7 mm, never_cost: 48, never_scale: 4 cm}
      target: {type: number, value: 1 mm}
      margin: 0.1 mm
      scale: 1 cm
      weight: 2
    - {signals: [rise, height], when: {type: samples, every: 4 ms, from: 4 ms, until: 16 ms, reduce: mean}, scale: 1 cm}
    - {signals: [command, facing], when: {type: samples, every: 8 ms}, weight: 0.1}
    - {signals: [error, away, farthest], when: {type: samples, every: 4 ms, reduce: largest}, shape: absolute,
       scale: 1 cm, weight: 10}
    - signals: [hinge_rate, spin]
      when: {type: at, time: 8 ms}
      target: {type: schedule, values: [{value: 5 rad/s}, {after: 6 ms, value: 8 rad/s}]}
      shape: log
      side: below
    - {signals: [off, nearest, center, slid], target: {type: signal, signal: goal}, shape: saturating, side: above,
       scale: 4 cm}
    - {signals: [speed, sliding], when: {type: samples, every: 4 ms, reduce: least}, scale: 2 cm/s}
    - {signals: [hinge_angle]}
  distillation:
    - {signals: [x, y], when: {type: samples, every: 8 ms, reduce: mean}, target: {type: reference}, scale: 1 cm,
       weight: 5}
    - {signals: [height], when: {type: at, time: 12 ms}, target: {type: reference}, scale: 1 cm}
    - {signals: [error], target: {type: reference}, scale: 1 cm}
success:
  type: all
  of:
    - {type: within, signals: [x], above: -20 mm, below: 20 mm, when: {type: crossing, signal: y, at: 7 mm}}
    - type: any
      of:
        - {type: within, signals: [sunk], above: 0 mm, below: 1 m, when: {type: ever, from: 4 ms, until: 14 ms}}
        - {type: within, signals: [push], above: -1 N, below: 3 N, when: {type: always, from: 4 ms, until: 14 ms}}
        - {type: within, signals: [away], above: -1 m, below: 1 m,
           when: {type: lasting, duration: 5 ms, from: 2 ms, until: 15 ms}}
        - {type: within, signals: [clock], above: 0 s, below: 1 s}
    - type: none
      of:
        - {type: within, signals: [facing], above: -3, below: -2, when: {type: at, time: 8 ms}}
controls: {actuators: [slider, hinge], interval: 8 ms, initial: 0.5}
)";

ParseResult Parse(const std::vector<std::string>& overrides) {
  return ParseScene(std::string(kScene) + test::kBoxDesign, "f.yaml", overrides);
}

RolloutModel MakeModel(const Scene& scene) {
  return RolloutModel({{kScenarioFileName, DumpScene(scene)},
                       {"box.obj", test::MakeBoxObj(-20, 20, -12, 0, 0, 20)},
                       {"cage.obj", test::MakeBoxObj(-21, 21, -13, 1, -1, 21)}});
}

RolloutInput MakeInput(const RolloutModel& model, double value) {
  RolloutInput input;
  input.theta = model.initial_theta();
  input.controls = Eigen::VectorXd::Constant(model.num_controls(), 0.5);
  input.variation = {value};
  return input;
}

// Asks for the loss that the number belongs to, with its gradient.
void ExpectSound(RolloutModel* model, const std::string& key, double value) {
  RolloutInput input = MakeInput(*model, value);
  if (key.starts_with("loss.distillation")) {
    input.theta_reference = input.theta;
    input.theta[0] += 1e-3;
    input.controls_reference = input.controls;
  }
  try {
    const RolloutOutput output = model->Run(input, {});
    const SimulationCertificate& certificate = output.certificate;
    EXPECT_TRUE(certificate.converged || !output.success) << key << " = " << value;
    if (!certificate.finite || !certificate.converged) return;
    EXPECT_TRUE(std::isfinite(output.loss)) << key << " = " << value;
    EXPECT_TRUE(output.gradient.allFinite() && output.control_gradient.allFinite()) << key << " = " << value;
  } catch (const std::invalid_argument& refusal) {
    EXPECT_NE(std::string(refusal.what()).find(key), std::string::npos) << key << ": " << refusal.what();
  }
}

class ExtremeValues : public testing::TestWithParam<std::string> {};

TEST_P(ExtremeValues, AreRefusedOrComeOutSound) {
  const std::string key = GetParam();
  Scene nominal = Parse({}).scene;
  const NumericKey number = [&] {
    for (const NumericKey& k : ListNumericKeys(nominal)) {
      if (k.path == key) return k;
    }
    throw std::logic_error("no number " + key);
  }();
  const std::string value = FormatQuantity(*number.value, number.dimension);
  const ParseResult varied =
      Parse({"variation=[{key: \"" + key + "\", distribution: uniform, lower: " + value + ", upper: " + value + "}]"});
  ASSERT_TRUE(varied.ok()) << varied.FormatErrors();
  RolloutModel model = MakeModel(varied.scene);
  const double own = *number.value;
  std::set<double> values{own};  // each once: of a number that is 0, all parts are
  for (const double extreme : {0.0, 1e-308, 1e-4, 1.0, 1e4, 1e308}) values.insert({extreme, -extreme});
  for (const double factor : {-1.0, 1e-3, 0.4, 2.1, 1e3}) values.insert(factor * own);
  std::seed_seq seed(key.begin(), key.end());
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> exponent(-15.0, 15.0);
  values.insert((random() % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, exponent(random)));
  for (const double v : values) ExpectSound(&model, key, v);
}

std::vector<std::string> ListVaryingKeys() {
  std::vector<std::string> keys;
  Scene scene = Parse({}).scene;
  for (const NumericKey& key : ListNumericKeys(scene)) {
    if (MayVary(key)) keys.push_back(key.path);
  }
  return keys;
}

INSTANTIATE_TEST_SUITE_P(EveryKey, ExtremeValues, testing::ValuesIn(ListVaryingKeys()), [](const auto& the_case) {
  std::string name = the_case.param;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
});

TEST(ExtremeValuesScene, IsValidAndTouches) {
  const ParseResult result = Parse({});
  ASSERT_TRUE(result.ok()) << result.FormatErrors();
  EXPECT_GT(ListVaryingKeys().size(), 350u);
  RolloutModel model = MakeModel(Parse({"variation=[{key: \"gravity[2]\", distribution: uniform, lower: -9.81 m/s^2, "
                                        "upper: -9.81 m/s^2}]"})
                                     .scene);
  const RolloutOutput output = model.Run(MakeInput(model, -9.81), {});
  EXPECT_TRUE(output.certificate.converged);
  EXPECT_TRUE(output.certificate.finite);
  EXPECT_NE(output.gradient.norm(), 0.0);
  EXPECT_NE(output.control_gradient.norm(), 0.0);
}

}  // namespace extreme_values_test
}  // namespace knap
