// configs/winding.yaml and winding_turn.yaml for tests: loaded, built for one design, and the designs they ask about.
#pragma once

#include <Eigen/Dense>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"

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
  Eigen::VectorXd theta = rollout.design()->initial_theta();
  const std::vector<DesignParameter>& parameters = rollout.scene().design->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string station = parameters[i].name.substr(0, parameters[i].name.find('_'));
    if (station == "first" || station == "fourth") theta(static_cast<Eigen::Index>(i)) = ends;
  }
  return theta;
}

}  // namespace knap::test
