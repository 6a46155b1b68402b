// Writes down how a run goes while it goes: metrics.csv, rollouts.csv and events.jsonl in its folder, the progress on
// stderr, run_status_t on LCM.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/learning/schedule.h"
#include "coordinator/progress/progress.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/cluster_session.h"
#include "coordinator/run_directory/earlier_life.h"
#include "coordinator/run_directory/run_directory.h"
#include "coordinator/run_directory/run_logs.h"
#include "lcmtypes/wire/clock.h"

namespace knap {

struct RunPlan {
  std::string scenario;
  std::string method;
  std::vector<std::string> parameter_names;
  std::string loss_unit;  // FormatLossUnit
  int tests = 0;          // rollouts of the test that follows
  int replays = 0;        // of the report behind it
  bool has_success = false;
};

class RunRecorder : public LearningObserver {
 public:
  // Takes the session's pump hook and the service's answer hook; both must outlive it. Quiet: nothing on stderr.
  RunRecorder(const RunPlan& plan, const RunDirectory& run, ClusterSession* session, JournaledService* service,
              bool quiet);
  ~RunRecorder() override;

  void OnBatchStart(const BatchStart& start) override;
  void OnEvaluation(const LearningEvaluation& evaluation) override;
  void OnBatchBox(const BatchBox& box) override;
  void OnBatchEnd(const BatchEnd& end) override;
  void OnValidationStart() override;
  void OnValidation(const BatchValidation& validation) override;

  void BeginTest();
  // Finishes the session.
  void FinishTest();
  // So many of the report's rollouts are simulated.
  void ShowReplay(int done, int total);
  // Nothing follows but lines for people.
  void ShowEnd();

  // A line of events.jsonl.
  void RecordEvent(const std::string& event, const nlohmann::ordered_json& details);
  // The same, dropped when the disk does not take it: for what must not hide how the run ended, nor end it.
  void TryRecordEvent(const std::string& event, const nlohmann::ordered_json& details) noexcept;
  // Likewise the last one of a run that was broken off, behind what went wrong until then.
  void TryRecordEnd(const std::string& event, const nlohmann::ordered_json& details) noexcept;

  // Lines for people, on stderr unless quiet.
  void Say(std::string_view lines) { shown_.Say(lines); }

  // Since construction, and the time that earlier programs worked on the run; likewise the requests given again.
  double elapsed_s() const;
  std::int64_t reissued() const;

 private:
  void Pump();
  void RecordAnswer(const RolloutReport& report);
  void RecordLosses();    // of workers
  void RecordTroubles();  // of requests
  void PublishProgress();

  const RunPlan plan_;
  SteadyClock clock_;
  const std::int64_t started_us_;
  const EarlierLife earlier_;  // read before the logs are opened
  ClusterSession* session_;
  JournaledService* service_;
  MetricsLog metrics_;
  RolloutLog rollouts_;
  EventLog events_;
  StderrProgress shown_;  // events.jsonl says so when something is dropped
  ProgressState state_;
  std::int64_t work_started_us_;
  std::int64_t test_begin_total_ = 0;
  RunProgress progress_;
  struct Trouble {
    double time_s = 0.0;
    RequestTrouble what;
  };
  std::vector<Trouble> troubles_;  // not yet recorded
  DispatchCounters last_counters_;
  int last_restarts_ = 0;
  std::set<std::int64_t> told_workers_;  // workers
};

}  // namespace knap
