#include "sim/rollout/control_commands.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

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

}  // namespace

int CalcHoldSteps(const Controls& controls, const Rollout& rollout) {
  return static_cast<int>(std::llround(controls.interval / rollout.step));
}

int CountIntervals(const Controls& controls, const Rollout& rollout) {
  return static_cast<int>(std::llround(rollout.horizon / controls.interval));
}

int CountControls(const Scene& scene) {
  if (!scene.controls) return 0;
  return CountIntervals(*scene.controls, scene.rollout) * static_cast<int>(scene.controls->actuators.size());
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

}  // namespace knap
