#include "coordinator/progress/stderr_progress.h"

#include <unistd.h>

#include <utility>

#include "lcmtypes/program/standard_streams.h"

namespace knap {

StderrProgress::StderrProgress(bool quiet, std::function<void(const std::string&)> on_dropped)
    : on_dropped_(std::move(on_dropped)) {
  if (quiet) return;
  reporter_.emplace([this](std::string_view text) { Note(DrawMessage(text)); }, DetectTerminal(STDERR_FILENO));
}

StderrProgress::~StderrProgress() {
  if (reporter_) reporter_->Clear();
}

void StderrProgress::Update(const ProgressState& state) {
  if (reporter_) reporter_->Update(state);
}

void StderrProgress::Finish(const ProgressState& state) {
  if (reporter_) reporter_->Finish(state);
}

void StderrProgress::Say(std::string_view lines) {
  if (!reporter_) return;
  reporter_->Clear();
  Note(WriteMessage(lines));
}

void StderrProgress::Note(const std::error_code& error) {
  if (error && !std::exchange(dropped_, true)) on_dropped_(error.message());
}

}  // namespace knap
