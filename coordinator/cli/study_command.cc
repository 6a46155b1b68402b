#include "coordinator/cli/study_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/prepared_scenario.h"
#include "coordinator/run/report_writing.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/study_recorder.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "coordinator/study/study.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kMostSeeds = 1000;  // each run has a thread of its own

struct StudyArguments {
  std::string config;
  std::vector<std::string> overrides;
  std::vector<std::string> methods = {"ours", "simple_continual", "diffhand"};
  int seeds = 10;
  std::optional<std::int64_t> first_seed;
  ClusterOptions cluster;
  std::string out, resume;
  bool json = false, quiet = false;
};

// Beside the configuration, what a study's runs follow from: study.json.
Json MakePlanJson(const StudyOptions& options) {
  Json methods = Json::array();
  for (const LearningMethod method : options.methods) methods.push_back(GetName(method));
  return {{"schema", 1}, {"methods", methods}, {"seeds", options.seeds}, {"first_seed", options.learning.seed}};
}

StudyOptions MakeStudyOptions(const StudyArguments& arguments, const PreparedScenario& prepared) {
  StudyOptions options;
  options.learning = prepared.options;
  options.tests = static_cast<int>(prepared.scenario.parsed.scene.evaluation.variations);
  options.test_seed = static_cast<std::uint64_t>(prepared.scenario.parsed.scene.evaluation.seed);
  options.seeds = arguments.seeds;
  for (const std::string& method : arguments.methods) options.methods.push_back(ParseLearningMethod(method));
  CheckStudyOptions(options);
  CheckRequestVolume("--seeds, --methods and evaluation.variations",
                     {static_cast<double>(options.seeds), static_cast<double>(options.methods.size()),
                      static_cast<double>(std::max<std::int64_t>(options.tests, options.learning.batch))},
                     prepared.problem.parameters.names.size() + prepared.problem.variations.size());
  return options;
}

