#include "coordinator/study/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/study/shared_service.h"
#include "tests/coordinator/closed_form_service.h"
#include "tests/coordinator/schedule_fixture.h"

namespace knap {
namespace study_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

class StudyRecorder : public StudyObserver {
 public:
  explicit StudyRecorder(std::size_t runs) : observers(runs) {}
  void OnInitial(const TestSummary& initial) override { initials.push_back(initial.loss_mean); }
  LearningObserver& GetRunObserver(std::size_t run) override { return observers[run]; }
  void OnRunEnd(std::size_t run, const StudyRun& result) override {
    ended.push_back(run);
    rollouts.push_back(result.learned.rollouts);
  }

  std::deque<Recorder> observers;
  std::vector<double> initials;
  std::vector<std::size_t> ended;
  std::vector<std::int64_t> rollouts;
};

StudyOptions MakeStudyOptions() {
  StudyOptions options;
  options.methods = {LearningMethod::kSimpleContinual, LearningMethod::kOurs, LearningMethod::kDiffHand};
  options.seeds = 3;
  options.learning = MakeOptions();
  options.learning.variations = 20;
  options.learning.seed = 40;
  options.tests = 30;
  return options;
}

RolloutQuery MakeQuery(double theta) {
  RolloutQuery query;
  query.theta = {theta};
  query.variation = {0.0};
  return query;
}

TEST(Study, EveryRunHasTheBitsItHasAlone) {
  const StudyOptions options = MakeStudyOptions();
  QuadraticService service(kWeights, kOptimum);
  StudyRecorder recorder(9);
  const Problem problem = MakeProblem();
  const StudyResult result = RunStudy(problem, options, service, recorder);
  ASSERT_EQ(result.runs.size(), 9u);
  EXPECT_EQ(recorder.ended.size(), 9u);
  EXPECT_EQ(recorder.initials.size(), 1u);
  for (std::size_t i = 0; i < 9; ++i) {
    const StudyRun& run = result.runs[i];
    EXPECT_EQ(run.learning.method, options.methods[i / 3]);
    EXPECT_EQ(run.learning.seed, 40u + i % 3);
    QuadraticService alone(kWeights, kOptimum);
    Recorder observer;
    const LearningResult learned = Learn(problem, run.learning, alone, observer);
    EXPECT_EQ(run.learned.theta, learned.theta);
    EXPECT_EQ(run.learned.rollouts, learned.rollouts);
    EXPECT_EQ(recorder.observers[i].evaluations.size(), observer.evaluations.size());
    EXPECT_LT(run.test.loss_mean, result.initial.loss_mean);
    EXPECT_EQ(run.rollouts_total, learned.rollouts + 60);
  }
}

TEST(Study, OtherMethodsGetTheRolloutsThatOursUsedWithTheSameSeed) {
  QuadraticService service(kWeights, kOptimum);
  StudyRecorder recorder(9);
  const StudyResult result = RunStudy(MakeProblem(), MakeStudyOptions(), service, recorder);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t ours = result.runs[3 + k].learned.rollouts;
    EXPECT_FALSE(result.runs[3 + k].learning.rollout_budget.has_value());
    for (const std::size_t i : {k, 6 + k}) {
      EXPECT_EQ(result.runs[i].learning.rollout_budget, ours);
      EXPECT_LE(result.runs[i].learned.rollouts, ours);
    }
  }
}

TEST(Study, WithoutOursNobodyHasABudget) {
  StudyOptions options = MakeStudyOptions();
  options.methods = {LearningMethod::kDiffHand};
  QuadraticService service(kWeights, kOptimum);
  StudyRecorder recorder(3);
  for (const StudyRun& run : RunStudy(MakeProblem(), options, service, recorder).runs) {
    EXPECT_FALSE(run.learning.rollout_budget.has_value());
  }
}

