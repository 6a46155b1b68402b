#include "coordinator/run/report_writing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/report/comparison_document.h"
#include "coordinator/report/report_document.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/report_sources.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/scenario_bundle.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

Answers ReadAnswers(const RunDirectory& run) {
  Answers answers;
  for (const std::string& payload : Journal::Read(run.journal_path())) {
    for (JournaledAnswer& answer : DecodeAnswers(payload)) answers[answer.id] = std::move(answer.outcome);
  }
  return answers;
}

Json ReadJson(const std::filesystem::path& path) {
  try {
    return Json::parse(ReadFile(path));
  } catch (const Json::exception& e) {
    throw UsageError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

// What a report of several runs has in common with that of one.
Comparison BeginComparison(const LoadedScenario& scenario, const RunDirectory& run, const Problem& problem) {
  const Scene& scene = scenario.parsed.scene;
  // A study tells it once for all its runs.
  const Json info = std::filesystem::exists(run.info_path()) ? ReadJson(run.info_path()) : Json::object();
  Comparison comparison;
  comparison.run = {{"scenario", scene.name},
                    {"description", scene.description},
                    {"host", info.value("host", "")},
                    {"started", info.value("started_utc", "")}};
  comparison.build = {{"version", info.value("version", "")}, {"build", info.value("build", "")}};
  comparison.problem = &problem;
  comparison.loss_unit = FormatLossUnit(scene);
  comparison.loss_unit.erase(0, comparison.loss_unit.find_first_not_of(' '));
  comparison.has_success = scene.success.has_value();
  return comparison;
}

ComparedRun MakeComparedRun(const RunDirectory& run) {
  const Json result = ReadJson(run.result_path());
  return {run.path().filename().string(), result.at("rollouts").at("total").get<double>(),
          result.at("theta").at("learned").get<std::vector<double>>(), ReadJson(run.evaluation_path()).at("learned"),
          run.metrics_path()};
}

}  // namespace

void WriteStudyReport(const LoadedScenario& scenario, const RunDirectory& study, const std::filesystem::path& path) {
  const Problem problem = MakeProblem(scenario.parsed.scene, scenario.files);
  const Json results = ReadJson(study.study_path());
  if (!results.contains("runs")) {
    throw UsageError(fmt::format("{}: the study has not ended; go on with: knap study --resume {}",
                                 study.study_path().string(), study.path().string()));
  }
  Comparison comparison = BeginComparison(scenario, study, problem);
  comparison.run["name"] = study.path().filename().string();
  comparison.run["wall_s"] = results.value("wall_s", Json());
  comparison.run["rollouts"] = results.value("rollouts", Json::object());
  comparison.initial = results.at("test").at("initial");
  for (const Json& method : results.at("methods")) {
    ComparedGroup group{method.get<std::string>(), {}};
    for (const Json& run : results.at("runs")) {
      if (run.at("method") != method) continue;
      const std::string folder = run.at("folder").get<std::string>();
      group.runs.push_back({folder, run.at("rollouts").get<double>(), run.at("theta").get<std::vector<double>>(),
                            run.at("test"), study.path() / folder / "metrics.csv"});
    }
    comparison.groups.push_back(std::move(group));
  }
  const std::string methods = fmt::format("{}", fmt::join(results.at("methods").get<std::vector<std::string>>(), ","));
  comparison.repeat = {fmt::format("knap study {} --methods {} --seeds {}", study.config_path().string(), methods,
                                   results.at("seeds").get<std::int64_t>()),
                       fmt::format("knap report {}", study.path().string())};
  WriteFileAtomically(path, MakeComparisonPage(comparison));
}

void WriteComparison(const LoadedScenario& scenario, const RunDirectory& first, const RunDirectory& second,
                     const std::filesystem::path& path) {
  const Problem problem = MakeProblem(scenario.parsed.scene, scenario.files);
  Comparison comparison = BeginComparison(scenario, first, problem);
  comparison.of_runs = true;
  for (const RunDirectory* run : {&first, &second}) {
    if (ReadJson(run->result_path()).at("theta").at("names").get<std::vector<std::string>>() !=
        problem.parameters.names) {
      throw UsageError(fmt::format("{} and {} have different parameters", first.path().string(), run->path().string()));
    }
    ComparedRun compared = MakeComparedRun(*run);
    // Two folders may bear one name.
    if (first.path().filename() == second.path().filename()) compared.name = run->path().string();
    const std::string name = compared.name;
    comparison.groups.push_back({name, {std::move(compared)}});
    comparison.repeat.push_back(fmt::format("knap learn {}", run->config_path().string()));
  }
  comparison.run["name"] = fmt::format("{} and {}", comparison.groups[0].name, comparison.groups[1].name);
  comparison.repeat.push_back(fmt::format("knap report {} {}", first.path().string(), second.path().string()));
  const Json initial = ReadJson(first.evaluation_path()).at("initial");
  if (initial == ReadJson(second.evaluation_path()).at("initial")) comparison.initial = initial;
  WriteFileAtomically(path, MakeComparisonPage(comparison));
}

void WriteReport(const LoadedScenario& scenario, const RunDirectory& run, RolloutModel& model,
                 const std::filesystem::path& path, const std::function<void(int done, int total)>& progress) {
  const Scene& scene = scenario.parsed.scene;
  const Problem problem = MakeProblem(scene, scenario.files);
  ReportSource source = MakeReportSource(scenario, run, problem, model, scene.evaluation.variations);
  const ContentId task = CalcScenarioId(EncodeBundle(ListTaskFiles(scenario)));
  const Answers answers = ReadAnswers(run);
  const std::vector<double> learned = ReadLearnedTheta(run, problem.parameters.names.size());
  source.tests = {MakeReportedTest(source, task, "initial", problem.parameters.initial, answers),
                  MakeReportedTest(source, task, "learned", learned, answers)};
  WriteFileAtomically(path, MakeReportPage(source, progress));
}

}  // namespace knap
