#include "coordinator/watch/prometheus_text.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <limits>

namespace knap {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

// What one entry of the view gives to one metric.
template <class Entry>
struct Metric {
  const char* name;
  const char* type;  // counter or gauge
  const char* help;
  double (*get)(const Entry& entry, std::int64_t now_us);
};

constexpr Metric<WatchedRun> kRunMetrics[] = {
    {"knap_run_progress_ratio", "gauge", "Share of the run that is done.",
     [](const WatchedRun& r, std::int64_t) { return r.status.progress; }},
    {"knap_run_state", "gauge", "0 waiting, 1 learning, 2 evaluating, 3 done.",
     [](const WatchedRun& r, std::int64_t) { return r.status.state * 1.0; }},
    {"knap_run_eta_seconds", "gauge", "Estimated time to the end.",
     [](const WatchedRun& r, std::int64_t) { return r.status.eta_s >= 0.0 ? r.status.eta_s : kNotKnown; }},
    {"knap_run_elapsed_seconds", "counter", "Work on the run so far.",
     [](const WatchedRun& r, std::int64_t) { return r.status.elapsed_s; }},
    {"knap_run_loss", "gauge", "Latest objective, in the unit of the scenario's loss.",
     [](const WatchedRun& r, std::int64_t) { return r.status.loss; }},
    {"knap_run_best_loss", "gauge", "Best objective of the present batch.",
     [](const WatchedRun& r, std::int64_t) { return r.status.best_loss; }},
    {"knap_run_gradient_norm", "gauge", "Norm of the gradient in range-normalised parameters.",
     [](const WatchedRun& r, std::int64_t) { return r.status.grad_norm; }},
    {"knap_run_batch", "gauge", "Present batch, from 1.",
     [](const WatchedRun& r, std::int64_t) { return r.status.batch * 1.0; }},
    {"knap_run_batches", "gauge", "Batches of the run.",
     [](const WatchedRun& r, std::int64_t) { return r.status.batch_count * 1.0; }},
    {"knap_run_evaluations_total", "counter", "Evaluations of the objective.",
     [](const WatchedRun& r, std::int64_t) { return r.status.iteration * 1.0; }},
    {"knap_run_workers", "gauge", "Workers that take requests.",
     [](const WatchedRun& r, std::int64_t) { return r.status.workers * 1.0; }},
    {"knap_run_requests_open", "gauge", "Requests without an answer.",
     [](const WatchedRun& r, std::int64_t) { return r.status.requests_open * 1.0; }},
    {"knap_run_rollouts_total", "counter", "Answers.",
     [](const WatchedRun& r, std::int64_t) { return r.status.requests_done * 1.0; }},
    {"knap_run_requests_reissued_total", "counter", "Requests given to another worker.",
     [](const WatchedRun& r, std::int64_t) { return r.status.requests_reissued * 1.0; }},
    {"knap_run_rollouts_untrusted_total", "counter", "Answers that failed or are not to be trusted.",
     [](const WatchedRun& r, std::int64_t) { return r.status.rollouts_untrusted * 1.0; }},
    {"knap_run_gradients_flagged_total", "counter", "Answers whose gradient may not be the problem's.",
     [](const WatchedRun& r, std::int64_t) { return r.status.gradients_flagged * 1.0; }},
    {"knap_run_messages_refused_total", "counter", "Corrupt, foreign or malformed messages.",
     [](const WatchedRun& r, std::int64_t) { return r.status.messages_refused * 1.0; }},
    {"knap_run_silence_seconds", "gauge", "Since its latest status.",
     [](const WatchedRun& r, std::int64_t now_us) { return CalcAge(r.heard_us, now_us); }},
};

constexpr Metric<WatchedWorker> kWorkerMetrics[] = {
    {"knap_worker_state", "gauge", "0 idle, 1 loading, 2 computing, 3 stopping.",
     [](const WatchedWorker& w, std::int64_t) { return w.status.state * 1.0; }},
    {"knap_worker_busy_ratio", "gauge", "Share of the time spent computing.",
     [](const WatchedWorker& w, std::int64_t) { return w.status.busy_fraction; }},
    {"knap_worker_finished_total", "counter", "Requests answered.",
     [](const WatchedWorker& w, std::int64_t) { return static_cast<double>(w.status.finished); }},
    {"knap_worker_repeated_total", "counter", "Requests answered from memory.",
     [](const WatchedWorker& w, std::int64_t) { return static_cast<double>(w.status.repeated); }},
    {"knap_worker_refused_total", "counter", "Messages refused.",
     [](const WatchedWorker& w, std::int64_t) { return static_cast<double>(w.status.refused); }},
    {"knap_worker_compute_seconds", "gauge", "Wall time of the last finished request.",
     [](const WatchedWorker& w, std::int64_t) { return w.status.compute_s; }},
    {"knap_worker_queued", "gauge", "Requests taken and not answered.",
     [](const WatchedWorker& w, std::int64_t) { return w.status.queue_size / 32.0; }},
    {"knap_worker_silence_seconds", "gauge", "Since its latest status.",
     [](const WatchedWorker& w, std::int64_t now_us) { return CalcAge(w.heard_us, now_us); }},
};

// A label's value may hold anything but these three, which are escaped.
std::string Quote(const std::string& value) {
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '\n') {
      quoted += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string FormatInstance(std::int64_t number) { return fmt::format("{:016x}", static_cast<std::uint64_t>(number)); }

std::string FormatLabels(const WatchedRun& run) {
  return fmt::format("scenario={},method={},run=\"{}\"", Quote(run.status.scenario), Quote(run.status.method),
                     FormatInstance(run.status.run_id));
}

std::string FormatLabels(const WatchedWorker& worker) {
  return fmt::format("worker={},host={},engine={},instance=\"{}\"", Quote(worker.status.name),
                     Quote(worker.status.host), Quote(worker.status.engine), FormatInstance(worker.status.sender));
}

template <class Entries, class Metrics>
void Append(const Entries& entries, const Metrics& metrics, std::int64_t now_us, std::string* text) {
  const auto out = std::back_inserter(*text);
  for (const auto& metric : metrics) {
    bool said = false;
    for (const auto& [number, entry] : entries) {
      const double value = metric.get(entry, now_us);
      if (std::isnan(value)) continue;
      if (!said) fmt::format_to(out, "# HELP {0} {1}\n# TYPE {0} {2}\n", metric.name, metric.help, metric.type);
      said = true;
      // As the format writes them.
      const std::string number_text = std::isinf(value) ? (value > 0 ? "+Inf" : "-Inf") : fmt::format("{}", value);
      fmt::format_to(out, "{}{{{}}} {}\n", metric.name, FormatLabels(entry), number_text);
    }
  }
}

}  // namespace

std::string FormatPrometheus(const ClusterView& view, std::int64_t now_us) {
  std::string text;
  Append(view.runs(), kRunMetrics, now_us, &text);
  Append(view.workers(), kWorkerMetrics, now_us, &text);
  return text;
}

}  // namespace knap