TEST(Study, TablesTheMethodsOverTheSeeds) {
  StudyOptions options = MakeStudyOptions();
  options.methods = {LearningMethod::kOurs};
  StudyResult result;
  for (const double rate : {0.9, 0.2, 0.4}) {
    StudyRun& run = result.runs.emplace_back();
    run.learning.method = LearningMethod::kOurs;
    run.learned.rollouts = 100 + static_cast<std::int64_t>(100 * rate);
    run.test.success_rate = rate;
  }
  const std::vector<MethodSummary> summaries = SummarizeMethods(options, result);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_DOUBLE_EQ(summaries[0].success_least, 0.2);
  EXPECT_DOUBLE_EQ(summaries[0].success_median, 0.4);
  EXPECT_DOUBLE_EQ(summaries[0].success_most, 0.9);
  EXPECT_DOUBLE_EQ(summaries[0].spread.success_rate.mean, 0.5);
  EXPECT_DOUBLE_EQ(summaries[0].rollouts_mean, 150.0);
}

TEST(Study, AFailingServiceEndsAllRuns) {
  QuadraticService service(kWeights, kOptimum);
  service.spoil = [&](const RolloutQuery&, RolloutOutcome&) {
    if (service.calls.size() == 5) throw std::runtime_error("the cluster burns");
  };
  StudyRecorder recorder(9);
  EXPECT_THAT([&] { RunStudy(MakeProblem(), MakeStudyOptions(), service, recorder); },
              ThrowsMessage<std::runtime_error>("the cluster burns"));
  EXPECT_TRUE(recorder.ended.empty());
}

TEST(Study, AFailingRunLetsTheOthersFinish) {
  class Saboteur : public StudyRecorder {
   public:
    using StudyRecorder::StudyRecorder;
    LearningObserver& GetRunObserver(std::size_t run) override {
      if (run == 4) throw std::runtime_error("disk full");
      return StudyRecorder::GetRunObserver(run);
    }
  };
  QuadraticService service(kWeights, kOptimum);
  Saboteur recorder(9);
  EXPECT_THAT([&] { RunStudy(MakeProblem(), MakeStudyOptions(), service, recorder); },
              ThrowsMessage<std::runtime_error>("disk full"));
  EXPECT_THAT(recorder.ended, testing::UnorderedElementsAre(3, 5));  // `ours`, before the others begin
}

TEST(Study, BadOptionsAreNamed) {
  QuadraticService service(kWeights, kOptimum);
  StudyRecorder recorder(9);
  StudyOptions options = MakeStudyOptions();
  options.seeds = 0;
  EXPECT_THAT([&] { RunStudy(MakeProblem(), options, service, recorder); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("seeds is 0")));
  options = MakeStudyOptions();
  options.methods.push_back(LearningMethod::kOurs);
  EXPECT_THAT([&] { RunStudy(MakeProblem(), options, service, recorder); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("ours is given twice")));
}

// Members with different numbers of questions: while all ask, each round holds one question set of each, in order.
TEST(SharedService, ARoundHoldsOneCallOfEveryMember) {
  QuadraticService service({1.0}, {0.0});
  SharedService shared(&service, 3);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 3; ++i) {
    threads.emplace_back([&shared, i] {
      for (std::size_t round = 0; round <= i; ++round) {
        const double theta = static_cast<double>(10 * i + round);
        const std::vector<RolloutQuery> queries(i + 1, MakeQuery(theta));
        const std::vector<RolloutOutcome> outcomes = shared.member(i).Evaluate(queries);
        ASSERT_EQ(outcomes.size(), i + 1);
        for (const RolloutOutcome& outcome : outcomes) EXPECT_DOUBLE_EQ(outcome.loss, theta * theta);
      }
      shared.Leave(i);
    });
  }
  shared.Serve();
  for (std::thread& thread : threads) thread.join();
  std::vector<std::vector<double>> rounds;
  for (const std::vector<RolloutQuery>& call : service.calls) {
    rounds.emplace_back();
    for (const RolloutQuery& query : call) rounds.back().push_back(query.theta[0]);
  }
  EXPECT_THAT(rounds, ElementsAre(ElementsAre(0, 10, 10, 20, 20, 20), ElementsAre(11, 11, 21, 21, 21),
                                  ElementsAre(22, 22, 22)));
}

}  // namespace study_test
}  // namespace knap
