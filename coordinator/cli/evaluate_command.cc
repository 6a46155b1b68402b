#include "coordinator/cli/evaluate_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/cli/run_or_scenario.h"
#include "coordinator/cli/theta_choice.h"
#include "coordinator/learning/batch_objective.h"
#include "coordinator/learning/evaluation.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

using Json = nlohmann::ordered_json;

struct EvaluateArguments {
  std::string path;  // of a run or a scenario file
  std::vector<std::string> overrides;
  ClusterOptions cluster;
  std::optional<int> variations;
  std::optional<std::uint64_t> seed;
  std::string theta;
  std::string csv;
  bool json = false, quiet = false;
};

// The seed of random designs; that of the variations is the scenario's or --seed.
constexpr std::uint64_t kRandomThetaSeed = 0;

struct Test {
  std::vector<double> theta;
  TestSummary summary;
  std::vector<RolloutOutcome> outcomes;  // one a variation
};

// Every design on the same variations, in one call of the service, so that no worker idles between designs.
std::vector<Test> TestDesigns(const std::vector<std::vector<double>>& thetas, const VariationSpec& variations, int n,
                              std::uint64_t seed, RolloutService& service) {
  std::vector<RolloutQuery> queries;
  for (const std::vector<double>& theta : thetas) {
    for (int i = 0; i < n; ++i) {
      RolloutQuery query;
      query.theta = theta;
      query.variation = SampleVariation(variations, seed, RandomStream::kTestVariations, static_cast<std::uint64_t>(i));
      query.gradient = false;
      queries.push_back(query);
    }
  }
  const std::vector<RolloutOutcome> outcomes = EvaluateAll(service, queries);
  std::vector<Test> tests;
  for (std::size_t k = 0; k < thetas.size(); ++k) {
    const auto count = static_cast<std::size_t>(n);
    const std::span<const RolloutOutcome> of_design = std::span(outcomes).subspan(k * count, count);
    tests.push_back({thetas[k], SummarizeTest(of_design, seed), {of_design.begin(), of_design.end()}});
  }
  return tests;
}

double CalcMedianRate(const std::vector<Test>& tests) {
  std::vector<double> rates;
  for (const Test& test : tests) rates.push_back(test.summary.success_rate);
  std::sort(rates.begin(), rates.end());
  const std::size_t middle = rates.size() / 2;
  return rates.size() % 2 == 1 ? rates[middle] : 0.5 * (rates[middle - 1] + rates[middle]);
}

Json MakeThetaJson(const ParameterSpec& parameters, const std::vector<double>& theta) {
  Json json = Json::object();
  for (std::size_t i = 0; i < theta.size(); ++i) json[parameters.names[i]] = theta[i];
  return json;
}

void PrintJson(const Scene& scene, const ParameterSpec& parameters, const std::vector<Test>& tests,
               const std::optional<std::string>& dropped) {
  Json designs = Json::array();
  for (const Test& test : tests) {
    designs.push_back({{"theta", MakeThetaJson(parameters, test.theta)},
                       {"test", MakeEvaluationJson(test.summary, scene.success.has_value())}});
  }
  Json json = {{"schema", 1},
               {"scenario", scene.name},
               {"designs", designs},
               {"median_success_rate", scene.success ? Json(CalcMedianRate(tests)) : Json()}};
  if (dropped) json["progress_dropped"] = *dropped;
  WriteOutput(MakeJsonText(json, 2) + "\n");
}

void PrintTests(const Scene& scene, const ParameterSpec& parameters, const std::vector<Test>& tests,
                const std::optional<std::string>& dropped) {
  const TestSummary& first = tests.front().summary;
  std::string text =
      fmt::format("{} on {} variations of seed {}\n",
                  scene.success ? "success rate (95% interval) and mean loss" : "mean loss (no success test)",
                  first.variations, first.seed);
  for (const Test& test : tests) {
    std::string theta;
    for (std::size_t i = 0; i < test.theta.size() - parameters.controls; ++i) {
      theta += "  " + FormatParameter(parameters, i, test.theta[i]);
    }
    if (scene.success) {
      text += fmt::format("{:5.1f}% ({:.1f} to {:.1f}%)  ", 100.0 * test.summary.success_rate,
                          100.0 * test.summary.success_interval.lower, 100.0 * test.summary.success_interval.upper);
    }
    text += fmt::format("loss {:.4g}{}{}\n", test.summary.loss_mean, FormatLossUnit(scene), theta);
    if (test.summary.not_converged + test.summary.not_finite > 0) {
      text += fmt::format(
          "        {} rollouts did not converge, {} are not finite: they count as failures with the worst loss\n",
          test.summary.not_converged, test.summary.not_finite);
    }
    if (test.summary.untrusted > 0) {
      text += fmt::format("        {} rollouts are not to be trusted and no success: {}\n", test.summary.untrusted,
                          test.summary.distrust);
    }
  }
  if (scene.success && tests.size() > 1) {
    text += fmt::format("median of {} designs: {:.1f}%\n", tests.size(), 100.0 * CalcMedianRate(tests));
  }
  WriteOutput(text + FormatDropped(dropped));
}

