// The engine `knap`: the differentiable simulator behind the worker's protocol.
#include "worker/knap_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lcmtypes/wire/clock.h"
#include "sim/rollout/rollout.h"
#include "worker/knap_identity.h"

namespace knap {
namespace {

Eigen::VectorXd ToVector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

class KnapScenario final : public EngineScenario {
 public:
  explicit KnapScenario(const ScenarioFiles& files) : model_(files) { model_.clock = ReadSteadySeconds; }

  EngineAnswer Run(const EngineRequest& request,
                   const std::function<void(std::int64_t, std::int64_t)>& progress) override {
    EngineAnswer answer;
    RolloutInput input;
    input.theta = ToVector(request.theta);
    input.controls = ToVector(request.controls);
    const auto split = [&](const std::vector<double>& values, Eigen::VectorXd* theta, Eigen::VectorXd* controls) {
      const Eigen::VectorXd all = ToVector(values);
      const Eigen::Index design_size = std::min(input.theta.size(), all.size());
      *theta = all.head(design_size);
      *controls = all.tail(all.size() - design_size);
    };
    split(request.reference, &input.theta_reference, &input.controls_reference);
    split(request.nodes, &input.theta_nodes, &input.controls_nodes);
    input.variation = request.variation;
    input.want_gradient = request.gradient;
    try {
      const RolloutOutput output = model_.Run(input, [&](int done, int total) { progress(done, total); });
      answer.loss = output.loss;
      answer.success = output.success;
      answer.gradient.assign(output.gradient.begin(), output.gradient.end());
      answer.gradient.insert(answer.gradient.end(), output.control_gradient.begin(), output.control_gradient.end());
      answer.finite = output.certificate.finite;
      answer.converged = output.certificate.converged;
      answer.gradient_reliable = output.gradient_reliable;
      answer.distrust = fmt::format("{}", fmt::join(output.distrust, "; "));
      answer.penetration = output.certificate.penetration;
      answer.largest_force = output.certificate.largest_force;
      answer.loss_error = output.loss_error;
      answer.worst_residual = output.certificate.worst_residual;
      answer.subdivided_steps = output.certificate.subdivided_steps;
      answer.contact_onsets = output.certificate.contact_onsets;
      answer.steps = output.steps;
      answer.forward_s = model_.forward_s;
      answer.gradient_s = model_.gradient_s;
    } catch (const std::invalid_argument& error) {
      answer.error = error.what();
    }
    return answer;
  }

 private:
  RolloutModel model_;
};

class KnapEngine final : public Engine {
 public:
  EngineIdentity identity() const override { return MakeOwnIdentity(kKnapEngine, "/proc/self/exe"); }
  std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) override {
    return std::make_unique<KnapScenario>(files);
  }
};

}  // namespace

std::unique_ptr<Engine> MakeKnapEngine() { return std::make_unique<KnapEngine>(); }

}  // namespace knap
