// The run's growing files: metrics.csv, rollouts.csv and events.jsonl [README.md].
//
// Each row reaches the kernel before the call returns, so a killed program loses none. Numbers are written in the
// shortest form that reads back to the same bits; a rejected evaluation shows inf. Failures throw std::system_error.
//
// Times are seconds that programs have worked on the run: after a resume they go on from where the one before stopped.
// On resume, events.jsonl and rollouts.csv go on where they stopped, without the half line a crash may have left.
// metrics.csv begins anew: the resumed run repeats every evaluation from the journal, and its rows with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "coordinator/learning/schedule.h"
#include "coordinator/run_directory/durable_file.h"

namespace knap {

// metrics.csv: one row an optimizer evaluation. Columns: time_s, batch, evaluation, loss, task_loss, distillation_loss,
// gradient_norm, best_loss, accepted (0 or 1), successes, rollouts (so far), untrusted, validation_loss and
// validation_success of the design that the batch began with (comparable from batch to batch; empty without
// validation), then each parameter by name.
class MetricsLog {
 public:
  MetricsLog(const std::filesystem::path& path, const std::vector<std::string>& parameter_names);

  // time_s: seconds of work on the run. Written with microseconds, and moved up by the least amount that keeps
  // the column strictly increasing.
  void Append(double time_s, const LearningEvaluation& evaluation);
  // What the rows of the next batch tell. Without a success test its rate is left empty.
  void SetValidation(const BatchValidation& validation, bool has_success);

 private:
  DurableFile file_;
  std::int64_t last_time_us_ = -1;
  std::string validation_ = ",";  // both columns
};

struct RolloutRow {
  double time_s = 0.0;            // when the answer came, seconds of work on the run
  std::string id;                 // the request's content id
  std::string kind;               // task, distillation, start, test, …
  std::vector<double> variation;  // one column, values separated by spaces
  std::string worker;
  int attempt = 1;  // the lease that was answered, from 1
  double loss = 0.0;
  bool success = false, converged = false, gradient_reliable = false;
  double loss_error =
      std::numeric_limits<double>::quiet_NaN();  // what time steps and rounding do to it; NaN: not known
  double penetration = 0.0;                      // the deepest contact, as a share of what the thinner body has
  double largest_force = 0.0;                    // of one contact [N]
  std::string distrust{};                        // why it is not to be trusted; empty: nothing tells against it
  double forward_s = 0.0, gradient_s = 0.0;      // the worker's own wall times
  // From the question, and from when this worker was given it, to the answer; NaN: not known.
  double waited_s = std::numeric_limits<double>::quiet_NaN();
  double held_s = std::numeric_limits<double>::quiet_NaN();
};

// rollouts.csv: one row a rollout result. Columns as the members above, in the order id, kind, variation, worker,
// attempt, loss, success, converged, gradient_reliable, loss_error, penetration, largest_force, distrust, time_s,
// forward_s, gradient_s, waited_s, held_s; empty where loss_error and the last two are not known.
class RolloutLog {
 public:
  explicit RolloutLog(const std::filesystem::path& path);
  void Append(const RolloutRow& row);

 private:
  DurableFile file_;
};

// The rows of such a file, in order. What it does not hold, as one of an earlier version may not, is as in a new row.
std::vector<RolloutRow> ReadRollouts(const std::filesystem::path& path);

// The objects of whole lines of events.jsonl, in order. What is none, such as the half line that a crash left, is
// passed over.
std::vector<nlohmann::ordered_json> ParseEvents(const std::string& lines);

// events.jsonl: one JSON object a line, beginning with time_s and event.
class EventLog {
 public:
  explicit EventLog(const std::filesystem::path& path);
  // details: an object whose members follow the two. Throws std::runtime_error when a number in it is not finite.
  void Append(double time_s, const std::string& event, const nlohmann::ordered_json& details);

 private:
  DurableFile file_;
};

}  // namespace knap
