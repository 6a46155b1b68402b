#include "coordinator/run/run_recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "coordinator/run_directory/json_text.h"
#include "knap/run_status_t.hpp"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostListed = 256;  // requests in one event
constexpr double kUsualWorkers = 8.0;     // of a run that takes whoever comes

// As it reads well in JSON, with microseconds.
double RoundTime(double seconds) { return std::round(seconds * 1e6) / 1e6; }

// Whoever reads it later may stand elsewhere. Empty: no key.
std::string FindAbsolutePath(const std::string& path) {
  return path.empty() ? "" : CleanText(std::filesystem::absolute(path).lexically_normal().string());
}

}  // namespace

RunRecorder::RunRecorder(const RunPlan& plan, const RunDirectory& run, ClusterSession* session,
                         JournaledService* service, bool quiet)
    : plan_(plan),
      started_us_(clock_.now_us()),
      earlier_(ReadEarlierLife(run)),
      session_(session),
      service_(service),
      metrics_(run.metrics_path(), plan.parameter_names),
      rollouts_(run.rollouts_path()),
      events_(run.events_path()),
      shown_(quiet,
             [this](const std::string& error) {
               TryRecordEvent("progress_dropped", {{"error", error}});
             }),
      work_started_us_(started_us_ - static_cast<std::int64_t>(earlier_.worked_s * 1e6)) {
  state_.title = fmt::format("{} {}", plan_.scenario, plan_.method);
  state_.loss_unit = plan_.loss_unit;
  state_.tests = plan_.tests;
  state_.replays = plan_.replays;
  // One after the other in this process, and the others on all workers at a time.
  state_.replay_cost = session_->workers_wanted() > 0 ? session_->workers_wanted() : kUsualWorkers;
  state_.workers_wanted = session_->workers_wanted();
  progress_.state = run_status_t::kWaiting;
  progress_.scenario = plan_.scenario;
  progress_.method = plan_.method;
  session_->set_on_pump([this] { Pump(); });
  service_->set_on_answer([this](const RolloutReport& report) { RecordAnswer(report); });
  session_->dispatcher().set_on_trouble([this](const RequestTrouble& trouble) {
    troubles_.push_back({elapsed_s(), trouble});
  });
  RecordEvent("begin", {{"pid", getpid()},
                        {"run_id", fmt::format("{:016x}", static_cast<std::uint64_t>(session_->run_id()))},
                        {"lcm_url", session_->lcm_url()},
                        {"key_file", FindAbsolutePath(session_->key_file())},
                        {"workers", session_->workers_wanted()},
                        {"answers_from_journal", service_->from_journal()}});
}

RunRecorder::~RunRecorder() {
  session_->dispatcher().set_on_trouble({});
  session_->set_on_pump({});
  service_->set_on_answer({});
}

double RunRecorder::elapsed_s() const {
  return earlier_.worked_s + static_cast<double>(clock_.now_us() - started_us_) * 1e-6;
}

std::int64_t RunRecorder::reissued() const { return earlier_.reissued + session_->dispatcher().counters().reissued; }

void RunRecorder::RecordEvent(const std::string& event, const Json& details) {
  events_.Append(elapsed_s(), event, details);
}

void RunRecorder::TryRecordEvent(const std::string& event, const Json& details) noexcept try {
  RecordEvent(event, details);
} catch (const std::exception&) {
}

void RunRecorder::TryRecordEnd(const std::string& event, const Json& details) noexcept {
  try {
    RecordLosses();
  } catch (const std::exception&) {
  }
  TryRecordEvent(event, details);
}

void RunRecorder::OnBatchStart(const BatchStart& start) {
  state_.batch = progress_.batch = start.batch;
  state_.batches = progress_.batch_count = start.batches;
  state_.evaluation = 0;
  state_.max_evaluations = start.max_evaluations;
  state_.loss.reset();
  state_.best_loss.reset();
  progress_.best_loss = std::numeric_limits<double>::quiet_NaN();
  progress_.state = run_status_t::kLearning;
  progress_.theta = start.theta;
  RecordEvent("batch_start", {{"batch", start.batch},
                              {"batches", start.batches},
                              {"variations", start.variations},
                              {"distillation", start.distillation},
                              {"theta", start.theta}});
}

