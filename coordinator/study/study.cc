#include "coordinator/study/study.h"

#include <algorithm>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "coordinator/study/shared_service.h"

namespace knap {
namespace {

// Counts what one run asks.
class CountedService : public RolloutService {
 public:
  explicit CountedService(RolloutService* service) : service_(service) {}

  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    Count(queries);
    return service_->Evaluate(queries);
  }

  void Count(std::span<const RolloutQuery> queries) {
    total_ += static_cast<std::int64_t>(queries.size());
    for (const RolloutQuery& query : queries) {
      distinct_.emplace(query.theta, query.theta_reference, query.variation, query.gradient, query.theta_nodes);
    }
  }

  std::int64_t total() const { return total_; }
  std::int64_t distinct() const { return static_cast<std::int64_t>(distinct_.size()); }

 private:
  RolloutService* service_;
  std::int64_t total_ = 0;
  std::set<std::tuple<std::vector<double>, std::vector<double>, std::vector<double>, bool, std::vector<double>>>
      distinct_;
};

class Study {
 public:
  Study(const Problem& problem, const StudyOptions& options, RolloutService* service, StudyObserver* observer)
      : problem_(problem), options_(options), service_(service), observer_(observer) {
    for (const LearningOptions& learning : PlanRuns(options)) result_.runs.emplace_back().learning = learning;
  }

  StudyResult Run() {
    result_.initial =
        EvaluateDesign(problem_.variations, problem_.parameters.initial, options_.tests, options_.test_seed, *service_)
            .summary;
    observer_->OnInitial(result_.initial);
    std::vector<std::size_t> ours, others;
    for (std::size_t i = 0; i < result_.runs.size(); ++i) {
      (result_.runs[i].learning.method == LearningMethod::kOurs ? ours : others).push_back(i);
    }
    RunRuns(ours);
    for (const std::size_t i : others) {
      for (const std::size_t k : ours) {
        if (result_.runs[k].learning.seed != result_.runs[i].learning.seed) continue;
        result_.runs[i].learning.rollout_budget = result_.runs[k].learned.rollouts;
      }
    }
    RunRuns(others);
    return std::move(result_);
  }

 private:
  void RunRuns(const std::vector<std::size_t>& runs) {
    RunTogether(service_, runs.size(), [&](std::size_t i, RolloutService* service) { RunOne(runs[i], service); });
  }

  void RunOne(std::size_t i, RolloutService* service) {
    StudyRun& run = result_.runs[i];
    CountedService counted(service);
    run.learned = Learn(problem_, run.learning, counted, observer_->GetRunObserver(i));
    run.test =
        EvaluateDesign(problem_.variations, run.learned.theta, options_.tests, options_.test_seed, counted).summary;
    run.rollouts_total = counted.total() + options_.tests;
    run.rollouts_distinct = counted.distinct() + options_.tests;
    const std::lock_guard lock(mutex_);
    observer_->OnRunEnd(i, run);
  }

  const Problem& problem_;
  const StudyOptions& options_;
  RolloutService* const service_;
  StudyObserver* const observer_;
  StudyResult result_;
  std::mutex mutex_;
};

}  // namespace

void CheckStudyOptions(const StudyOptions& options) {
  if (options.methods.empty()) throw std::invalid_argument("study: no method; at least one is needed");
  for (auto method = options.methods.begin(); method != options.methods.end(); ++method) {
    if (std::find(method + 1, options.methods.end(), *method) != options.methods.end()) {
      throw std::invalid_argument(std::string("study: method ") + GetName(*method) + " is given twice");
    }
  }
  if (options.seeds < 1) {
    throw std::invalid_argument("study: seeds is " + std::to_string(options.seeds) + "; 1 or more are allowed");
  }
  if (options.tests < 1) {
    throw std::invalid_argument("study: tests is " + std::to_string(options.tests) + "; 1 or more are allowed");
  }
}

std::vector<LearningOptions> PlanRuns(const StudyOptions& options) {
  std::vector<LearningOptions> runs;
  for (const LearningMethod method : options.methods) {
    for (int k = 0; k < options.seeds; ++k) {
      LearningOptions& run = runs.emplace_back(options.learning);
      run.method = method;
      run.seed += static_cast<std::uint64_t>(k);
    }
  }
  return runs;
}

StudyResult RunStudy(const Problem& problem, const StudyOptions& options, RolloutService& service,
                     StudyObserver& observer) {
  CheckStudyOptions(options);
  return Study(problem, options, &service, &observer).Run();
}

std::vector<MethodSummary> SummarizeMethods(const StudyOptions& options, const StudyResult& result) {
  std::vector<MethodSummary> summaries;
  for (const LearningMethod method : options.methods) {
    std::vector<TestSummary> tests;
    std::vector<double> rates, rollouts;
    for (const StudyRun& run : result.runs) {
      if (run.learning.method != method) continue;
      tests.push_back(run.test);
      rates.push_back(run.test.success_rate);
      rollouts.push_back(static_cast<double>(run.learned.rollouts));
    }
    std::sort(rates.begin(), rates.end());
    MethodSummary& summary = summaries.emplace_back();
    summary.method = method;
    summary.spread = SummarizeSeeds(tests);
    summary.success_least = rates.front();
    summary.success_median = 0.5 * (rates[(rates.size() - 1) / 2] + rates[rates.size() / 2]);
    summary.success_most = rates.back();
    summary.rollouts_mean = CalcSpread(rollouts).mean;
  }
  return summaries;
}

}  // namespace knap
