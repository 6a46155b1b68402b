// An engine whose answers are known in closed form, for tests of everything around an engine.
//
// Scenario: the file "scenario.txt" with lines "key value"; all keys may be missing:
//   dimension D (4), controls C (0), steps S (10), step_us T (0: wall time of a step), crash_at V, hang_at V, fail_at
//   V, allocate_mb M (0: address space that a rollout asks for).
// Request: theta of D and controls of C values, together x, and a variation v of any length. With v_i the variation's
// value i modulo its length (0 when empty), weights w_i = 1 + i/2 and targets t_i = i/10 + v_i:
//   task loss L = 1/2 sum_i w_i (x_i - t_i)^2,         dL/dx_i = w_i (x_i - t_i)
//   distillation L = 1/2 sum_i (x_i - reference_i)^2,  dL/dx_i = x_i - reference_i
//   success: L < 1.
// A first variation value equal to crash_at aborts the process, to hang_at never ends, to fail_at is an error.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "worker/engine.h"

namespace knap {

class ClosedFormEngine : public Engine {
 public:
  EngineIdentity identity() const override { return {"closed-form", "1", CalcFingerprint(std::array{0.5})}; }
  std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) override;
};

// Announces itself as it is told, and answers like its base but with the last bit of the loss wrong.
class WrongEngine : public ClosedFormEngine {
 public:
  explicit WrongEngine(EngineIdentity identity = ClosedFormEngine().identity()) : identity_(std::move(identity)) {}
  EngineIdentity identity() const override { return identity_; }
  std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) override;

 private:
  EngineIdentity identity_;
};

}  // namespace knap
