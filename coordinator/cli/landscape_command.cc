#include "coordinator/cli/landscape_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/cli/run_or_scenario.h"
#include "coordinator/cli/theta_choice.h"
#include "coordinator/landscape/landscape.h"
#include "coordinator/learning/problem.h"
#include "coordinator/report/landscape_picture.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

constexpr int kDefaultVariations = 20;

struct LandscapeArguments {
  std::string path;  // of a run or a scenario file
  std::vector<std::string> overrides;
  std::string x, y;
  int grid = 41;
  std::string theta, out;
  std::optional<std::uint64_t> variation;
  std::optional<int> variations;
  std::optional<std::uint64_t> seed;
  ClusterOptions cluster;
  bool quiet = false;
};

struct ChosenVariations {
  std::vector<std::vector<double>> values;
  std::string description;
};

ChosenVariations ChooseVariations(const LandscapeArguments& arguments, const Scene& scene, const Problem& problem) {
  if (problem.variations.empty()) {
    if (arguments.variation || arguments.variations || arguments.seed) {
      throw UsageError(
          "--variation, --variations and --seed: the scenario has no section variation, so all rollouts start alike");
    }
    return {{{}}, "loss"};
  }
  const std::uint64_t seed = arguments.seed.value_or(static_cast<std::uint64_t>(scene.evaluation.seed));
  const std::uint64_t first = arguments.variation.value_or(0);
  const int count = arguments.variation ? 1 : arguments.variations.value_or(kDefaultVariations);
  ChosenVariations chosen;
  for (int i = 0; i < count; ++i) {
    chosen.values.push_back(SampleVariation(problem.variations, seed, RandomStream::kTestVariations,
                                            first + static_cast<std::uint64_t>(i)));
  }
  chosen.description = arguments.variation ? fmt::format("test variation {} of seed {}", first, seed)
                                           : fmt::format("mean of {} test variations of seed {}", count, seed);
  return chosen;
}

std::string FormatPoint(const Landscape& landscape, const ParameterSpec& parameters, std::size_t cell) {
  const LandscapePlan& plan = landscape.plan;
  const auto format = [&](const LandscapeAxis& axis, std::size_t k) {
    return FormatParameter(parameters, axis.parameter, axis.values[k]);
  };
  return format(plan.x, cell % plan.x.values.size()) + ", " + format(plan.y, cell / plan.x.values.size());
}

void PrintSummary(const Landscape& landscape, const ParameterSpec& parameters, const Scene& scene,
                  const fs::path& out) {
  const std::vector<LandscapeCell>& cells = landscape.cells;
  std::size_t least = 0, best = 0, untrusted = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (cells[k].loss < cells[least].loss) least = k;
    if (cells[k].success_rate > cells[best].success_rate) best = k;
    untrusted += cells[k].not_finite + cells[k].not_converged > 0 ? 1 : 0;
  }
  WriteOutput(fmt::format("least mean loss  {:.4g}{} at {}\n", cells[least].loss, FormatLossUnit(scene),
                          FormatPoint(landscape, parameters, least)));
  if (scene.success) {
    WriteOutput(fmt::format("most successes   {:.1f}% at {}\n", 100.0 * cells[best].success_rate,
                            FormatPoint(landscape, parameters, best)));
  }
  if (untrusted > 0)
    WriteOutput(fmt::format("not to be trusted: rollouts of {} cells (hatched; see the CSV file)\n", untrusted));
  WriteOutput(fmt::format("figures          {}\n", CleanText((out / "landscape.csv").string())));
  WriteOutput(fmt::format("picture          {}\n", CleanText((out / "landscape.svg").string())));
}

