#include "tests/simulation/reference_run.h"

#include <bit>
#include <memory>
#include <stdexcept>

#include "coordinator/rollout_service.h"
#include "tests/worker/closed_form_engine.h"

namespace knap {
namespace {

// The engine itself, asked in this process.
class DirectService : public RolloutService {
 public:
  explicit DirectService(const std::map<std::string, std::string>& scenario) : scenario_(engine_.Load(scenario)) {}

  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    std::vector<RolloutOutcome> outcomes;
    for (const RolloutQuery& query : queries) {
      const EngineAnswer answer = scenario_->Run(
          {query.theta, {}, query.theta_reference, query.variation, query.gradient}, [](std::int64_t, std::int64_t) {});
      RolloutOutcome outcome;
      outcome.loss = answer.loss;
      outcome.success = answer.success;
      outcome.gradient = answer.gradient;
      outcome.certificate = {.finite = answer.finite,
                             .converged = answer.converged,
                             .gradient_reliable = answer.gradient_reliable,
                             .worst_residual = answer.worst_residual,
                             .subdivided_steps = answer.subdivided_steps,
                             .contact_onsets = answer.contact_onsets,
                             .penetration = answer.penetration,
                             .largest_force = answer.largest_force,
                             .distrust = answer.distrust};
      outcome.steps = answer.steps;
      outcomes.push_back(outcome);
    }
    return outcomes;
  }

 private:
  ClosedFormEngine engine_;
  std::unique_ptr<EngineScenario> scenario_;
};

class Collector : public LearningObserver {
 public:
  void OnBatchStart(const BatchStart&) override {}
  void OnEvaluation(const LearningEvaluation& evaluation) override { evaluations.push_back(evaluation); }
  void OnBatchBox(const BatchBox&) override {}
  void OnBatchEnd(const BatchEnd&) override {}

  std::vector<LearningEvaluation> evaluations;
};

}  // namespace

bool HasSameBits(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
  }
  return true;
}

SimulatedProblem MakeSimulatedProblem(std::uint64_t index) {
  SimulatedProblem made;
  made.scenario = {{"scenario.txt", "dimension 3\nsteps 10\n"}, {"mesh.obj", std::string(2000, 'v')}};
  for (const char* name : {"a", "b", "c"}) {
    made.problem.parameters.names.push_back(name);
    made.problem.parameters.lower.push_back(-0.5);
    made.problem.parameters.upper.push_back(1.0);
    made.problem.parameters.initial.push_back(0.7);
  }
  made.problem.variations = {{{"x"}, UniformDraw{-0.3, 0.3}}, {{"y"}, UniformDraw{-0.2, 0.5}}};
  made.options.method = index % 3 == 0   ? LearningMethod::kOurs
                        : index % 3 == 1 ? LearningMethod::kSimpleContinual
                                         : LearningMethod::kDiffHand;
  made.options.variations = made.options.method == LearningMethod::kOurs ? 6 : 4;
  made.options.batch = 2;
  made.options.dimensions_per_batch = 2;
  made.options.max_evaluations = 4;
  made.options.seed = index;
  return made;
}

const ReferenceRun& GetReferenceRun(std::uint64_t index) {
  static std::map<std::uint64_t, ReferenceRun> runs;
  const auto [found, is_new] = runs.try_emplace(index);
  if (is_new) {
    const SimulatedProblem made = MakeSimulatedProblem(index);
    DirectService service(made.scenario);
    Collector collector;
    found->second.theta = Learn(made.problem, made.options, service, collector).theta;
    found->second.evaluations = collector.evaluations;
  }
  return found->second;
}

void ReferenceObserver::OnEvaluation(const LearningEvaluation& evaluation) {
  const std::size_t number = count_++;
  if (number < reference_.evaluations.size()) {
    const BatchEvaluation& expected = reference_.evaluations[number].value;
    const BatchEvaluation& value = evaluation.value;
    if (HasSameBits(value.theta, expected.theta) && HasSameBits({value.loss}, {expected.loss}) &&
        HasSameBits(value.gradient, expected.gradient)) {
      return;
    }
  }
  throw std::runtime_error("evaluation " + std::to_string(number) + " has other bits than the reference's");
}

}  // namespace knap
