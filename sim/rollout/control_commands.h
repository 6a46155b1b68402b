// Open-loop controls as the commands that actuators get, and gradients back from commands to controls [docs/method.md].
//
//   u[k][i] = s(a[i][k])        for every step n of interval i = floor(n / hold)
//   bar_a[i][k] = s'(a[i][k])·bar_u[k][i]
//
// a: the controls, dimensionless, interval by interval and in each actuator by actuator, as they travel; s: tanh, or
// the identity. What a command of 1 means, an actuator's limit say, is the actuator's business.
#pragma once

#include <Eigen/Core>

#include "sim/integrators/control_sequence.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Steps for which one command is held. ParseScene has checked that these are whole numbers.
int CalcHoldSteps(double interval, const Rollout& rollout);
int CountIntervals(double interval, const Rollout& rollout);

// Number of open-loop control values of a scene: actuators times intervals; 0 without a section `controls`.
int CountControls(const Scene& scene);

// u: a row a driven actuator, a column an interval. a: CountControls values; throws std::invalid_argument when the
// number does not fit the number of actuators.
Eigen::MatrixXd CalcCommands(const Controls& controls, const Eigen::VectorXd& a);

// bar_a from bar_u, the sum over an interval's steps of dloss/du: same shapes as above.
Eigen::VectorXd PullBackCommands(const Controls& controls, const Eigen::VectorXd& a, const Eigen::MatrixXd& bar_u);

// What the model's actuators get in every interval: commands u (no rows without a section `controls`), 0 for those that
// are not driven, and for those of a policy until it sets them.
ControlSequence MakeControlSequence(const Scene& scene, const SceneModel& model, const Eigen::MatrixXd& u);

// bar_u from the cotangents of MakeControlSequence's values; needs a section `controls`.
Eigen::MatrixXd PullBackControlSequence(const Scene& scene, const SceneModel& model, const Eigen::MatrixXd& bar_values);

}  // namespace knap