int RunLandscape(const LandscapeArguments& arguments) {
  const RunOrScenario source(arguments.path);
  const LoadedScenario scenario = LoadValidScenario(source.config(), arguments.overrides);
  const Scene& scene = scenario.parsed.scene;
  const Problem problem = MakeProblem(scene, scenario.files);
  const ParameterSpec& parameters = problem.parameters;
  const NamedDesigns designs = source.NameDesigns(parameters.names.size());
  const std::string choice = arguments.theta.empty() ? designs.by_default : arguments.theta;

  LandscapePlan plan;
  plan.x = MakeAxis(parameters, FindParameter(arguments.x, "--x", parameters), arguments.grid);
  plan.y = MakeAxis(parameters, FindParameter(arguments.y, "--y", parameters), arguments.grid);
  if (plan.x.parameter == plan.y.parameter) throw UsageError("--y: expected another parameter than --x");
  plan.theta = ChooseTheta(choice, parameters, designs);
  const bool many = !arguments.variation && !problem.variations.empty();
  CheckRequestVolume("--grid and --variations",
                     {static_cast<double>(arguments.grid), static_cast<double>(arguments.grid),
                      many ? arguments.variations.value_or(kDefaultVariations) : 1.0},
                     parameters.names.size() + problem.variations.size());
  const ChosenVariations variations = ChooseVariations(arguments, scene, problem);
  plan.variations = variations.values;
  const std::int64_t rollouts = CalcRolloutCount(plan);
  ClusterSession session(arguments.cluster, FindEngineIdentity(arguments.cluster.engine), ListTaskFiles(scenario),
                         parameters.controls);
  const std::string out_name = MakeRunName(scene.name + "-landscape", std::chrono::system_clock::now());
  const fs::path out = CreateRun(arguments.out.empty() ? fs::path("runs") / out_name : fs::path(arguments.out)).path();

  session.StartWorkers();
  std::optional<Landscape> landscape;
  std::optional<std::string> dropped;
  {
    CountProgress progress(scene.name, scene.name + " landscape", rollouts, arguments.quiet, &session);
    landscape = EvaluateLandscape(std::move(plan), session.service());
    progress.Finish();
    dropped = progress.dropped();
  }
  session.Finish();
  WriteFileAtomically(out / "landscape.csv", MakeLandscapeCsv(*landscape, parameters));
  LandscapeCaption caption;
  caption.title = fmt::format("{}: {} × {}", scene.name, arguments.x, arguments.y);
  caption.subtitle = fmt::format("{}, {} × {} designs, all else as in the {} design", variations.description,
                                 arguments.grid, arguments.grid, choice);
  caption.theta_name = choice == "initial" || choice == "learned" ? choice : "given design";
  caption.has_success = scene.success.has_value();
  WriteFileAtomically(out / "landscape.svg", DrawLandscape(*landscape, parameters, caption));
  PrintSummary(*landscape, parameters, scene, out);
  WriteOutput(FormatDropped(dropped));
  return kExitDone;
}

}  // namespace

void AddLandscapeCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<LandscapeArguments>();
  CLI::App* landscape = app->add_subcommand("landscape", "The loss over a grid of two parameters, as CSV and picture");
  landscape->add_option("path", arguments->path, "scenario file or run directory")->required();
  landscape->add_option("overrides", arguments->overrides, "changes to the scenario: a.b=c");
  landscape->add_option("--x", arguments->x, "parameter along the horizontal axis, by name")->required();
  landscape->add_option("--y", arguments->y, "parameter along the vertical axis, by name")->required();
  landscape->add_option("--grid", arguments->grid, "values of each parameter, from bound to bound (default: 41)")
      ->check(CLI::Range(2, 1000));
  landscape->add_option("--theta", arguments->theta,
                        "all other parameters: initial, learned or NAME=VALUE,... (default: learned for a run)");
  CLI::Option* variation = landscape->add_option("--variation", arguments->variation, "number of one test variation");
  landscape->add_option("--variations", arguments->variations, "mean of the first so many (default: 20)")
      ->check(CLI::Range(1, 1000000))
      ->excludes(variation);
  landscape->add_option("--seed", arguments->seed, "of the test variations (default: the scenario's)");
  landscape->add_option("--out", arguments->out, "new or empty folder (default: runs/SCENARIO-landscape-UTC)");
  AddClusterFlags(landscape, &arguments->cluster);
  landscape->add_flag("--quiet", arguments->quiet, "no progress");
  landscape->callback([arguments, command] { *command = [arguments] { return RunLandscape(*arguments); }; });
}

}  // namespace knap
