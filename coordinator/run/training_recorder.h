// Shows how far the demonstrations of a policy's training are: on stderr, and on LCM as run_status_t.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/imitation/demonstrations.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/cluster_session.h"
#include "coordinator/run_directory/run_directory.h"
#include "lcmtypes/wire/clock.h"

namespace knap {

class TrainingRecorder {
 public:
  // Takes the session's pump hook; everything must outlive the recorder. Quiet: nothing on stderr. When stderr does not
  // take something, events.jsonl in the folder says so.
  TrainingRecorder(const std::string& scenario, const DemonstrationOptions& options, const RunDirectory& folder,
                   ClusterSession* session, const JournaledService* service, bool quiet);
  ~TrainingRecorder();
  TrainingRecorder(const TrainingRecorder&) = delete;
  TrainingRecorder& operator=(const TrainingRecorder&) = delete;

  // What FindDemonstrations is to be given.
  DemonstrationObserver MakeObserver();

  // All demonstrations are there: shows it and finishes the session.
  void Finish();

  // Lines for people, on stderr unless quiet.
  void Say(std::string_view lines) { shown_.Say(lines); }

  double elapsed_s() const;  // since construction

 private:
  void Pump();
  void RecordDropped(const std::string& error) noexcept;

  const std::string scenario_;
  const int max_evaluations_, rounds_;
  const RunDirectory& folder_;
  ClusterSession* session_;
  const JournaledService* service_;
  SteadyClock clock_;
  const std::int64_t started_us_;
  StderrProgress shown_;
  bool finished_ = false;
  std::atomic<std::int64_t> evaluations_{0};  // of the round; what ends early is credited with all it might have taken
  std::mutex mutex_;                          // guards the rest
  std::vector<std::string> news_;
  int round_ = 0, tried_ = 0, ended_ = 0;  // ended_ of the tried_ in this round
};

}  // namespace knap
