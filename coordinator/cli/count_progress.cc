#include "coordinator/cli/count_progress.h"

#include <unistd.h>

#include "knap/run_status_t.hpp"
#include "lcmtypes/program/standard_streams.h"

namespace knap {

CountProgress::CountProgress(const std::string& scenario, const std::string& title, std::int64_t rollouts, bool quiet,
                             ClusterSession* session)
    : session_(session) {
  state_.title = title;
  state_.phase = ProgressPhase::kTesting;
  state_.tests = rollouts;
  state_.workers_wanted = session->workers_wanted();
  status_.scenario = scenario;
  status_.state = run_status_t::kEvaluating;
  if (!quiet) reporter_.emplace(WriteMessage, DetectTerminal(STDERR_FILENO));
  session_->set_on_pump([this] { Update(); });
  Update();
}

CountProgress::~CountProgress() {
  session_->set_on_pump({});
  if (reporter_) reporter_->Clear();
}

void CountProgress::Say(const std::string& line) {
  if (!reporter_) return;
  reporter_->Clear();
  WriteMessage(line + "\n");
}

void CountProgress::Finish() {
  Refresh();
  if (reporter_) reporter_->Finish(state_);
}

void CountProgress::Refresh() {
  const Dispatcher& dispatcher = session_->dispatcher();
  state_.elapsed_s = static_cast<double>(clock_.now_us() - started_us_) * 1e-6;
  state_.rollouts = dispatcher.counters().computed;
  state_.tested = state_.rollouts;
  state_.workers_alive = dispatcher.CountUsableWorkers();
  state_.retries = dispatcher.counters().reissued;
}

void CountProgress::Update() {
  Refresh();
  if (reporter_) reporter_->Update(state_);
  status_.progress = CalcDonePart(state_);
  status_.eta_s = CalcTimeLeft(state_).value_or(-1.0);
  session_->dispatcher().SetProgress(status_);
}

}  // namespace knap