void RunRecorder::OnEvaluation(const LearningEvaluation& evaluation) {
  metrics_.Append(elapsed_s(), evaluation);
  state_.evaluation = evaluation.evaluation + 1;
  state_.loss.reset();
  if (evaluation.value.accepted) {
    state_.loss = progress_.loss = evaluation.value.loss;
    progress_.grad_norm = evaluation.value.gradient_norm;
  }
  if (std::isfinite(evaluation.best_loss)) state_.best_loss = progress_.best_loss = evaluation.best_loss;
  ++progress_.iteration;
  progress_.theta = evaluation.value.theta;
  PublishProgress();
}

void RunRecorder::OnBatchBox(const BatchBox& box) {
  progress_.radius = box.radius;
  Json names = Json::array();
  for (const std::size_t i : box.dimensions) names.push_back(plan_.parameter_names[i]);
  RecordEvent("batch_box", {{"batch", box.batch},
                            {"dimensions", names},
                            {"radius", box.radius},
                            {"restarted", box.restarted},
                            {"excluded_task", box.excluded_task},
                            {"excluded_distillation", box.excluded_distillation}});
}

void RunRecorder::OnBatchEnd(const BatchEnd& end) {
  RecordEvent("batch_end", {{"batch", end.batch},
                            {"theta", end.theta},
                            {"start_loss", MakeJsonNumber(end.start_loss)},
                            {"best_loss", MakeJsonNumber(end.best_loss)},
                            {"evaluations", end.evaluations},
                            {"rejected", end.rejected},
                            {"stop", GetName(end.stop)}});
}

void RunRecorder::OnValidationStart() { state_.validating = true; }

void RunRecorder::OnValidation(const BatchValidation& validation) {
  state_.validating = false;
  metrics_.SetValidation(validation, plan_.has_success);
  const TestSummary& test = validation.test;
  RecordEvent("validation", {{"batch", validation.batch},
                             {"loss_mean", MakeJsonNumber(test.loss_mean)},
                             {"success_rate", plan_.has_success ? Json(test.success_rate) : Json()},
                             {"best", validation.is_best}});
}

void RunRecorder::BeginTest() {
  state_.phase = ProgressPhase::kTesting;
  test_begin_total_ = service_->answered();
  progress_.state = run_status_t::kEvaluating;
  RecordEvent("test", {{"rollouts", plan_.tests}});
  PublishProgress();
}

void RunRecorder::FinishTest() {
  RecordLosses();
  state_.tested = plan_.tests;
  progress_.state = run_status_t::kDone;
  PublishProgress();
  session_->set_on_pump({});
  session_->Finish();
  state_.report_began_s = elapsed_s();
  ShowReplay(0, plan_.replays);
}

void RunRecorder::ShowReplay(int done, int total) {
  state_.elapsed_s = elapsed_s();
  state_.phase = ProgressPhase::kReporting;
  state_.replayed = done;
  state_.replays = total;
  shown_.Update(state_);
}

void RunRecorder::ShowEnd() {
  state_.elapsed_s = elapsed_s();
  state_.phase = ProgressPhase::kDone;
  shown_.Finish(state_);
}

void RunRecorder::Pump() {
  RecordLosses();
  PublishProgress();
}

void RunRecorder::RecordAnswer(const RolloutReport& report) {
  RolloutRow row;
  row.time_s = elapsed_s();
  row.id = FormatHex(report.id);
  row.kind = state_.phase == ProgressPhase::kTesting ? "test"
             : state_.validating                     ? "validation"
             : report.query->theta_reference.empty() ? "task"
                                                     : "distillation";
  row.variation = report.query->variation;
  row.worker = report.worker;
  row.attempt = report.attempt;
  row.loss = report.outcome->loss;
  row.success = report.outcome->success;
  row.converged = report.outcome->certificate.converged;
  row.gradient_reliable = report.outcome->certificate.gradient_reliable;
  row.loss_error = report.outcome->certificate.loss_error;
  row.penetration = report.outcome->certificate.penetration;
  row.largest_force = report.outcome->certificate.largest_force;
  row.distrust = report.outcome->certificate.distrust;
  row.forward_s = report.outcome->forward_s;
  row.gradient_s = report.outcome->gradient_s;
  row.waited_s = report.waited_s;
  row.held_s = report.held_s;
  rollouts_.Append(row);
}

