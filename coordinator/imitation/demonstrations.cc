#include "coordinator/imitation/demonstrations.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/schedule.h"
#include "coordinator/study/shared_service.h"

namespace knap {
namespace {

class EvaluationCount : public LearningObserver {
 public:
  explicit EvaluationCount(std::function<void()> on_evaluation) : on_evaluation_(std::move(on_evaluation)) {}

  void OnBatchStart(const BatchStart&) override {}
  void OnEvaluation(const LearningEvaluation&) override {
    ++count_;
    if (on_evaluation_) on_evaluation_();
  }
  void OnBatchBox(const BatchBox&) override {}
  void OnBatchEnd(const BatchEnd&) override {}

  int count() const { return count_; }

 private:
  std::function<void()> on_evaluation_;
  int count_ = 0;
};

class Search {
 public:
  Search(const Problem& problem, const DemonstrationOptions& options, RolloutService* service,
         const DemonstrationObserver* observer)
      : problem_(problem), options_(options), service_(service), observer_(observer) {
    learning_ = options.learning;
    learning_.method = LearningMethod::kDiffHand;
    learning_.variations = 1;
    learning_.batch = 1;
    learning_.validation = 0;
    learning_.rollout_budget.reset();
    learning_.seed = options.seed;
    CheckProblem(problem);
    CheckLearningOptions(learning_, problem.parameters.names.size());
    for (int i = 0; i < options.variations; ++i) {
      found_.push_back({.variation = SampleVariation(problem.variations, options.seed, RandomStream::kDemonstrations,
                                                     static_cast<std::uint64_t>(i))});
    }
  }

  std::vector<Demonstration> Run() {
    for (int round = 0; round < options_.rounds; ++round) {
      const std::vector<Start> starts = ListStarts(round);
      if (starts.empty()) break;
      if (observer_->on_round) observer_->on_round(round, starts.size());
      bool any = false;
      std::vector<Demonstration> tried(starts.size());
      RunTogether(service_, starts.size(), [&](std::size_t i, RolloutService* service) {
        tried[i] = Try(starts[i], round, *service);
        if (observer_->on_end) observer_->on_end(starts[i].variation, tried[i]);
      });
      for (std::size_t i = 0; i < starts.size(); ++i) {
        Demonstration& so_far = found_[starts[i].variation];
        tried[i].evaluations += so_far.evaluations;
        any = any || tried[i].success;
        if (round == 0 || tried[i].success) {
          so_far = std::move(tried[i]);
        } else {
          so_far.evaluations = tried[i].evaluations;
        }
      }
      if (!any) break;
    }
    return std::move(found_);
  }

 private:
  struct Start {
    std::size_t variation = 0;
    std::vector<double> theta;
  };

  // What is tried in the round: all, then those that have not succeeded, while others have.
  std::vector<Start> ListStarts(int round) const {
    std::vector<Start> starts;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (round == 0) {
        starts.push_back({i, problem_.parameters.initial});
      } else if (!found_[i].success) {
        if (const Demonstration* nearest = FindNearestSuccess(found_[i].variation)) {
          starts.push_back({i, nearest->theta});
        }
      }
    }
    return starts;
  }

  const Demonstration* FindNearestSuccess(const std::vector<double>& variation) const {
    const std::vector<DrawRange> ranges = ListDrawRanges(problem_.variations);
    const Demonstration* nearest = nullptr;
    double least = 0.0;
    for (const Demonstration& other : found_) {
      if (!other.success) continue;
      double distance = 0.0;
      for (std::size_t k = 0; k < ranges.size(); ++k) {
        const double range = ranges[k].upper - ranges[k].lower;
        const double share = range > 0.0 ? (variation[k] - other.variation[k]) / range : 0.0;
        distance += share * share;
      }
      if (nearest == nullptr || distance < least) {
        nearest = &other;
        least = distance;
      }
    }
    return nearest;
  }

  Demonstration Try(const Start& start, int round, RolloutService& service) const {
    Demonstration result{.variation = found_[start.variation].variation, .round = round};
    EvaluationCount count([&] {
      if (observer_->on_evaluation) observer_->on_evaluation(start.variation);
    });
    result.theta = Learn(MakeSingle(start), learning_, service, count).theta;
    result.evaluations = count.count();
    const std::vector<RolloutQuery> query{
        {.theta = result.theta, .theta_reference = {}, .variation = result.variation, .gradient = false}};
    const RolloutOutcome outcome = EvaluateAll(service, query).front();
    result.trusted = IsTrusted(outcome, 0) && outcome.certificate.distrust.empty();
    result.loss = outcome.loss;
    result.success = result.trusted && (outcome.success || !options_.has_success);
    return result;
  }

  // The problem in one variation alone.
  Problem MakeSingle(const Start& start) const {
    Problem single{.parameters = problem_.parameters, .variations = {}};
    single.parameters.initial = start.theta;
    const std::vector<std::string> names = ListNames(problem_.variations);
    for (std::size_t i = 0; i < names.size(); ++i) {
      single.variations.push_back(
          {.names = {names[i]}, .distribution = ChoiceDraw{{found_[start.variation].variation[i]}}});
    }
    return single;
  }

  const Problem& problem_;
  const DemonstrationOptions& options_;
  RolloutService* const service_;
  const DemonstrationObserver* const observer_;
  LearningOptions learning_;
  std::vector<Demonstration> found_;
};

}  // namespace

std::vector<Demonstration> FindDemonstrations(const Problem& problem, const DemonstrationOptions& options,
                                              RolloutService& service, const DemonstrationObserver& observer) {
  const auto require = [](int value, const char* name) {
    if (value >= 1) return;
    throw std::invalid_argument(std::string("demonstrations: ") + name + " is " + std::to_string(value) +
                                "; 1 or more are allowed");
  };
  require(options.variations, "variations");
  require(options.rounds, "rounds");
  return Search(problem, options, &service, &observer).Run();
}

}  // namespace knap