// One row a design and variation: number of both, the varied keys by name, loss, success (empty without a test),
// certificate.
std::string FormatCsv(const Scene& scene, const VariationSpec& variations, std::uint64_t seed,
                      const std::vector<Test>& tests) {
  std::string text = "design,variation";
  for (const std::string& name : ListNames(variations)) text += "," + MakeCsvField(name);
  text += ",loss,success,finite,converged,distrust,penetration,largest_force,steps\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (std::size_t k = 0; k < tests.size(); ++k) {
    for (std::size_t i = 0; i < tests[k].outcomes.size(); ++i) {
      const RolloutOutcome& outcome = tests[k].outcomes[i];
      text += fmt::format("{},{}", k, i);
      for (const double value : SampleVariation(variations, seed, RandomStream::kTestVariations, i)) {
        text += "," + number(value);
      }
      text += fmt::format(
          ",{},{},{:d},{:d},{},{},{},{}\n", number(outcome.loss), scene.success ? (outcome.success ? "1" : "0") : "",
          outcome.certificate.finite, outcome.certificate.converged, MakeCsvField(outcome.certificate.distrust),
          number(outcome.certificate.penetration), number(outcome.certificate.largest_force), outcome.steps);
    }
  }
  return text;
}

int RunEvaluate(const EvaluateArguments& arguments) {
  const RunOrScenario source(arguments.path);
  const LoadedScenario scenario = LoadValidScenario(source.config(), arguments.overrides);
  const Scene& scene = scenario.parsed.scene;
  const Problem problem = MakeProblem(scene, scenario.files);
  const ParameterSpec& parameters = problem.parameters;
  const std::vector<std::vector<double>> thetas =
      ChooseThetas(arguments.theta, parameters, kRandomThetaSeed, source.NameDesigns(parameters.names.size()));
  const int n = arguments.variations.value_or(static_cast<int>(scene.evaluation.variations));
  const std::uint64_t seed = arguments.seed.value_or(static_cast<std::uint64_t>(scene.evaluation.seed));
  CheckRequestVolume("--variations and --theta", {static_cast<double>(n), static_cast<double>(thetas.size())},
                     parameters.names.size() + problem.variations.size());
  std::vector<Test> tests;
  std::optional<std::string> dropped;
  {
    ClusterSession session(arguments.cluster, FindEngineIdentity(arguments.cluster.engine), ListTaskFiles(scenario),
                           parameters.controls);
    session.StartWorkers();
    const CountProgress progress(scene.name, scene.name, n * static_cast<std::int64_t>(thetas.size()), arguments.quiet,
                                 &session);
    tests = TestDesigns(thetas, problem.variations, n, seed, session.service());
    session.Finish();
    dropped = progress.dropped();
  }
  if (!arguments.csv.empty()) {
    WriteFileAtomically(arguments.csv, FormatCsv(scene, problem.variations, seed, tests));
  }
  if (arguments.json) {
    PrintJson(scene, parameters, tests, dropped);
  } else {
    PrintTests(scene, parameters, tests, dropped);
  }
  return kExitDone;
}

}  // namespace

void AddEvaluateCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* evaluate = app->add_subcommand("evaluate", "Tests designs on variations that learning never sees");
  evaluate->add_option("path", arguments->path, "run directory or scenario file")->required();
  evaluate->add_option("overrides", arguments->overrides, "changes to the scenario, a.b=c");
  AddClusterFlags(evaluate, &arguments->cluster);
  evaluate->add_option("--variations", arguments->variations, "how many (default: the scenario's)")
      ->check(CLI::Range(1, 1000000));
  evaluate->add_option("--seed", arguments->seed, "of the variations (default: the scenario's)");
  evaluate->add_option(
      "--theta", arguments->theta,
      "initial, learned, random:K or NAME=VALUE,... with the others as by default (default: learned of a "
      "run, else initial)");
  evaluate->add_option("--csv", arguments->csv, "writes one row a variation: values, loss, success, certificate");
  evaluate->add_flag("--json", arguments->json, "print a JSON document on stdout");
  evaluate->add_flag("--quiet", arguments->quiet, "no progress");
  evaluate->callback([arguments, command] { *command = [arguments] { return RunEvaluate(*arguments); }; });
}

}  // namespace knap
