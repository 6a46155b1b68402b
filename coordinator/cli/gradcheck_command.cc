#include "coordinator/cli/gradcheck_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/gradcheck/gradient_check.h"
#include "coordinator/gradcheck/gradient_check_report.h"
#include "coordinator/run/cluster_session.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "lcmtypes/program/standard_streams.h"

namespace knap {
namespace {

struct GradcheckFlags {
  std::string config;
  std::vector<std::string> overrides;
  GradientCheckOptions check;
  std::optional<double> tolerance;  // the scenario's where it is not given
  ClusterOptions cluster;
  bool json = false;
};

int RunGradcheck(const GradcheckFlags& flags) {
  const LoadedScenario scenario = LoadValidScenario(flags.config, flags.overrides);
  const GradientDemand& demand = scenario.parsed.scene.gradient;
  GradientCheckOptions check = flags.check;
  check.tolerance = flags.tolerance.value_or(demand.tolerance);
  check.flagged = demand.flagged;
  const Problem problem = MakeProblem(scenario.parsed.scene, scenario.files);
  const std::size_t d = problem.parameters.names.size();
  CheckRequestVolume("--rollouts", {static_cast<double>(check.rollouts)}, 2 * d + problem.variations.size());
  CheckRequestVolume(fmt::format("differences in {} parameters", d),
                     {static_cast<double>(kQueriesPerParameter), static_cast<double>(d)},
                     d + problem.variations.size());
  ClusterSession session(flags.cluster, FindEngineIdentity(flags.cluster.engine), ListTaskFiles(scenario),
                         problem.parameters.controls);
  session.StartWorkers();

  GradientCheckReport report;
  std::optional<std::string> dropped;
  {
    const std::int64_t least = CalcLeastRollouts(problem, check);
    const std::string& name = scenario.parsed.scene.name;
    CountProgress progress(name, name + " gradient check", least, false, &session);
    const GradientCheckObserver observer{
        .on_round = [&](const GradientCheckProgress& p) { progress.set_rollouts(std::max(p.asked, least)); },
        .on_verdict = [&](const CheckedRollout& rollout) { progress.Say(FormatVerdict(rollout)); }};
    report = CheckGradients(problem, check, session.service(), observer);
    progress.Finish();
    dropped = progress.dropped();
  }
  session.Finish();

  if (flags.json) {
    nlohmann::ordered_json json = MakeGradientCheckJson(report, problem, check);
    if (dropped) json["progress_dropped"] = *dropped;
    WriteOutput(fmt::format("{}\n", json.dump(2)));
  } else {
    std::string command = "knap rollout " + QuoteForShell(flags.config);
    for (const std::string& change : flags.overrides) command += " " + QuoteForShell(change);
    WriteOutput(FormatGradientCheck(report, problem, check, command) + FormatDropped(dropped));
  }
  return ListFailures(report, check).empty() ? kExitDone : kExitFailed;
}

}  // namespace

void AddGradcheckCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<GradcheckFlags>();
  CLI::App* gradcheck = app->add_subcommand("gradcheck", "Compares rollout gradients with central differences");
  gradcheck->add_option("config", flags->config, "scenario file")->required();
  gradcheck->add_option("overrides", flags->overrides, "changes to it, a.b=c");
  gradcheck
      ->add_option("--rollouts", flags->check.rollouts, "rollouts with a non-zero gradient to check (default: 100)")
      ->check(CLI::Range(1, 1000000));
  gradcheck->add_option("--seed", flags->check.seed, "of the variations and designs (default: 0)");
  gradcheck->add_option("--tolerance", flags->tolerance, "relative to the largest component (default: the scenario's)")
      ->check(CLI::PositiveNumber);
  gradcheck->add_flag("--json", flags->json, "one JSON document on stdout");
  AddClusterFlags(gradcheck, &flags->cluster);
  gradcheck->callback([flags, command] { *command = [flags] { return RunGradcheck(*flags); }; });
}

}  // namespace knap
