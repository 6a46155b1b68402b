#include "coordinator/run/request_replay.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "coordinator/learning/evaluation.h"
#include "coordinator/learning/schedule.h"
#include "coordinator/run/answer_journal.h"

namespace knap {
namespace {

// How the replay ends before its end. No std::exception: nobody between here and FindRequest handles it.
struct ReplayEnded {};

class JournalReader : public RolloutService {
 public:
  JournalReader(const ContentId& scenario, std::size_t controls, std::span<const std::string> payloads, std::string id)
      : scenario_(scenario), controls_(controls), id_(std::move(id)) {
    for (const std::string& payload : payloads) {
      for (JournaledAnswer& answer : DecodeAnswers(payload)) answers_[answer.id] = std::move(answer.outcome);
    }
  }

  std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override {
    std::vector<ContentId> ids;
    for (const RolloutQuery& query : queries) {
      const std::span<const double> theta = query.theta;
      const std::size_t design = theta.size() - controls_;
      ids.push_back(CalcRequestId({"knap", scenario_, theta.first(design), theta.subspan(design), query.theta_reference,
                                   query.variation, query.gradient, query.theta_nodes}));
      if (!FormatHex(ids.back()).starts_with(id_)) continue;
      found = query;
      throw ReplayEnded();
    }
    std::vector<RolloutOutcome> outcomes;
    for (const ContentId& id : ids) {
      const auto answer = answers_.find(id);
      if (answer == answers_.end()) throw ReplayEnded();
      outcomes.push_back(answer->second);
    }
    return outcomes;
  }

  std::optional<RolloutQuery> found;

 private:
  ContentId scenario_;
  std::size_t controls_;
  std::string id_;
  std::unordered_map<ContentId, RolloutOutcome, ContentIdHash> answers_;
};

class SilentObserver : public LearningObserver {
 public:
  void OnBatchStart(const BatchStart&) override {}
  void OnEvaluation(const LearningEvaluation&) override {}
  void OnBatchBox(const BatchBox&) override {}
  void OnBatchEnd(const BatchEnd&) override {}
};

}  // namespace

std::optional<RolloutQuery> FindRequest(const ReplayedRun& run, std::span<const std::string> payloads,
                                        const std::string& id) {
  JournalReader reader(run.scenario, run.problem.parameters.controls, payloads, id);
  try {
    SilentObserver observer;
    const std::vector<double> learned = Learn(run.problem, run.options, reader, observer).theta;
    for (const std::vector<double>& theta : {run.problem.parameters.initial, learned}) {
      EvaluateDesign(run.problem.variations, theta, run.tests, run.test_seed, reader);
    }
  } catch (const ReplayEnded&) {
  }
  return reader.found;
}

}  // namespace knap
