#include "worker/bullet_engine.h"

#include <fmt/format.h>

#include <stdexcept>

#include "lcmtypes/wire/clock.h"
#include "sim/transfer/transfer_model.h"
#include "worker/knap_identity.h"

namespace knap {
namespace {

class BulletScenario final : public EngineScenario {
 public:
  explicit BulletScenario(const ScenarioFiles& files) : model_(files) {}

  EngineAnswer Run(const EngineRequest& request,
                   const std::function<void(std::int64_t, std::int64_t)>& progress) override {
    EngineAnswer answer;
    if (request.gradient) answer.error = "the engine bullet has no gradients: ask for losses alone";
    if (!request.reference.empty()) answer.error = "the engine bullet has no distillation: ask for task losses";
    if (!request.controls.empty()) answer.error = "the engine bullet has no actuators";
    if (!answer.error.empty()) return answer;
    const double start = ReadSteadySeconds();
    try {
      const Eigen::Map<const Eigen::VectorXd> theta(request.theta.data(),
                                                    static_cast<Eigen::Index>(request.theta.size()));
      const TransferOutput output =
          model_.Run(theta, request.variation, [&](int done, int total) { progress(done, total); });
      answer.loss = output.loss;
      answer.success = output.success;
      answer.finite = answer.converged = output.finite;
      answer.gradient_reliable = true;
      answer.distrust = fmt::format("{}", fmt::join(output.distrust, "; "));
      answer.penetration = output.penetration;
      answer.largest_force = output.largest_force;
      answer.contact_onsets = output.contact_onsets;
      answer.steps = output.steps;
      answer.forward_s = ReadSteadySeconds() - start;
    } catch (const std::invalid_argument& error) {
      answer.error = error.what();
    }
    return answer;
  }

 private:
  TransferModel model_;
};

class BulletEngine final : public Engine {
 public:
  EngineIdentity identity() const override { return MakeOwnIdentity(kBulletEngine, "/proc/self/exe"); }
  std::unique_ptr<EngineScenario> Load(const ScenarioFiles& files) override {
    return std::make_unique<BulletScenario>(files);
  }
};

}  // namespace

std::unique_ptr<Engine> MakeBulletEngine() { return std::make_unique<BulletEngine>(); }

}  // namespace knap
