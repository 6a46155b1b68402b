// The engine `bowl`, in closed form: the C++ twin of the one in tests/worker/java/Bowl.java, so that workers in two
// languages can be held against each other. Whatever the scenario is, theta in metres and then the controls, weights
// w_i = 1 + i/2, v_i the variation's value i modulo its length (0 when empty) and targets t_i = (0.01 + 0.005 i) + 0.1
// v_i:
//   task loss L = 1/2 sum_i w_i (theta_i - t_i)^2,        dL/dtheta_i = w_i (theta_i - t_i)
//   distillation L = 1/2 sum_i (theta_i - reference_i)^2, dL/dtheta_i = theta_i - reference_i
//   success: L < 0.001.
// The order of operations, 0.5 · w · e · e added up from the left, is the same in both, and none of them may be rounded
// in two ways, so the engine's name says all: no build, no fingerprint.
#pragma once

#include <memory>
#include <string>

#include "worker/engine.h"

namespace knap {

class BowlEngine : public Engine {
 public:
  EngineIdentity identity() const override { return {"bowl", "", {}}; }
  std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) override;
};

}  // namespace knap
