#include "sim/rollout/known_numbers.h"

#include <cmath>
#include <map>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {
namespace {

constexpr int kPoints = 200;

// In the form and on the terms of configs/pushing.yaml.
constexpr const char* kScene = R"(schema: 2
name: known
gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]
bodies:
  - name: table
    joint: {type: fixed}
    shapes: [{type: half_space}]
  - name: pusher
    joint:
      type: prescribed
      motion: {type: zigzag, amplitude: 5 mm, period: 1 s, sharpness: 0.95, forward_speed: 60 mm/s, stop_at: 370 mm}
    shapes: [{type: designed_mesh}]
  - name: pea
    joint: {type: free}
    shapes: [{type: sphere, radius: 7 mm}]
    inertia: {type: solid, mass: 1.44 g}
    initial: {position: [0 mm, 8 mm, 7 mm]}
contacts:
  - {bodies: [pea, table], stiffness: 3e7 N/m^3, damping: 10 s/m,
     friction: 0.4, rolling_resistance: 0.05, slip_speed: 1 mm/s}
  - {bodies: [pea, pusher], stiffness: 3e7 N/m^3, damping: 10 s/m,
     friction: 0.4, rolling_resistance: 0.05, slip_speed: 1 mm/s}
design:
  parameters:
    - {name: width, initial: 40 mm, lower: 30 mm, upper: 50 mm}
    - {name: slant, initial: 3 mm, lower: 0 mm, upper: 10 mm}
  bodies:
    - name: pusher
      mesh: box.obj
      cage: cage.obj
      mesh_unit: 1 mm
      vertex_groups:
        - {name: right, vertices: [4, 5, 6, 7]}
      moves:
        - {parameter: width, group: right, direction: [1, 0, 0]}
        - {parameter: slant, group: right, direction: [0, 1, 0]}
variation:
  - {key: "bodies.pea.initial.position[0]", distribution: uniform, lower: -5 mm, upper: 5 mm}
rollout: {horizon: 240 ms, newton_tolerance: 1e-13, newton_max_iterations: 30}
signals:
  - {name: x, type: position, body: pea, axis: x}
  - {name: y, type: position, body: pea, axis: y}
loss:
  task:
    - signals: [x]
      when: {type: crossing, signal: y, at: 14 mm, never_cost: 600, never_scale: 20 mm}
      margin: 0.1 mm
      scale: 1 mm
  distillation:
    - signals: [x, y]
      when: {type: samples, every: 20 ms, reduce: mean}
      target: {type: reference}
      scale: 1 mm
success:
  {type: within, signals: [x], above: -8 mm, below: 8 mm, when: {type: crossing, signal: y, at: 14 mm}}
learning: {method: ours, variations: 1, batch: 1, dimensions_per_batch: 1, seed: 0}
evaluation: {variations: 1, seed: 1}
)";

// The box [x0, x1] x [y0, y1] x [z0, z1], millimetres. Its vertices 4 to 7 (from 0) are those at x1.
std::string MakeBoxObj(int x0, int x1, int y0, int y1, int z0, int z1) {
  std::string text;
  for (const int x : {x0, x1}) {
    for (const auto& [y, z] : {std::pair{y0, z0}, {y1, z0}, {y1, z1}, {y0, z1}}) {
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    }
  }
  for (const char* face :
       {"1 3 2", "1 4 3", "5 6 7", "5 7 8", "1 2 6", "1 6 5", "4 8 7", "4 7 3", "2 3 7", "2 7 6", "1 5 8", "1 8 4"}) {
    text.append("f ").append(face).append("\n");
  }
  return text;
}

void AppendElementaryFunctions(std::vector<double>* numbers) {
  double unit = 0.0;  // low-discrepancy in [0, 1), made of exactly rounded operations alone
  for (int i = 0; i < kPoints; ++i) {
    unit += 0.6180339887498949;
    if (unit >= 1.0) unit -= 1.0;
    const double signed_unit = 2.0 * unit - 1.0;
    const double angle = 50.0 * signed_unit;
    const double positive = 1e-3 + 100.0 * unit;
    for (const double value :
         {std::sin(angle), std::cos(angle), std::tan(angle), std::asin(signed_unit), std::acos(signed_unit),
          std::atan(angle), std::atan2(signed_unit, 0.3 - unit), std::sinh(0.2 * angle), std::cosh(0.2 * angle),
          std::tanh(0.1 * angle), std::exp(0.5 * angle), std::expm1(signed_unit), std::log(positive),
          std::log1p(positive), std::pow(positive, 0.7 + signed_unit), std::sqrt(positive), std::cbrt(positive),
          std::hypot(positive, angle)}) {
      numbers->push_back(value);
    }
  }
}

void AppendRollout(RolloutModel* model, const RolloutInput& input, std::vector<double>* numbers) {
  const RolloutOutput output = model->Run(input, {});
  numbers->push_back(output.loss);
  numbers->push_back(output.certificate.worst_residual);
  numbers->insert(numbers->end(), output.gradient.data(), output.gradient.data() + output.gradient.size());
}

}  // namespace

std::map<std::string, std::string> MakeKnownScenario() {
  return {{kScenarioFileName, kScene},
          {"box.obj", MakeBoxObj(-20, 20, -12, 0, 0, 20)},
          {"cage.obj", MakeBoxObj(-21, 21, -13, 1, -1, 21)}};
}

std::vector<double> CalcKnownNumbers() {
  std::vector<double> numbers;
  AppendElementaryFunctions(&numbers);

  RolloutModel model(MakeKnownScenario());
  RolloutInput input;
  input.theta = model.initial_theta();
  input.variation = {0.002};
  AppendRollout(&model, input, &numbers);
  input.theta_reference = input.theta;
  input.theta[0] += 1e-3;
  input.theta[1] += 2e-3;
  AppendRollout(&model, input, &numbers);
  return numbers;
}

}  // namespace knap
