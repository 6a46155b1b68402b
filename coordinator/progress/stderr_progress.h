// Progress and summaries for people on stderr, the same way for every command that shows them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "coordinator/progress/progress.h"

namespace knap {

// What stderr does not take is dropped, and the work goes on; the command hears of it once and says so elsewhere.
class StderrProgress {
 public:
  // Quiet: nothing is shown. `on_dropped` gets what kept the first text from being written, one line.
  StderrProgress(bool quiet, std::function<void(const std::string& error)> on_dropped);
  ~StderrProgress();  // wipes the bar
  StderrProgress(const StderrProgress&) = delete;
  StderrProgress& operator=(const StderrProgress&) = delete;

  void Update(const ProgressState& state);  // shows it when it is time to (ProgressReporter)
  void Finish(const ProgressState& state);  // shows it, and leaves it standing
  void Say(std::string_view lines);         // with their line ends; the bar goes on below them

 private:
  void Note(const std::error_code& error);

  const std::function<void(const std::string&)> on_dropped_;
  bool dropped_ = false;
  std::optional<ProgressReporter> reporter_;  // none when quiet
};

}  // namespace knap
