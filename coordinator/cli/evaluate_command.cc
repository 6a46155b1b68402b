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
#include "coordinator/learning/failed_rollouts.h"
#include "coordinator/learning/problem.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/perturbed_scenario.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "sim/scenarios/csv_text.h"
#include "sim/transfer/check_transfer.h"
#include "worker/knap_identity.h"

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
  bool perturb = false, json = false, quiet = false;
};

// The seed of random designs; that of the variations is the scenario's or --seed.
constexpr std::uint64_t kRandomThetaSeed = 0;

struct NamedTheta {
  std::string name;  // "initial", "learned", or its number
  std::vector<double> theta;
};

struct Test {
  std::string engine;
  NamedTheta design;
  TestSummary summary;
  std::vector<RolloutOutcome> outcomes;  // one a variation
};

// Every design on the same variations, in one call of the service, so that no worker idles between designs.
std::vector<Test> TestDesigns(const std::vector<NamedTheta>& designs, const VariationSpec& variations, int n,
                              std::uint64_t seed, const std::string& engine, RolloutService& service) {
  std::vector<RolloutQuery> queries;
  for (const NamedTheta& design : designs) {
    for (int i = 0; i < n; ++i) {
      RolloutQuery query;
      query.theta = design.theta;
      query.variation = SampleVariation(variations, seed, RandomStream::kTestVariations, static_cast<std::uint64_t>(i));
      query.gradient = false;
      queries.push_back(query);
    }
  }
  const std::vector<RolloutOutcome> outcomes = EvaluateAll(service, queries);
  std::vector<Test> tests;
  for (std::size_t k = 0; k < designs.size(); ++k) {
    const auto count = static_cast<std::size_t>(n);
    const std::span<const RolloutOutcome> of_design = std::span(outcomes).subspan(k * count, count);
    tests.push_back({engine, designs[k], SummarizeTest(of_design, seed), {of_design.begin(), of_design.end()}});
  }
  return tests;
}

// On how many variations two engines say the same of one design; empty where one engine was asked alone. The tests of
// the second stand behind those of the first.
struct Agreement {
  std::string design;
  std::int64_t agreed = 0;
  std::int64_t variations = 0;
  Interval CalcInterval() const { return CalcWilsonInterval(agreed, variations); }
  double CalcRate() const { return static_cast<double>(agreed) / static_cast<double>(variations); }
};
std::vector<Agreement> CompareEngines(const std::vector<Test>& tests) {
  std::vector<Agreement> agreements;
  const std::size_t designs = tests.size() / 2;
  if (tests.front().engine == tests.back().engine) return agreements;
  for (std::size_t k = 0; k < designs; ++k) {
    Agreement agreement{tests[k].design.name, 0, static_cast<std::int64_t>(tests[k].outcomes.size())};
    for (std::size_t i = 0; i < tests[k].outcomes.size(); ++i) {
      const auto succeeds = [&](const Test& test) { return !HasFailed(test.outcomes[i]) && test.outcomes[i].success; };
      agreement.agreed += succeeds(tests[k]) == succeeds(tests[k + designs]) ? 1 : 0;
    }
    agreements.push_back(agreement);
  }
  return agreements;
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
    designs.push_back({{"name", test.design.name},
                       {"engine", test.engine},
                       {"theta", MakeThetaJson(parameters, test.design.theta)},
                       {"test", MakeEvaluationJson(test.summary, scene.success.has_value())}});
  }
  Json json = {{"schema", 1},
               {"scenario", scene.name},
               {"designs", designs},
               {"perturbed", scene.perturbation.has_value()},
               {"median_success_rate", scene.success ? Json(CalcMedianRate(tests)) : Json()}};
  if (scene.success) {
    for (const Agreement& agreement : CompareEngines(tests)) {
      const Interval interval = agreement.CalcInterval();
      json["engines_agree"].push_back({{"design", agreement.design},
                                       {"agreed", agreement.agreed},
                                       {"variations", agreement.variations},
                                       {"rate", agreement.CalcRate()},
                                       {"interval", {interval.lower, interval.upper}}});
    }
  }
  if (dropped) json["progress_dropped"] = *dropped;
  WriteOutput(MakeJsonText(json, 2) + "\n");
}

std::string FormatShare(double rate, const Interval& interval) {
  return fmt::format("{:5.1f}% ({:.1f} to {:.1f}%)", 100.0 * rate, 100.0 * interval.lower, 100.0 * interval.upper);
}

