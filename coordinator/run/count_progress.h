// How many of a known number of rollouts are answered, on stderr and on LCM, for commands that ask for many at once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "coordinator/progress/progress.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/cluster_session.h"
#include "lcmtypes/wire/clock.h"

namespace knap {

class CountProgress {
 public:
  // Takes the session's pump hook until it is destroyed; the session must outlive it. Quiet: nothing on stderr.
  CountProgress(const std::string& scenario, const std::string& title, std::int64_t rollouts, bool quiet,
                ClusterSession* session);
  ~CountProgress();  // wipes the bar
  CountProgress(const CountProgress&) = delete;
  CountProgress& operator=(const CountProgress&) = delete;

  // There are more than was thought.
  void set_rollouts(std::int64_t rollouts) { state_.tests = rollouts; }

  // A line of its own on stderr; the bar goes on below it.
  void Say(const std::string& line) { shown_.Say(line + "\n"); }

  // Shows the end, and leaves it standing.
  void Finish();

  // What kept stderr from taking all of it, for the end of the result; unset: nothing did.
  const std::optional<std::string>& dropped() const { return dropped_; }

 private:
  void Refresh();
  void Update();

  ClusterSession* session_;
  SteadyClock clock_;
  const std::int64_t started_us_ = clock_.now_us();
  std::optional<std::string> dropped_;
  StderrProgress shown_;
  ProgressState state_;
  RunProgress status_;
};

// The line about it in a result for people; empty where nothing was dropped.
std::string FormatDropped(const std::optional<std::string>& dropped);

}  // namespace knap
