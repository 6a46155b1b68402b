// How long rollouts take, and what follows from it: who straggles, and how much a worker should hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace knap {

class BatchPace {
 public:
  // A batch of so many requests begins; what earlier ones took still counts.
  void Begin(std::size_t requests) { requests_ = requests; }

  // A rollout took so long, by the coordinator's clock from its begin on a worker to its answer.
  void Record(std::int64_t duration_us);

  // Of the latest 256 rollouts; -1 before the first.
  std::int64_t CalcMedianUs() const;

  // True when three quarters of the batch are answered (`open` are not) and a rollout that has run for age_us has taken
  // more than 1.5 times the median, and 20 ms more: below that a second copy costs more than it can win.
  bool IsStraggling(std::int64_t age_us, std::size_t open) const;

  // Requests that one worker should hold: what keeps it busy for 20 ms, so that short rollouts do not wait for the next
  // request; at least `least`, at most kMaxQueue.
  int CalcCredits(int least) const;

 private:
  std::size_t requests_ = 0;
  std::deque<std::int64_t> durations_us_;
};

}  // namespace knap