void PrintTests(const Scene& scene, const ParameterSpec& parameters, const std::vector<Test>& tests,
                const std::optional<std::string>& dropped) {
  const TestSummary& first = tests.front().summary;
  std::string text =
      fmt::format("{} on {}{} variations of seed {}\n",
                  scene.success ? "success rate (95% interval) and mean loss" : "mean loss (no success test)",
                  first.variations, scene.perturbation ? " perturbed" : "", first.seed);
  const bool names =
      tests.front().design.name != tests.back().design.name || tests.front().engine != tests.back().engine;
  for (const Test& test : tests) {
    std::string theta;
    for (std::size_t i = 0; i < test.design.theta.size() - parameters.controls; ++i) {
      theta += "  " + FormatParameter(parameters, i, test.design.theta[i]);
    }
    if (names) text += fmt::format("{:<7}{:<8}", test.engine, test.design.name);
    if (scene.success) text += FormatShare(test.summary.success_rate, test.summary.success_interval) + "  ";
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
  const std::vector<Agreement> agreements = CompareEngines(tests);
  for (const Agreement& agreement : agreements) {
    if (!scene.success) break;
    text += fmt::format("engines agree on {:<8}{}\n", agreement.design,
                        FormatShare(agreement.CalcRate(), agreement.CalcInterval()));
  }
  if (scene.success && tests.size() > 1 && agreements.empty()) {
    text += fmt::format("median of {} designs: {:.1f}%\n", tests.size(), 100.0 * CalcMedianRate(tests));
  }
  WriteOutput(text + FormatDropped(dropped));
}

// One row a design, engine and variation: name of the first two, the third's number, the varied keys by name, those of
// a perturbation behind them, loss, success (empty without a test), certificate.
std::string FormatCsv(const Scene& scene, const VariationSpec& variations, std::uint64_t seed,
                      const std::vector<Test>& tests) {
  std::string text = "design,engine,variation";
  for (const std::string& name : ListNames(variations)) text += "," + MakeCsvField(name);
  text += ",loss,success,finite,converged,distrust,penetration,largest_force,steps\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (std::size_t k = 0; k < tests.size(); ++k) {
    for (std::size_t i = 0; i < tests[k].outcomes.size(); ++i) {
      const RolloutOutcome& outcome = tests[k].outcomes[i];
      text += fmt::format("{},{},{}", MakeCsvField(tests[k].design.name), tests[k].engine, i);
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

// Of a run that is looked at in two engines, without --theta: what was learned beside what learning began with.
std::vector<NamedTheta> ChooseDesigns(const EvaluateArguments& arguments, bool compares,
                                      const ParameterSpec& parameters, const NamedDesigns& named) {
  if (compares && arguments.theta.empty() && named.by_default == "learned") {
    return {{"initial", parameters.initial}, {"learned", named.read_learned()}};
  }
  const std::vector<std::vector<double>> thetas = ChooseThetas(arguments.theta, parameters, kRandomThetaSeed, named);
  std::vector<NamedTheta> designs;
  for (const std::vector<double>& theta : thetas) designs.push_back({fmt::format("{}", designs.size()), theta});
  const bool is_named = arguments.theta.empty() || arguments.theta == "initial" || arguments.theta == "learned";
  if (is_named) designs.front().name = arguments.theta.empty() ? named.by_default : arguments.theta;
  return designs;
}

// The engines to be asked, one after the other. What they cannot do is refused here, before any rollout.
std::vector<std::string> ChooseEngines(const ClusterOptions& cluster, const Scene& scene) {
  if (cluster.engine != kBulletEngine) {
    if (!cluster.external && !IsOwnEngine(cluster.engine)) {
      throw UsageError(fmt::format("--engine: '{}': knap-worker has the engines {} and {}; others need --external",
                                   cluster.engine, kKnapEngine, kBulletEngine));
    }
    return {cluster.engine};
  }
  const std::vector<std::string> faults = FindTransferFaults(scene);
  if (!faults.empty()) throw UsageError(faults);
  return {kKnapEngine, kBulletEngine};
}

int RunEvaluate(const EvaluateArguments& arguments) {
  const RunOrScenario source(arguments.path);
  LoadedScenario scenario = LoadValidScenario(source.config(), arguments.overrides);
  if (arguments.perturb) AddPerturbation(&scenario);
  const Scene& scene = scenario.parsed.scene;
  const Problem problem = MakeProblem(scene, scenario.files);
  const ParameterSpec& parameters = problem.parameters;
  const std::vector<std::string> engines = ChooseEngines(arguments.cluster, scene);
  const std::vector<NamedTheta> designs =
      ChooseDesigns(arguments, engines.size() > 1, parameters, source.NameDesigns(parameters.names.size()));
  const int n = arguments.variations.value_or(static_cast<int>(scene.evaluation.variations));
  const std::uint64_t seed = arguments.seed.value_or(static_cast<std::uint64_t>(scene.evaluation.seed));
  CheckRequestVolume("--variations and --theta", {static_cast<double>(n), static_cast<double>(designs.size())},
                     parameters.names.size() + problem.variations.size());
  std::vector<Test> tests;
  std::optional<std::string> dropped;
  for (const std::string& engine : engines) {
    ClusterSession session(arguments.cluster, FindEngineIdentity(engine), ListTaskFiles(scenario), parameters.controls);
    session.StartWorkers();
    const CountProgress progress(scene.name, scene.name, n * static_cast<std::int64_t>(designs.size()), arguments.quiet,
                                 &session);
    const std::vector<Test> of_engine = TestDesigns(designs, problem.variations, n, seed, engine, session.service());
    tests.insert(tests.end(), of_engine.begin(), of_engine.end());
    session.Finish();
    if (!dropped) dropped = progress.dropped();
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
  AddClusterFlags(evaluate, &arguments->cluster, true);
  evaluate->add_option("--variations", arguments->variations, "how many (default: the scenario's)")
      ->check(CLI::Range(1, 1000000));
  evaluate->add_option("--seed", arguments->seed, "of the variations (default: the scenario's)");
  evaluate->add_option(
      "--theta", arguments->theta,
      "initial, learned, random:K or NAME=VALUE,... with the others as by default (default: learned of a "
      "run, else initial)");
  evaluate->add_flag("--perturb", arguments->perturb,
                     "friction, mass and speed within 25%, starts moved by up to 2 mm and 2 degrees");
  evaluate->add_option("--csv", arguments->csv, "writes one row a variation: values, loss, success, certificate");
  evaluate->add_flag("--json", arguments->json, "print a JSON document on stdout");
  evaluate->add_flag("--quiet", arguments->quiet, "no progress");
  evaluate->callback([arguments, command] { *command = [arguments] { return RunEvaluate(*arguments); }; });
}

}  // namespace knap
