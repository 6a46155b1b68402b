#include "coordinator/run/training_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "coordinator/progress/progress.h"
#include "coordinator/run/runs_progress.h"
#include "coordinator/run_directory/run_logs.h"

namespace knap {

TrainingRecorder::TrainingRecorder(const std::string& scenario, const DemonstrationOptions& options,
                                   const RunDirectory& folder, ClusterSession* session, const JournaledService* service,
                                   bool quiet)
    : scenario_(scenario),
      max_evaluations_(options.learning.max_evaluations),
      rounds_(options.rounds),
      folder_(folder),
      session_(session),
      service_(service),
      started_us_(clock_.now_us()),
      shown_(quiet, [this](const std::string& error) { RecordDropped(error); }) {
  session_->set_on_pump([this] { Pump(); });
}

TrainingRecorder::~TrainingRecorder() { session_->set_on_pump({}); }

DemonstrationObserver TrainingRecorder::MakeObserver() {
  DemonstrationObserver observer;
  observer.on_round = [this](int round, std::size_t variations) {
    const std::lock_guard lock(mutex_);
    round_ = round;
    tried_ = static_cast<int>(variations);
    ended_ = 0;
    evaluations_ = 0;
    if (round > 0) news_.push_back(fmt::format("round {}: {} try again from the nearest success", round, variations));
  };
  observer.on_evaluation = [this](std::size_t) { ++evaluations_; };
  observer.on_end = [this](std::size_t variation, const Demonstration& demonstration) {
    evaluations_ += max_evaluations_ - demonstration.evaluations;  // here those of the round
    const char* how = demonstration.success ? "succeeded" : demonstration.trusted ? "failed" : "not to be trusted";
    const std::lock_guard lock(mutex_);
    ++ended_;
    news_.push_back(fmt::format("demonstration {:>3}: {}, loss {:.4g} after {} evaluations", variation, how,
                                demonstration.loss, demonstration.evaluations));
  };
  return observer;
}

double TrainingRecorder::elapsed_s() const { return static_cast<double>(clock_.now_us() - started_us_) * 1e-6; }

void TrainingRecorder::Finish() {
  finished_ = true;
  Pump();
  session_->set_on_pump({});
  session_->Finish();
}

void TrainingRecorder::RecordDropped(const std::string& error) noexcept try {
  EventLog(folder_.events_path()).Append(elapsed_s(), "progress_dropped", {{"error", error}});
} catch (const std::exception&) {
  // The disk takes neither; no line is worth the training.
}

void TrainingRecorder::Pump() {
  std::vector<std::string> news;
  ProgressState state;
  int round = 0;
  {
    const std::lock_guard lock(mutex_);
    news = std::exchange(news_, {});
    state.runs_done = ended_;
    state.runs = tried_;
    round = round_;
  }
  for (const std::string& line : news) shown_.Say(line + "\n");
  state.title = scenario_ + " demonstrations";
  state.elapsed_s = elapsed_s();
  // Rounds as if all were as long: later ones try fewer, so that the estimate errs on the long side.
  const double within =
      static_cast<double>(evaluations_) / (std::max(1.0, static_cast<double>(state.runs)) * max_evaluations_);
  state.study_part = finished_ ? 1.0 : (round + std::min(1.0, within)) / rounds_;
  ShowRunsProgress(state, finished_, scenario_, "train-policy", *service_, session_, &shown_);
}

}  // namespace knap
