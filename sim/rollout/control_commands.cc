#include "sim/rollout/control_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace knap {
namespace {

// Column-major with a row an actuator: exactly the order in which controls travel.
Eigen::Map<const Eigen::MatrixXd> ViewByActuator(const Controls& controls, const Eigen::VectorXd& a) {
  const auto rows = static_cast<Eigen::Index>(controls.actuators.size());
  if (rows == 0 || a.size() % rows != 0) {
    throw std::invalid_argument(fmt::format("{} control values for {} actuators", a.size(), rows));
  }
  return {a.data(), rows, a.size() / rows};
}

// Which row of the commands drives an actuator of the model; −1 where none does.
Eigen::Index FindCommand(const Scene& scene, const ActuatorCommand& actuator) {
  if (!scene.controls) return -1;
  const std::vector<std::string>& driven = scene.controls->actuators;
  const auto found = std::find(driven.begin(), driven.end(), actuator.body);
  return found == driven.end() ? -1 : found - driven.begin();
}

}  // namespace

int CalcHoldSteps(double interval, const Rollout& rollout) {
  return static_cast<int>(std::llround(interval / rollout.step));
}

int CountIntervals(double interval, const Rollout& rollout) {
  return static_cast<int>(std::llround(rollout.horizon / interval));
}

int CountControls(const Scene& scene) {
  if (!scene.controls) return 0;
  return CountIntervals(scene.controls->interval, scene.rollout) * static_cast<int>(scene.controls->actuators.size());
}

Eigen::MatrixXd CalcCommands(const Controls& controls, const Eigen::VectorXd& a) {
  const Eigen::MatrixXd by_actuator = ViewByActuator(controls, a);
  if (controls.squash == Squash::kNone) return by_actuator;
  return by_actuator.unaryExpr([](double x) { return std::tanh(x); });
}

Eigen::VectorXd PullBackCommands(const Controls& controls, const Eigen::VectorXd& a, const Eigen::MatrixXd& bar_u) {
  const Eigen::MatrixXd u = CalcCommands(controls, a);
  if (bar_u.rows() != u.rows() || bar_u.cols() != u.cols()) {
    throw std::invalid_argument(fmt::format("cotangents of {} x {} commands; expected {} x {}", bar_u.rows(),
                                            bar_u.cols(), u.rows(), u.cols()));
  }
  Eigen::MatrixXd bar_a = bar_u;
  if (controls.squash == Squash::kTanh) bar_a.array() *= 1.0 - u.array().square();  // tanh' = 1 − tanh²
  return bar_a.reshaped();
}

ControlSequence MakeControlSequence(const Scene& scene, const SceneModel& model, const Eigen::MatrixXd& u) {
  ControlSequence out;
  if (model.actuators.empty()) return out;
  int intervals = 1;
  if (scene.IsDriven()) {
    const double interval = scene.controls ? scene.controls->interval : scene.policy->interval;  // equal if both
    out.steps_per_interval = CalcHoldSteps(interval, scene.rollout);
    intervals = CountIntervals(interval, scene.rollout);
  }
  out.values.resize(static_cast<Eigen::Index>(model.actuators.size()), intervals);
  for (Eigen::Index row = 0; row < out.values.rows(); ++row) {
    const ActuatorCommand& actuator = model.actuators[static_cast<std::size_t>(row)];
    out.values.row(row).setConstant(actuator.center);
    const Eigen::Index k = FindCommand(scene, actuator);
    if (k >= 0) out.values.row(row) += actuator.half * u.row(k);
  }
  return out;
}

Eigen::MatrixXd PullBackControlSequence(const Scene& scene, const SceneModel& model,
                                        const Eigen::MatrixXd& bar_values) {
  Eigen::MatrixXd bar_u(static_cast<Eigen::Index>(scene.controls->actuators.size()), bar_values.cols());
  for (Eigen::Index row = 0; row < bar_values.rows(); ++row) {
    const ActuatorCommand& actuator = model.actuators[static_cast<std::size_t>(row)];
    const Eigen::Index k = FindCommand(scene, actuator);
    if (k >= 0) bar_u.row(k) = actuator.half * bar_values.row(row);
  }
  return bar_u;
}

}  // namespace knap