void RunRecorder::RecordTroubles() {
  const std::vector<Trouble> troubles = std::exchange(troubles_, {});
  Json copied = Json::array(), resent = Json::array();
  for (const auto& [time_s, what] : troubles) {
    Json requests = Json::array();
    for (const RequestTrouble::Held& held : what.requests) {
      if (requests.size() == kMostListed) break;
      Json request = {{"id", FormatShort(held.id)}, {"attempt", held.attempt}, {"held_s", RoundTime(held.held_s)}};
      if (what.kind == TroubleKind::kStraggler || what.kind == TroubleKind::kMessageLost) {
        request["worker"] = what.worker;
        request["time_s"] = RoundTime(time_s);
      }
      if (what.kind == TroubleKind::kStraggler) {
        request["copy_to"] = what.helper;
        request["copy_attempt"] = what.copy_attempt;
      }
      requests.push_back(std::move(request));
    }
    const auto append = [&requests](Json* list) {
      for (Json& request : requests) {
        if (list->size() < kMostListed) list->push_back(std::move(request));
      }
    };
    if (what.kind == TroubleKind::kStraggler) {
      append(&copied);
    } else if (what.kind == TroubleKind::kMessageLost) {
      append(&resent);
    } else if (what.kind == TroubleKind::kDropped) {
      events_.Append(time_s, "requests_dropped",
                     {{"worker", what.worker}, {"count", what.requests.size()}, {"requests", std::move(requests)}});
    } else {
      events_.Append(time_s, "worker_gone",
                     {{"worker", what.worker},
                      {"host", CleanText(what.host)},
                      {"why", GetName(what.kind)},
                      {"requests", std::move(requests)}});
    }
  }
  const DispatchCounters& counters = session_->dispatcher().counters();
  const auto note = [this](const char* event, std::int64_t now, std::int64_t before, Json requests) {
    if (now == before) return;
    RecordEvent(event, {{"count", now - before}, {"total", now}, {"requests", std::move(requests)}});
  };
  note("requests_copied", counters.copied, last_counters_.copied, std::move(copied));
  note("requests_resent", counters.resent, last_counters_.resent, std::move(resent));
}

void RunRecorder::RecordLosses() {
  RecordTroubles();
  const DispatchCounters& counters = session_->dispatcher().counters();
  const auto note = [this](const char* event, std::int64_t now, std::int64_t before) {
    if (now != before) RecordEvent(event, {{"count", now - before}, {"total", now}});
  };
  note("workers_lost", counters.workers_lost, last_counters_.workers_lost);
  note("workers_lacking", counters.workers_lacking, last_counters_.workers_lacking);
  note("workers_stalled", counters.workers_stalled, last_counters_.workers_stalled);
  note("requests_reissued", earlier_.reissued + counters.reissued, earlier_.reissued + last_counters_.reissued);
  note("messages_refused", counters.refused.total(), last_counters_.refused.total());
  note("workers_restarted", session_->worker_restarts(), last_restarts_);
  const auto tell = [this](const char* event, const std::string& word, const auto& workers) {
    for (const auto& [instance, why] : workers) {
      if (!told_workers_.insert(instance).second) continue;
      RecordEvent(event, {{"why", why}});
      shown_.Say(fmt::format("{}{}\n", word, why));
    }
  };
  tell("worker_refused", "refused ", session_->dispatcher().refused());
  tell("worker_left", "", session_->dispatcher().lacking());
  last_counters_ = counters;
  last_restarts_ = session_->worker_restarts();
}

void RunRecorder::PublishProgress() {
  const Dispatcher& dispatcher = session_->dispatcher();
  state_.elapsed_s = static_cast<double>(clock_.now_us() - work_started_us_) * 1e-6;
  state_.rollouts = service_->answered();
  if (state_.phase == ProgressPhase::kTesting && state_.tested < plan_.tests) {
    state_.tested = service_->answered() - test_begin_total_;
  }
  state_.workers_alive = dispatcher.CountUsableWorkers();
  state_.retries = dispatcher.counters().reissued;
  shown_.Update(state_);

  const bool done = progress_.state == run_status_t::kDone;
  progress_.progress = done ? 1.0 : CalcDonePart(state_);
  progress_.eta_s = done ? 0.0 : CalcTimeLeft(state_).value_or(-1.0);
  session_->dispatcher().SetProgress(progress_);
}

}  // namespace knap
