#include "coordinator/run/count_progress.h"

#include <fmt/format.h>

#include "knap/run_status_t.hpp"

namespace knap {

CountProgress::CountProgress(const std::string& scenario, const std::string& title, std::int64_t rollouts, bool quiet,
                             ClusterSession* session)
    : session_(session), shown_(quiet, [this](const std::string& error) { dropped_ = error; }) {
  state_.title = title;
  state_.phase = ProgressPhase::kCounting;
  state_.tests = rollouts;
  state_.workers_wanted = session->workers_wanted();
  status_.scenario = scenario;
  status_.state = run_status_t::kEvaluating;
  session_->set_on_pump([this] { Update(); });
  Update();
}

CountProgress::~CountProgress() { session_->set_on_pump({}); }

void CountProgress::Finish() {
  Refresh();
  shown_.Finish(state_);
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
  shown_.Update(state_);
  status_.progress = CalcDonePart(state_);
  status_.eta_s = CalcTimeLeft(state_).value_or(-1.0);
  session_->dispatcher().SetProgress(status_);
}

std::string FormatDropped(const std::optional<std::string>& dropped) {
  return dropped ? fmt::format("progress is not all on stderr: {}\n", *dropped) : "";
}

}  // namespace knap
