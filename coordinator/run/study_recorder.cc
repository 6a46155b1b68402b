#include "coordinator/run/study_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <utility>

#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/runs_progress.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> MakeOverrides(const LearningOptions& options) {
  return {fmt::format("learning.method={}", GetName(options.method)), fmt::format("learning.seed={}", options.seed),
          fmt::format("learning.rollout_budget={}", options.rollout_budget.value_or(0))};
}

}  // namespace

StudyRecorder::StudyRecorder(const PreparedScenario& prepared, const StudyOptions& options, const RunDirectory& study,
                             ClusterSession* session, const JournaledService* service, bool quiet)
    : prepared_(prepared),
      study_(study),
      session_(session),
      service_(service),
      started_us_(clock_.now_us()),
      shown_(quiet, [this](const std::string& error) { RecordDropped(error); }) {
  for (const LearningOptions& run : PlanRuns(options)) {
    const fs::path path = study_.path() / MakeRunName(run);
    fs::remove_all(path);
    const RunDirectory& folder = folders_.emplace_back(RunDirectory::Create(path));
    followers_.emplace_back(folder.metrics_path(), prepared_.problem.parameters.names, this);
  }
  session_->set_on_pump([this] { Pump(); });
}

StudyRecorder::~StudyRecorder() { session_->set_on_pump({}); }

std::string StudyRecorder::MakeRunName(const LearningOptions& options) {
  return fmt::format("{}-{}", GetName(options.method), options.seed);
}

double StudyRecorder::elapsed_s() const { return static_cast<double>(clock_.now_us() - started_us_) * 1e-6; }

void StudyRecorder::Follower::OnBatchStart(const BatchStart& start) { batch_ = start; }

void StudyRecorder::Follower::OnEvaluation(const LearningEvaluation& evaluation) {
  metrics_.Append(recorder_->elapsed_s(), evaluation);
  const double within = static_cast<double>(evaluation.evaluation + 1) / std::max(1, batch_.max_evaluations);
  done = (batch_.batch - 1 + std::min(1.0, within)) / std::max(1, batch_.batches);
}

void StudyRecorder::Follower::OnValidation(const BatchValidation& validation) {
  metrics_.SetValidation(validation, recorder_->prepared_.scenario.parsed.scene.success.has_value());
}

void StudyRecorder::OnInitial(const TestSummary& initial) {
  const std::lock_guard lock(mutex_);
  initial_ = initial;
}

void StudyRecorder::OnRunEnd(std::size_t run, const StudyRun& result) {
  const RunDirectory& folder = folders_[run];
  // The run as it would be alone, so that its folder can be evaluated and repeated by itself.
  WriteScenario(LoadValidScenario(study_.config_path(), MakeOverrides(result.learning)), folder);
  ResultDocument document;
  document.scenario = prepared_.scenario.parsed.scene.name;
  document.method = GetName(result.learning.method);
  document.seed = result.learning.seed;
  document.parameters = prepared_.problem.parameters;
  document.learned = result.learned.theta;
  document.has_success = prepared_.scenario.parsed.scene.success.has_value();
  document.test_initial = *initial_;
  document.test_learned = result.test;
  document.rollouts_total = result.rollouts_total;
  document.rollouts_distinct = result.rollouts_distinct;
  document.wall_s = elapsed_s();
  WriteTools(*prepared_.model, document.learned, folder, "learned");
  folder.WriteResult(document);

  followers_[run].done = 1.0;
  const std::lock_guard lock(mutex_);
  ++ended_;
  const Scene& scene = prepared_.scenario.parsed.scene;
  const std::string figure = scene.success
                                 ? fmt::format("{:5.1f}% succeed", 100.0 * result.test.success_rate)
                                 : fmt::format("mean loss {:.4g}{}", result.test.loss_mean, FormatLossUnit(scene));
  news_.push_back(fmt::format("{:<18} seed {}: {}, {} rollouts of learning", document.method, document.seed, figure,
                              result.learned.rollouts));
}

void StudyRecorder::Pump() {
  std::vector<std::string> news;
  {
    const std::lock_guard lock(mutex_);
    news = std::exchange(news_, {});
  }
  for (const std::string& line : news) shown_.Say(line + "\n");
  ShowProgress();
}

void StudyRecorder::RecordDropped(const std::string& error) noexcept try {
  EventLog(study_.events_path()).Append(elapsed_s(), "progress_dropped", {{"error", error}});
} catch (const std::exception&) {
  // The disk takes neither; no line is worth the study.
}

void StudyRecorder::ShowProgress() {
  ProgressState state;
  state.title = fmt::format("{} study", prepared_.scenario.parsed.scene.name);
  state.elapsed_s = elapsed_s();
  const auto runs = static_cast<double>(followers_.size());
  for (const Follower& follower : followers_) state.study_part += follower.done / runs;
  state.runs = static_cast<int>(followers_.size());
  {
    const std::lock_guard lock(mutex_);
    state.runs_done = ended_;
  }
  const bool done = state.runs_done == state.runs;
  ShowRunsProgress(state, done, prepared_.scenario.parsed.scene.name, "study", *service_, session_, &shown_);
}

void StudyRecorder::Finish() {
  Pump();
  session_->set_on_pump({});
  session_->Finish();
}

}  // namespace knap
