// How many of a known number of rollouts are answered, on stderr and on LCM, for commands that ask for many at once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "coordinator/cli/cluster_session.h"
#include "coordinator/progress/progress.h"
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
  void Say(const std::string& line);

  // Shows the end, and leaves it standing.
  void Finish();

 private:
  void Refresh();
  void Update();

  ClusterSession* session_;
  SteadyClock clock_;
  const std::int64_t started_us_ = clock_.now_us();
  std::optional<ProgressReporter> reporter_;
  ProgressState state_;
  RunProgress status_;
};

}  // namespace knap
