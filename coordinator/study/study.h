// Many runs of one scenario, method by method and seed by seed, on one pool of workers: what the methods are worth
// beside each other [paper §V, Baselines].
//
// All runs of a phase learn at the same time; the pool gives each of them one evaluation a round (shared_service.h).
// `ours` comes first when it is among the methods: the rollouts it used with a seed are then the budget of every other
// method with that seed, so that methods are compared at equal numbers of rollouts. Each run's bits are those it has
// alone, with the same budget.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "coordinator/learning/evaluation.h"
#include "coordinator/learning/learning_options.h"
#include "coordinator/learning/problem.h"
#include "coordinator/learning/schedule.h"
#include "coordinator/rollout_service.h"

namespace knap {

struct StudyOptions {
  std::vector<LearningMethod> methods;  // each at most once, at least one
  int seeds = 10;                       // learning seeds options.seed, options.seed + 1, …; >= 1
  LearningOptions learning;             // of every run; method, seed and, beside `ours`, rollout_budget are replaced
  int tests = 200;                      // variations that no run saw
  std::uint64_t test_seed = 1;
};

// Throws std::invalid_argument naming the option, its value and what is allowed.
void CheckStudyOptions(const StudyOptions& options);

// What each run learns with, but for the budgets that follow from `ours`: in the order of the methods as given, and of
// the seeds within one.
std::vector<LearningOptions> PlanRuns(const StudyOptions& options);

struct StudyRun {
  LearningOptions learning;  // as the run uses them
  LearningResult learned;
  TestSummary test;                    // of theta learned
  std::int64_t rollouts_total = 0;     // asked for, the tests of both designs included
  std::int64_t rollouts_distinct = 0;  // different ones among them
};

struct StudyResult {
  TestSummary initial;
  std::vector<StudyRun> runs;  // in the order of PlanRuns
};

// Follows a study. Where nothing else is said, called from the thread that belongs to the run.
class StudyObserver {
 public:
  virtual ~StudyObserver() = default;
  // Before anything is asked: the initial design's test is done. Called once, from RunStudy's own thread.
  virtual void OnInitial(const TestSummary& initial) = 0;
  // Of one run; must outlive the study.
  virtual LearningObserver& GetRunObserver(std::size_t run) = 0;
  // The run has learned and is tested. Calls do not overlap.
  virtual void OnRunEnd(std::size_t run, const StudyRun& result) = 0;
};

// Throws std::invalid_argument for bad options; otherwise what the service, or an observer, throws.
StudyResult RunStudy(const Problem& problem, const StudyOptions& options, RolloutService& service,
                     StudyObserver& observer);

// One line of a study's table.
struct MethodSummary {
  LearningMethod method{};
  SeedSpread spread;
  double success_least = 0.0, success_median = 0.0, success_most = 0.0;  // over seeds
  double rollouts_mean = 0.0;                                            // of learning
};
std::vector<MethodSummary> SummarizeMethods(const StudyOptions& options, const StudyResult& result);

}  // namespace knap
