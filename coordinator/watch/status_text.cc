#include "coordinator/watch/status_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "coordinator/progress/progress.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kSilentUs = 1'500'000;  // several statuses missed

constexpr const char* kRunStates[] = {"waiting", "learning", "evaluating", "done"};
constexpr const char* kWorkerStates[] = {"idle", "loading", "computing", "stopping"};

template <std::size_t N>
const char* GetStateName(const char* const (&names)[N], std::int32_t state) {
  return state >= 0 && state < static_cast<std::int32_t>(N) ? names[state] : "unknown";
}

std::string FormatNumber64(std::int64_t number) { return fmt::format("{:016x}", static_cast<std::uint64_t>(number)); }

// So many characters of it: fmt counts them, never bytes.
std::string Cut(const std::string& text, int width) { return fmt::format("{:.{}}", text, width); }

const RunTraits* FindTraits(const KnownRuns& known, std::int64_t run_id) {
  const auto found = known.find(run_id);
  return found == known.end() ? nullptr : &found->second;
}

std::string FormatRunLines(const WatchedRun& run, const RunTraits* traits, std::int64_t now_us, int width) {
  const run_status_t& s = run.status;
  std::vector<std::string> lines;
  lines.push_back(fmt::format("run {} {}  {}  {:.0f}%  ETA {}  elapsed {}{}", s.scenario, s.method,
                              GetStateName(kRunStates, s.state), std::floor(100.0 * s.progress),
                              s.eta_s >= 0.0 ? FormatDuration(s.eta_s) : "-:--", FormatDuration(s.elapsed_s),
                              traits && !traits->has_success ? "  no success test" : ""));
  const std::string unit = traits ? traits->loss_unit : " (unit not known)";
  lines.push_back(fmt::format("  batch {}/{}  evaluation {}  loss {}  best {}  gradient {:.3g}  radius {:.3g}", s.batch,
                              s.batch_count, s.iteration, FormatLoss(s.loss, unit), FormatLoss(s.best_loss, unit),
                              s.grad_norm, s.radius));
  if (s.rollouts_untrusted + s.gradients_flagged > 0) {
    lines.push_back(
        fmt::format("  not to be trusted: {} rollouts, {} gradients", s.rollouts_untrusted, s.gradients_flagged));
  }
  lines.push_back(fmt::format(
      "  workers {}  rollouts {} ({:.1f}/s)  open {}  retries {}  refused {}{}", s.workers, s.requests_done,
      s.rollouts_per_s, s.requests_open, s.requests_reissued, s.messages_refused,
      now_us - run.heard_us > kSilentUs ? fmt::format("  SILENT for {:.0f} s", CalcAge(run.heard_us, now_us)) : ""));
  std::string text;
  for (const std::string& line : lines) text += Cut(line, width) + "\n";
  return text;
}

}  // namespace

std::string FormatStatus(const ClusterView& view, const KnownRuns& known, std::int64_t now_us, int width, bool colour) {
  std::string text;
  for (const auto& [id, run] : view.runs()) text += FormatRunLines(run, FindTraits(known, id), now_us, width);
  if (view.runs().empty()) text += "no run\n";
  if (view.workers().empty()) return text + "no workers\n";
  text += Cut(fmt::format("{:<20} {:<16} {:<9} {:>5} {:>5} {:>8} {:>7} {:>7} {:>7}", "worker", "host", "state", "step",
                          "busy", "finished", "rate/s", "refused", "engine"),
              width) +
          "\n";
  std::vector<const WatchedWorker*> workers;
  for (const auto& [instance, worker] : view.workers()) workers.push_back(&worker);
  std::sort(workers.begin(), workers.end(),
            [](const auto* a, const auto* b) { return a->status.name < b->status.name; });
  for (const WatchedWorker* worker : workers) {
    const worker_status_t& s = worker->status;
    const bool silent = now_us - worker->heard_us > kSilentUs;
    const std::string state = silent          ? fmt::format("silent {:.0f}", CalcAge(worker->heard_us, now_us))
                              : s.run_id == 0 ? "free"
                                              : GetStateName(kWorkerStates, s.state);
    const std::string line =
        Cut(fmt::format("{:<20} {:<16} {:<9} {:>4.0f}% {:>4.0f}% {:>8} {:>7.1f} {:>7} {:>7}", Cut(s.name, 20),
                        Cut(s.host, 16), state, 100.0 * s.step_fraction, 100.0 * s.busy_fraction, s.finished,
                        worker->CalcRate(), s.refused, s.engine),
            width);
    text += (colour && silent ? "\x1b[33m" + line + "\x1b[0m" : line) + "\n";
  }
  return text;
}

Json MakeStatusJson(const ClusterView& view, const KnownRuns& known, std::int64_t now_us, const std::string& url) {
  Json runs = Json::array();
  for (const auto& [id, run] : view.runs()) {
    const run_status_t& s = run.status;
    const RunTraits* traits = FindTraits(known, id);
    runs.push_back({{"run_id", FormatNumber64(s.run_id)},
                    {"scenario", s.scenario},
                    {"method", s.method},
                    {"state", GetStateName(kRunStates, s.state)},
                    {"progress", MakeJsonNumber(s.progress)},
                    {"eta_s", s.eta_s >= 0.0 ? MakeJsonNumber(s.eta_s) : Json()},
                    {"elapsed_s", MakeJsonNumber(s.elapsed_s)},
                    {"batch", s.batch},
                    {"batches", s.batch_count},
                    {"evaluations", s.iteration},
                    {"loss", MakeJsonNumber(s.loss)},
                    {"best_loss", MakeJsonNumber(s.best_loss)},
                    {"loss_unit", traits ? Json(traits->loss_unit.substr(traits->loss_unit.empty() ? 0 : 1)) : Json()},
                    {"success_test", traits ? Json(traits->has_success) : Json()},
                    {"gradient_norm", MakeJsonNumber(s.grad_norm)},
                    {"radius", MakeJsonNumber(s.radius)},
                    {"theta", s.theta},
                    {"workers", s.workers},
                    {"rollouts", s.requests_done},
                    {"rollouts_per_s", MakeJsonNumber(s.rollouts_per_s)},
                    {"open", s.requests_open},
                    {"retries", s.requests_reissued},
                    {"rollouts_untrusted", s.rollouts_untrusted},
                    {"gradients_flagged", s.gradients_flagged},
                    {"messages_refused", s.messages_refused},
                    {"age_s", CalcAge(run.heard_us, now_us)}});
  }
  Json workers = Json::array();
  for (const auto& [instance, worker] : view.workers()) {
    const worker_status_t& s = worker.status;
    workers.push_back({{"name", s.name},
                       {"instance", FormatNumber64(s.sender)},
                       {"host", s.host},
                       {"pid", s.pid},
                       {"engine", s.engine},
                       {"build", s.build},
                       {"run_id", s.run_id == 0 ? Json() : Json(FormatNumber64(s.run_id))},
                       {"state", GetStateName(kWorkerStates, s.state)},
                       {"steps_done", s.steps_done},
                       {"steps_total", s.steps_total},
                       {"busy", MakeJsonNumber(s.busy_fraction)},
                       {"finished", s.finished},
                       {"rollouts_per_s", worker.CalcRate()},
                       {"repeated", s.repeated},
                       {"unacknowledged", s.unacknowledged},
                       {"messages_refused", s.refused},
                       {"age_s", CalcAge(worker.heard_us, now_us)}});
  }
  return {
      {"schema", 1}, {"url", url}, {"runs", runs}, {"workers", workers}, {"messages_refused", view.refusals().total()}};
}

}  // namespace knap
