// The seam between the worker's protocol and what it computes: an engine turns a scenario and a request into an answer.
//
// The engine `knap` is the differentiable simulator; tests use closed-form engines. Answers of different engines are
// never mixed, so the engine's name is part of every request's id, and a worker whose engine is of another build or
// computes known numbers otherwise gets no work.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/wire/engine_identity.h"

namespace knap {

// A scenario as it travels: file name → bytes; "scenario.yaml" is the resolved configuration, the rest are its meshes.
using ScenarioFiles = std::map<std::string, std::string>;

struct EngineRequest {
  std::vector<double> theta;      // design parameters
  std::vector<double> controls;   // open loop, by interval and actuator; then weights of a policy; empty: none
  std::vector<double> reference;  // theta, then controls: distillation against their trajectory; empty: task loss
  std::vector<double> variation;
  bool gradient = true;
  // Theta, then controls: the time steps chosen there are taken, moved along with what happens; empty: they are chosen.
  // An engine that chooses none may ignore it.
  std::vector<double> nodes{};
};

// All fields but `error` and `lack` mean something only when both are empty.
struct EngineAnswer {
  std::string error;  // why no answer exists, whoever computes it: what the request asks for cannot be
  std::string lack;   // what this process or its machine lacked (memory, a descriptor); another worker may have it
  double loss = 0.0;
  bool success = false;
  std::vector<double> gradient;  // dloss/dtheta, then dloss/dcontrols; empty when not asked for
  bool finite = false;
  bool converged = false;
  bool gradient_reliable = false;
  std::string distrust;  // why the rollout is not to be trusted; empty: nothing tells against it
  double worst_residual = 0.0;
  double penetration = 0.0;    // the deepest contact, as a share of what the thinner body has
  double largest_force = 0.0;  // of one contact [N]
  double loss_error = std::numeric_limits<double>::quiet_NaN();  // NaN: not known
  std::int32_t subdivided_steps = 0;
  std::int32_t contact_onsets = 0;
  std::int32_t steps = 0;
  double forward_s = 0.0;
  double gradient_s = 0.0;
};

// One loaded scenario. Not thread-safe: one thread runs it.
class EngineScenario {
 public:
  virtual ~EngineScenario() = default;

  // Runs one rollout. `progress(done, total)` is called now and then from this thread with steps done. What it throws
  // is told apart as JobRunner says.
  virtual EngineAnswer Run(const EngineRequest& request,
                           const std::function<void(std::int64_t, std::int64_t)>& progress) = 0;
};

class Engine {
 public:
  virtual ~Engine() = default;
  // Equal identities mean equal bits in every answer. May compute for some milliseconds.
  virtual EngineIdentity identity() const = 0;
  // Throws std::runtime_error with one clear line when the files do not describe a scenario, std::bad_alloc or
  // std::system_error when the machine lacks something.
  virtual std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) = 0;
};

}  // namespace knap
