#include "coordinator/cli/rollout_command.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/cli/rollout_record.h"
#include "coordinator/cli/rollout_server.h"
#include "coordinator/cli/run_or_scenario.h"
#include "coordinator/cli/theta_choice.h"
#include "coordinator/report/trajectory_file.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_replay.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/scenario_bundle.h"
#include "sim/rollout/rollout.h"

namespace knap {
namespace {

struct RolloutFlags {
  std::string path;  // of a scenario file or a run
  std::vector<std::string> overrides;
  std::string theta;
  std::string reference_theta;
  std::optional<std::uint64_t> variation;
  std::string variation_values;
  std::optional<std::uint64_t> seed;
  std::string request;
  std::string trajectory;
  bool json = false;
  bool server = false;
};

std::vector<double> ChooseVariation(const RolloutFlags& flags, const LoadedScenario& scenario) {
  const Scene& scene = scenario.parsed.scene;
  if (!flags.variation_values.empty()) return ParseVariationValues(flags.variation_values, "--variation-values", scene);
  if (!flags.variation) return ReadNominalVariation(scene);
  return SampleTestVariation(scenario, flags.seed, *flags.variation);
}

// The request of a run whose id begins with flags.request.
RolloutInput FindInput(const RolloutFlags& flags, const LoadedScenario& scenario) {
  const Scene& scene = scenario.parsed.scene;
  ReplayedRun run;
  run.problem = MakeProblem(scene, scenario.files);
  run.options = MakeLearningOptions(scene);
  run.tests = static_cast<int>(scene.evaluation.variations);
  run.test_seed = static_cast<std::uint64_t>(scene.evaluation.seed);
  run.scenario = CalcScenarioId(EncodeBundle(ListTaskFiles(scenario)));
  const std::optional<RolloutQuery> query =
      FindRequest(run, Journal::Read(OpenRun(flags.path).journal_path()), flags.request);
  if (!query) {
    throw UsageError(fmt::format("--request {}: {} asked for no request with this id, as far as its journal goes",
                                 flags.request, flags.path));
  }
  RolloutInput input;
  const std::size_t controls = run.problem.parameters.controls;
  SplitControls(query->theta, controls, &input.theta, &input.controls);
  if (!query->theta_reference.empty()) {
    SplitControls(query->theta_reference, controls, &input.theta_reference, &input.controls_reference);
  }
  input.variation = query->variation;
  input.want_gradient = query->gradient;
  return input;
}

RolloutInput MakeInput(const RolloutFlags& flags, const LoadedScenario& scenario, const ParameterSpec& parameters,
                       const NamedDesigns& designs) {
  RolloutInput input;
  const std::vector<double> theta = ChooseTheta(flags.theta, parameters, designs);
  SplitControls(theta, parameters.controls, &input.theta, &input.controls);
  if (!flags.reference_theta.empty()) {
    const std::vector<double> reference =
        ParseTheta(flags.reference_theta, "--reference-theta", parameters, parameters.initial);
    SplitControls(reference, parameters.controls, &input.theta_reference, &input.controls_reference);
  }
  input.variation = ChooseVariation(flags, scenario);
  return input;
}

enum class TrajectoryForm { kNone, kCsv, kJson };

TrajectoryForm FindTrajectoryForm(const std::string& path) {
  if (path.empty()) return TrajectoryForm::kNone;
  if (path.ends_with(".csv")) return TrajectoryForm::kCsv;
  if (path.ends_with(".json")) return TrajectoryForm::kJson;
  throw UsageError(fmt::format("--trajectory: '{}': expected a name that ends with .csv or .json", path));
}

void WriteTrajectory(const Recording& recording, TrajectoryForm form, const std::string& path) {
  WriteFileAtomically(path, form == TrajectoryForm::kCsv ? FormatTrajectoryCsv(recording)
                                                         : MakeJsonText(MakeTrajectoryJson(recording), -1) + "\n");
}

int RunRollout(const RolloutFlags& flags) {
  const TrajectoryForm form = FindTrajectoryForm(flags.trajectory);
  const bool is_request = !flags.request.empty();
  const RunOrScenario source(flags.path);
  if (is_request) OpenRun(flags.path);
  const LoadedScenario scenario = LoadValidScenario(source.config(), flags.overrides);
  const Scene& scene = scenario.parsed.scene;
  const ParameterSpec parameters =
      HasParameters(scene) ? MakeProblem(scene, scenario.files).parameters : ParameterSpec();
  RolloutModel model(scenario.files);
  model.clock = ReadSteadySeconds;
  if (flags.server) {
    ServeRollouts(scenario, parameters, source.NameDesigns(parameters.names.size()), &model);
    return kExitDone;
  }
  const RolloutInput input = is_request
                                 ? FindInput(flags, scenario)
                                 : MakeInput(flags, scenario, parameters, source.NameDesigns(parameters.names.size()));
  const RolloutOutput output = model.Run(input, {});
  if (form != TrajectoryForm::kNone) {
    if (!output.failure.empty()) throw std::runtime_error("--trajectory: nothing was simulated: " + output.failure);
    WriteTrajectory(model.Record(input, 0.0).recording, form, flags.trajectory);
  }
  const RolloutRecord record{scene, parameters, input, output, model.forward_s, model.gradient_s};
  WriteOutput(flags.json ? MakeRolloutJson(record).dump(2) + "\n" : FormatRollout(record));
  return kExitDone;
}

}  // namespace

void AddRolloutCommand(CLI::App* app, std::function<int()>* command) {
  const auto flags = std::make_shared<RolloutFlags>();
  CLI::App* rollout = app->add_subcommand("rollout", "Runs one rollout in this process");
  rollout->add_option("path", flags->path, "scenario file or run directory")->required();
  rollout->add_option("overrides", flags->overrides, "changes to it, a.b=c");
  rollout->add_option(
      "--theta", flags->theta,
      "design: initial, learned, NAME=VALUE,… with the others as by default, or all values v1,v2,… (m, or with unit; "
      "default: learned of a run, else initial)");
  rollout->add_option("--reference-theta", flags->reference_theta,
                      "the distillation loss against the trajectory of this design, not the task loss");
  CLI::Option* variation = rollout->add_option("--variation", flags->variation,
                                               "number of a test variation (default: the file's own values)");
  rollout
      ->add_option("--variation-values", flags->variation_values,
                   "values v1,v2,… of the varied keys (SI, or with unit)")
      ->excludes(variation);
  rollout->add_option("--seed", flags->seed, "of the test variations (default: evaluation.seed)")->needs(variation);
  rollout->add_option("--request", flags->request, "the request of the run whose id begins with these digits")
      ->check(CLI::Validator(
          [](const std::string& id) {
            const bool is_id = id.size() >= 8 && id.find_first_not_of("0123456789abcdef") == std::string::npos;
            return is_id ? std::string() : std::string("8 to 64 of 0-9 a-f are allowed");
          },
          "ID"))
      ->excludes("overrides")
      ->excludes("--theta")
      ->excludes("--reference-theta")
      ->excludes(variation)
      ->excludes("--variation-values");
  rollout->add_option("--trajectory", flags->trajectory,
                      "writes poses, joints and contact forces at every step to FILE.csv or FILE.json");
  rollout->add_flag("--json", flags->json, "one JSON document on stdout");
  CLI::Option* server =
      rollout->add_flag("--server", flags->server, "answers one JSON line on stdout to each on stdin (docs/python.md)");
  for (CLI::Option* other : rollout->get_options()) {
    const std::string& name = other->get_name();
    if (other != server && name.rfind("--", 0) == 0 && name != "--help") server->excludes(other);
  }
  rollout->callback([flags, command] { *command = [flags] { return RunRollout(*flags); }; });
}

}  // namespace knap
