// configs/winding.yaml and winding_turn.yaml for tests: loaded, built for one design, and the designs they ask about.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/rollout/scene_design.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/rollout/differences.h"

namespace knap::test {

inline RolloutModel LoadConfig(const std::string& name, const std::vector<std::string>& overrides) {
  const LoadedScenario loaded = LoadScenario(KNAP_CONFIGS "/" + name, overrides);
  if (!loaded.parsed.ok()) throw std::runtime_error(loaded.parsed.FormatErrors());
  return RolloutModel(loaded.files);
}

inline RolloutModel LoadWinding(const std::vector<std::string>& overrides) {
  return LoadConfig("winding.yaml", overrides);
}

inline SceneModel Build(const RolloutModel& rollout, const Scene& scene, const Eigen::VectorXd& theta) {
  return BuildModel(scene, rollout.design()->CalcShapes(theta));
}

// The initial spool with both sides of both ends of this length [m].
inline Eigen::VectorXd MakeTheta(const RolloutModel& rollout, double ends) {
  Eigen::VectorXd theta = rollout.initial_theta();
  const std::vector<DesignParameter>& parameters = rollout.scene().design->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string station = parameters[i].name.substr(0, parameters[i].name.find('_'));
    if (station == "first" || station == "fourth") theta(static_cast<Eigen::Index>(i)) = ends;
  }
  return theta;
}

// The gradients of the task loss and of the distillation loss against the spool `reference`, at the best of the steps
// [m] for each parameter, within tolerance · ‖g‖∞.
inline void ExpectGradientsEqualDifferences(RolloutModel* rollout, RolloutInput input, const Eigen::VectorXd& reference,
                                            const std::vector<double>& steps, double tolerance) {
  for (const bool distill : {false, true}) {
    input.theta_reference = distill ? reference : Eigen::VectorXd();
    input.want_gradient = true;
    const RolloutOutput at = rollout->Run(input, {});
    ASSERT_TRUE(at.certificate.converged && at.certificate.finite);
    const double scale = at.gradient.cwiseAbs().maxCoeff();
    EXPECT_GT(scale, 1e-6);
    const auto loss = [&](const Eigen::VectorXd& theta) {
      RolloutInput moved = input;
      moved.theta = theta;
      moved.want_gradient = false;
      return rollout->Run(moved, {}).loss;
    };
    for (Eigen::Index i = 0; i < input.theta.size(); ++i) {
      double error = std::numeric_limits<double>::infinity();
      for (const double step : steps) {
        error = std::min(error, std::abs(at.gradient(i) - CalcDifference(loss, input.theta, i, step)));
      }
      EXPECT_LT(error, tolerance * scale) << "parameter " << i << ", distillation " << distill;
    }
  }
}

}  // namespace knap::test
