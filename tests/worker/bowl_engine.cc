#include "tests/worker/bowl_engine.h"

namespace knap {
namespace {

constexpr std::int32_t kSteps = 100;

class BowlScenario : public EngineScenario {
 public:
  EngineAnswer Run(const EngineRequest& request,
                   const std::function<void(std::int64_t, std::int64_t)>& progress) override {
    EngineAnswer answer;
    const bool task = request.reference.empty();
    const std::vector<double>& v = request.variation;
    std::vector<double> decided = request.theta;
    decided.insert(decided.end(), request.controls.begin(), request.controls.end());
    for (std::size_t i = 0; i < decided.size(); ++i) {
      const double index = static_cast<double>(i);
      const double weight = task ? 1.0 + 0.5 * index : 1.0;
      double target = task ? 0.01 + 0.005 * index : request.reference.at(i);
      if (task && !v.empty()) target = target + 0.1 * v[i % v.size()];
      const double error = decided[i] - target;
      answer.loss = answer.loss + 0.5 * weight * error * error;
      if (request.gradient) answer.gradient.push_back(weight * error);
    }
    progress(kSteps, kSteps);
    answer.success = answer.loss < 0.001;
    answer.finite = answer.converged = answer.gradient_reliable = true;
    answer.steps = kSteps;
    return answer;
  }
};

}  // namespace

std::unique_ptr<EngineScenario> BowlEngine::Load(const ScenarioFiles&) { return std::make_unique<BowlScenario>(); }

}  // namespace knap
