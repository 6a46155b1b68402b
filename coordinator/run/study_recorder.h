// Writes down how a study goes while it goes: a folder for each run with metrics.csv and, when it ends, its tool and
// result.json; the progress of all on stderr; run_status_t on LCM.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/progress/progress.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/cluster_session.h"
#include "coordinator/run/prepared_scenario.h"
#include "coordinator/run_directory/run_directory.h"
#include "coordinator/run_directory/run_logs.h"
#include "coordinator/study/study.h"
#include "lcmtypes/wire/clock.h"

namespace knap {

class StudyRecorder : public StudyObserver {
 public:
  // `study` is the folder of all runs; what an earlier life left in the folders of single runs is written anew, as a
  // resumed study goes through all of it again. Takes the session's pump hook; everything must outlive the recorder.
  // Quiet: nothing on stderr. When stderr does not take something, events.jsonl in the study's folder says so.
  StudyRecorder(const PreparedScenario& prepared, const StudyOptions& options, const RunDirectory& study,
                ClusterSession* session, const JournaledService* service, bool quiet);
  ~StudyRecorder() override;

  // "ours-3": the folder of the run within the study's.
  static std::string MakeRunName(const LearningOptions& options);

  void OnInitial(const TestSummary& initial) override;
  LearningObserver& GetRunObserver(std::size_t run) override { return followers_[run]; }
  void OnRunEnd(std::size_t run, const StudyRun& result) override;

  // Shows the end of the study, and finishes the session.
  void Finish();

  // Lines for people, on stderr unless quiet.
  void Say(std::string_view lines) { shown_.Say(lines); }

  double elapsed_s() const;  // since construction

 private:
  // One run's learning; everything but `done` belongs to the run's own thread.
  class Follower : public LearningObserver {
   public:
    Follower(const std::filesystem::path& metrics, const std::vector<std::string>& parameter_names,
             const StudyRecorder* recorder)
        : metrics_(metrics, parameter_names), recorder_(recorder) {}
    void OnBatchStart(const BatchStart& start) override;
    void OnEvaluation(const LearningEvaluation& evaluation) override;
    void OnBatchBox(const BatchBox&) override {}
    void OnBatchEnd(const BatchEnd&) override {}
    void OnValidation(const BatchValidation& validation) override;

    std::atomic<double> done{0.0};  // part of its learning, in [0, 1]

   private:
    MetricsLog metrics_;
    const StudyRecorder* recorder_;
    BatchStart batch_;
  };

  void Pump();
  void RecordDropped(const std::string& error) noexcept;
  void ShowProgress();

  const PreparedScenario& prepared_;
  const RunDirectory& study_;
  ClusterSession* session_;
  const JournaledService* service_;
  SteadyClock clock_;
  const std::int64_t started_us_;
  std::vector<RunDirectory> folders_;  // of the runs
  std::deque<Follower> followers_;
  StderrProgress shown_;
  std::mutex mutex_;  // guards the rest
  std::vector<std::string> news_;
  std::optional<TestSummary> initial_;
  int ended_ = 0;
};

}  // namespace knap