// Methods and seeds of a study that is to go on, in place of the command line's.
void ReadPlan(const RunDirectory& study, StudyArguments* arguments) {
  const fs::path path = study.study_path();
  if (!fs::exists(path)) throw UsageError(fmt::format("{}: no study (it holds no study.json)", study.path().string()));
  try {
    const Json plan = Json::parse(ReadFile(path));
    arguments->methods = plan.at("methods").get<std::vector<std::string>>();
    const auto seeds = plan.at("seeds").get<std::int64_t>();
    if (seeds < 1 || seeds > kMostSeeds) {
      throw UsageError(fmt::format("{}: seeds is {}; 1 to {} are allowed", path.string(), seeds, kMostSeeds));
    }
    arguments->seeds = static_cast<int>(seeds);
  } catch (const Json::exception& e) {
    throw UsageError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

RunDirectory MakeStudy(const StudyArguments& arguments, const PreparedScenario& prepared, const StudyOptions& options,
                       const RunInfo& info) {
  return MakeNewRun({"studies", arguments.out}, info, [&](const RunDirectory& study) {
    study.WriteRunInfo(info);
    WriteFileAtomically(study.study_path(), MakeJsonText(MakePlanJson(options), 2) + "\n");
    WriteScenario(prepared.scenario, study);
  });
}

Json MakeResultsJson(const StudyOptions& options, const StudyResult& result, const JournaledService& service,
                     bool has_success, double wall_s) {
  Json json = MakePlanJson(options);
  json["test"] = {{"initial", MakeEvaluationJson(result.initial, has_success)}};
  json["methods_over_seeds"] = Json::array();
  for (const MethodSummary& summary : SummarizeMethods(options, result)) {
    const auto spread = [](const Spread& values) {
      return Json{{"mean", MakeJsonNumber(values.mean)}, {"std", MakeJsonNumber(values.standard_deviation)}};
    };
    const auto if_tested = [&](const Json& figure) { return has_success ? figure : Json(); };
    json["methods_over_seeds"].push_back({{"method", GetName(summary.method)},
                                          {"success_rate", if_tested(spread(summary.spread.success_rate))},
                                          {"success_least", if_tested(summary.success_least)},
                                          {"success_median", if_tested(summary.success_median)},
                                          {"success_most", if_tested(summary.success_most)},
                                          {"loss_mean", spread(summary.spread.loss_mean)},
                                          {"worst_decile_loss", spread(summary.spread.worst_decile_loss)},
                                          {"rollouts_mean", summary.rollouts_mean}});
  }
  json["runs"] = Json::array();
  for (const StudyRun& run : result.runs) {
    const std::optional<std::int64_t>& budget = run.learning.rollout_budget;
    json["runs"].push_back({{"folder", StudyRecorder::MakeRunName(run.learning)},
                            {"method", GetName(run.learning.method)},
                            {"seed", run.learning.seed},
                            {"rollout_budget", budget ? Json(*budget) : Json()},
                            {"rollouts", run.learned.rollouts},
                            {"theta", run.learned.theta},
                            {"test", MakeEvaluationJson(run.test, has_success)}});
  }
  json["rollouts"] = {{"total", service.total()}, {"distinct", service.distinct()}};
  json["wall_s"] = wall_s;
  return json;
}

// One line of the table; without a success test it has no rates.
struct TableLine {
  std::string method;
  std::vector<std::string> rates;  // median, least, most, mean, standard deviation
  std::string loss, loss_std, rollouts;
};

std::string FormatLine(const TableLine& line, bool has_success) {
  std::string text = fmt::format("  {:<18}", line.method);
  for (std::size_t i = 0; has_success && i < line.rates.size(); ++i) text += fmt::format(" {:>7}", line.rates[i]);
  return text + fmt::format("  {:>10} {:>10}  {:>9}\n", line.loss, line.loss_std, line.rollouts);
}

std::string FormatTable(const StudyOptions& options, const StudyResult& result, const JournaledService& service,
                        const Scene& scene, const RunDirectory& study, double wall_s) {
  const bool has_success = scene.success.has_value();
  const auto percent = [](double rate) { return fmt::format("{:.1f}%", 100.0 * rate); };
  const auto number = [](double value) { return fmt::format("{:.4g}", value); };
  const std::string unit = FormatLossUnit(scene);
  std::string text =
      fmt::format("\n{} methods with {} seeds each, {} rollouts in {}; {} on {} variations that no run saw{}\n\n",
                  options.methods.size(), options.seeds, service.total(), FormatDuration(wall_s),
                  has_success ? "success" : "loss (no success test)", options.tests,
                  unit.empty() ? "" : fmt::format("; unit of losses:{}", unit));
  text +=
      FormatLine({"method", {"median", "least", "most", "mean", "std"}, "mean loss", "std", "rollouts"}, has_success);
  text += FormatLine({"initial design",
                      {percent(result.initial.success_rate), "", "", "", ""},
                      number(result.initial.loss_mean),
                      "",
                      ""},
                     has_success);
  for (const MethodSummary& summary : SummarizeMethods(options, result)) {
    const SeedSpread& spread = summary.spread;
    text += FormatLine({GetName(summary.method),
                        {percent(summary.success_median), percent(summary.success_least), percent(summary.success_most),
                         percent(spread.success_rate.mean), percent(spread.success_rate.standard_deviation)},
                        number(spread.loss_mean.mean),
                        number(spread.loss_mean.standard_deviation),
                        fmt::format("{:.0f}", summary.rollouts_mean)},
                       has_success);
  }
  return text + fmt::format(
                    "\n  report    {} (open it in a browser)\n  figures   {}\n  each run  {} and so on, like those of "
                    "knap learn\n",
                    CleanText(study.report_path().string()), CleanText(study.study_path().string()),
                    CleanText((study.path() / StudyRecorder::MakeRunName(result.runs.front().learning)).string()));
}

int RunStudyCommand(StudyArguments arguments) {
  if (arguments.config.empty() == arguments.resume.empty()) {
    throw UsageError("knap study: expected either a CONFIG or --resume DIR");
  }
  if (!arguments.resume.empty() && (!arguments.overrides.empty() || arguments.first_seed || !arguments.out.empty())) {
    throw UsageError("knap study: --resume continues a study as it is: without a.b=c, --seed and --out");
  }
  fs::path config = arguments.config;
  std::optional<RunDirectory> study;
  if (!arguments.resume.empty()) {
    study = OpenRunOfThisBuild(arguments.resume);
    ReadPlan(*study, &arguments);
    config = study->config_path();
  }
  if (arguments.first_seed) arguments.overrides.push_back(fmt::format("learning.seed={}", *arguments.first_seed));
  const PreparedScenario prepared = PrepareScenario(config, arguments.overrides);
  const Scene& scene = prepared.scenario.parsed.scene;
  const StudyOptions options = MakeStudyOptions(arguments, prepared);
  const EngineIdentity engine = FindEngineIdentity(arguments.cluster.engine);
  RunInfo info = MakeRunInfo(prepared.scenario, prepared.config_hash, engine);
  info.method = "study";
  ClusterSession session(arguments.cluster, engine, ListTaskFiles(prepared.scenario),
                         prepared.problem.parameters.controls);
  if (!study) study = MakeStudy(arguments, prepared, options, info);
  Journal::Opened journal = OpenRunJournal(*study, info.identity);
  session.StartWorkers(study->path());
  JournaledService service(&session.dispatcher(), &journal.journal, std::move(journal.payloads));
  StudyRecorder recorder(prepared, options, *study, &session, &service, arguments.quiet);
  StudyResult result;
  try {
    result = RunStudy(prepared.problem, options, service, recorder);
  } catch (const Interrupted&) {
    throw Interrupted(fmt::format("interrupted; everything so far is saved, go on with: knap study --resume {}",
                                  study->path().string()));
  }
  recorder.Finish();
  const Json results = MakeResultsJson(options, result, service, scene.success.has_value(), recorder.elapsed_s());
  WriteFileAtomically(study->study_path(), MakeJsonText(results, 2) + "\n");
  WriteStudyReport(prepared.scenario, *study, study->report_path());
  recorder.Say(FormatTable(options, result, service, scene, *study, recorder.elapsed_s()));
  if (arguments.json) WriteOutput(fmt::format("{}\n", MakeJsonText(results, 2)));
  return kExitDone;
}

}  // namespace

void AddStudyCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* study = app->add_subcommand("study", "Learns with several methods and many seeds on one pool of workers");
  study->add_option("config", arguments->config, "scenario file");
  study->add_option("overrides", arguments->overrides, "changes to the scenario: a.b=c");
  CLI::Option* methods =
      study->add_option("--methods", arguments->methods, "comma-separated (default: ours,simple_continual,diffhand)")
          ->delimiter(',')
          ->allow_extra_args(false);  // what follows is an override
  CLI::Option* seeds = study->add_option("--seeds", arguments->seeds, "how many seeds each method has (default: 10)");
  seeds->check(CLI::Range(1, kMostSeeds));
  study->add_option("--seed", arguments->first_seed, "the first of them (default: the scenario's)");
  AddClusterFlags(study, &arguments->cluster);
  CLI::Option* out = study->add_option("--out", arguments->out, "folder (default: studies/<scenario>-<UTC>)");
  study->add_option("--resume", arguments->resume, "continue the study in this folder")
      ->excludes(out)
      ->excludes(methods)
      ->excludes(seeds);
  study->add_flag("--json", arguments->json, "print study.json on stdout");
  study->add_flag("--quiet", arguments->quiet, "no progress and no table");
  study->callback([arguments, command] { *command = [arguments] { return RunStudyCommand(*arguments); }; });
}

}  // namespace knap
