// How a run went, or goes, from the files that it writes meanwhile: metrics.csv, rollouts.csv, events.jsonl.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/run_directory/growing_file.h"
#include "coordinator/run_directory/run_directory.h"

namespace knap {

class RunHistory {
 public:
  explicit RunHistory(const RunDirectory& run);

  // Takes what the run has written since the last call: the work is that of the new lines alone, and half lines wait.
  // Throws std::system_error when a file cannot be read.
  void Read();

  // The objects of events.jsonl, in order.
  const std::vector<nlohmann::ordered_json>& events() const { return events_; }

  // For the report's page (page/README.md): one entry an optimizer evaluation, a batch, a validation.
  nlohmann::ordered_json MakeLearningJson() const;
  // Who computed what and when. Of a long run every k-th rollout, `every` says which k.
  nlohmann::ordered_json MakeTimelineJson() const;
  // What the rollouts' certificates add up to.
  nlohmann::ordered_json MakeCertificatesJson() const;

 private:
  static constexpr std::array<const char*, 11> kMetrics = {
      "time_s",    "batch",    "loss",      "task_loss", "distillation_loss", "gradient_norm",
      "best_loss", "accepted", "successes", "rollouts",  "untrusted"};

  struct Rollout {
    int worker, kind;  // by their places in workers_ and kinds_
    double attempt, end_s, duration_s;
  };

  void ReadEvents();
  void ReadMetrics();
  void ReadRollouts();
  void RestartMetrics();

  GrowingFile event_lines_, metric_lines_, rollout_lines_;
  std::string metrics_header_, rollouts_header_;  // with their ends; empty: not read yet
  int lives_ = 0;
  std::vector<nlohmann::ordered_json> events_;
  std::array<std::vector<double>, kMetrics.size()> metrics_;
  std::vector<std::string> workers_, kinds_;
  std::vector<Rollout> rollouts_;
  std::int64_t gradients_ = 0, flagged_ = 0, untrusted_ = 0, not_converged_ = 0;
  double deepest_ = 0.0, largest_force_ = 0.0;
};

}  // namespace knap
