#include "coordinator/run/report_writing.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "coordinator/progress/progress.h"
#include "coordinator/report/report_document.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

using Answers = std::unordered_map<ContentId, RolloutOutcome, ContentIdHash>;

Answers ReadAnswers(const RunDirectory& run) {
  Answers answers;
  for (const std::string& payload : Journal::Read(run.journal_path())) {
    for (JournaledAnswer& answer : DecodeAnswers(payload)) answers[answer.id] = std::move(answer.outcome);
  }
  return answers;
}

ReportedTest FindTest(const std::string& name, std::vector<double> theta, std::size_t controls,
                      const std::vector<std::vector<double>>& variations, const ContentId& scenario,
                      const Answers& answers) {
  ReportedTest test{name, std::move(theta), {}, {}};
  const std::span<const double> all = test.theta;
  const std::size_t design = all.size() - controls;
  for (const std::vector<double>& variation : variations) {
    const ContentId id =
        CalcRequestId({"knap", scenario, all.first(design), all.subspan(design), {}, variation, false});
    test.ids.push_back(FormatHex(id));
    const auto found = answers.find(id);
    test.outcomes.push_back(found == answers.end() ? std::nullopt : std::optional(found->second));
  }
  return test;
}

}  // namespace

void WriteReport(const LoadedScenario& scenario, const RunDirectory& run, RolloutModel& model,
                 const std::filesystem::path& path, StderrProgress* shown) {
  const Scene& scene = scenario.parsed.scene;
  const Problem problem = MakeProblem(scene, scenario.files);
  const std::size_t size = problem.parameters.names.size();
  ReportSource source;
  source.run = &run;
  source.problem = &problem;
  source.model = &model;
  source.loss_unit = FormatLossUnit(scene);
  source.loss_unit.erase(0, source.loss_unit.find_first_not_of(' '));
  const auto seed = static_cast<std::uint64_t>(scene.evaluation.seed);
  for (std::int64_t i = 0; i < scene.evaluation.variations; ++i) {
    source.variations.push_back(
        SampleVariation(problem.variations, seed, RandomStream::kTestVariations, static_cast<std::uint64_t>(i)));
  }
  const ContentId id = CalcScenarioId(EncodeBundle(ListTaskFiles(scenario)));
  const Answers answers = ReadAnswers(run);
  const auto find = [&](const char* name, std::vector<double> theta) {
    return FindTest(name, std::move(theta), problem.parameters.controls, source.variations, id, answers);
  };
  source.tests.push_back(find("initial", problem.parameters.initial));
  source.tests.push_back(find("learned", ReadLearnedTheta(run, size)));
  const SteadyClock clock;
  const std::int64_t started_us = clock.now_us();
  ProgressState state;
  state.title = scene.name + " report";
  state.phase = ProgressPhase::kTesting;
  const auto progress = [&](int done, int total) {
    state.elapsed_s = static_cast<double>(clock.now_us() - started_us) * 1e-6;
    state.tested = state.rollouts = done;
    state.tests = total;
    shown->Update(state);
  };
  WriteFileAtomically(path, MakeReportPage(source, progress));
}

}  // namespace knap
