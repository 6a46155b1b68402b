#include "coordinator/cli/rollout_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/cli/run_or_scenario.h"
#include "coordinator/cli/theta_choice.h"
#include "coordinator/report/trajectory_file.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_replay.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
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
};

double ReadSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Eigen::VectorXd ToVector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Everything that is written of a rollout, in one place for both forms.
struct RolloutRecord {
  const Scene& scene;
  const ParameterSpec& parameters;
  const std::vector<double>& theta;  // with controls and weights
  const RolloutInput& input;
  const RolloutOutput& output;
  double forward_s, gradient_s;
};

// dloss/dtheta_i; empty when the rollout has no gradient.
std::optional<double> GetDerivative(const RolloutRecord& record, std::size_t i) {
  const Eigen::VectorXd& design = record.output.gradient;
  const Eigen::VectorXd& controls = record.output.control_gradient;
  const auto k = static_cast<Eigen::Index>(i);
  if (k < record.input.theta.size()) return k < design.size() ? std::optional(design[k]) : std::nullopt;
  const Eigen::Index c = k - record.input.theta.size();
  return c < controls.size() ? std::optional(controls[c]) : std::nullopt;
}

nlohmann::ordered_json MakeJson(const RolloutRecord& record) {
  const RolloutOutput& output = record.output;
  nlohmann::ordered_json theta = nlohmann::ordered_json::object();
  nlohmann::ordered_json gradient = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < record.theta.size(); ++i) {
    const std::string& name = record.parameters.names[i];
    const std::optional<double> derivative = GetDerivative(record, i);
    theta[name] = record.theta[i];
    gradient[name] = derivative ? MakeJsonNumber(*derivative) : nullptr;
  }
  nlohmann::ordered_json variation = nlohmann::ordered_json::object();
  const std::vector<std::string> keys = ListVariedKeys(record.scene.variation);
  for (std::size_t i = 0; i < record.input.variation.size(); ++i) {
    variation[keys[i]] = record.input.variation[i];
  }
  return {{"scenario", record.scene.name},
          {"theta", std::move(theta)},
          {"variation", std::move(variation)},
          {"loss", MakeJsonNumber(output.loss)},
          {"success", record.scene.success ? nlohmann::ordered_json(output.success) : nullptr},
          {"gradient", std::move(gradient)},
          {"steps", output.steps},
          {"forward_s", record.forward_s},
          {"gradient_s", record.gradient_s},
          {"certificate",
           {{"finite", output.certificate.finite},
            {"converged", output.certificate.converged},
            {"trusted", output.distrust.empty()},
            {"distrust", output.distrust},
            {"penetration", MakeJsonNumber(output.certificate.penetration)},
            {"largest_force", MakeJsonNumber(output.certificate.largest_force)},
            {"gradient_reliable", output.gradient_reliable},
            {"reasons", output.doubts},
            {"loss_error", MakeJsonNumber(output.loss_error)},
            {"touchdown_share", MakeJsonNumber(output.touchdown_share)},
            {"gradient_change", MakeJsonNumber(output.gradient_change)},
            {"loss_rounding", MakeJsonNumber(output.loss_rounding)},
            {"worst_residual", MakeJsonNumber(output.certificate.worst_residual)},
            {"subdivided_steps", output.certificate.subdivided_steps},
            {"rejected_steps", output.certificate.rejected_steps},
            {"newton_iterations", output.certificate.newton_iterations},
            {"contact_onsets", output.certificate.contact_onsets},
            {"failure", output.failure.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(output.failure)}}}};
}

std::string FormatRecord(const RolloutRecord& record) {
  const RolloutOutput& output = record.output;
  const auto yes = [](bool value) { return value ? "yes" : "no"; };
  std::string text;
  const auto out = std::back_inserter(text);
  const bool distils = record.input.theta_reference.size() + record.input.controls_reference.size() > 0;
  fmt::format_to(out, "loss       {:.9g}{}\n", output.loss,
                 distils ? "  (distillation)" : FormatLossUnit(record.scene));
  fmt::format_to(out, "success    {}\n", record.scene.success ? yes(output.success) : "no success test");
  fmt::format_to(out, "steps      {}\n", output.steps);
  fmt::format_to(out, "time       {:.1f} ms forward, {:.1f} ms gradient\n", 1e3 * record.forward_s,
                 1e3 * record.gradient_s);
  fmt::format_to(out,
                 "certified  finite {}, converged {}; worst residual {:.1e}, {} steps subdivided, {} contact onsets\n",
                 yes(output.certificate.finite), yes(output.certificate.converged), output.certificate.worst_residual,
                 output.certificate.subdivided_steps, output.certificate.contact_onsets);
  fmt::format_to(out, "           deepest contact {:.2g}% of the thinner body, largest force {:.3g} N\n",
                 100.0 * output.certificate.penetration, output.certificate.largest_force);
  for (const std::string& reason : output.distrust) {
    fmt::format_to(out, "           not to be trusted, and no success: {}\n", reason);
  }
  if (std::isfinite(output.loss_error)) {
    fmt::format_to(out, "           time steps, Newton and rounding move the loss by about {:.1e}\n",
                   output.loss_error);
  }
  if (output.gradient.size() + output.control_gradient.size() > 0) {
    fmt::format_to(out, "           gradient reliable {}{}{}\n", yes(output.gradient_reliable),
                   output.doubts.empty() ? "" : ": ", fmt::join(output.doubts, ", "));
  }
  if (!output.failure.empty()) fmt::format_to(out, "failed     {}\n", output.failure);
  if (!record.input.variation.empty()) fmt::format_to(out, "\n{:<36} {:>16}\n", "varied key", "value [SI]");
  const std::vector<std::string> keys = ListVariedKeys(record.scene.variation);
  for (std::size_t i = 0; i < record.input.variation.size(); ++i) {
    fmt::format_to(out, "{:<36} {:>16.9g}\n", keys[i], record.input.variation[i]);
  }
  if (!record.theta.empty()) fmt::format_to(out, "\n{:<36} {:>16} {:>16}\n", "parameter", "theta [SI]", "dloss/dtheta");
  for (std::size_t i = 0; i < record.theta.size(); ++i) {
    const std::optional<double> derivative = GetDerivative(record, i);
    fmt::format_to(out, "{:<36} {:>16.9g} {:>16}\n", record.parameters.names[i], record.theta[i],
                   derivative ? fmt::format("{:.9g}", *derivative) : "none");
  }
  return text;
}

std::vector<double> ChooseVariation(const RolloutFlags& flags, const LoadedScenario& scenario) {
  const Scene& scene = scenario.parsed.scene;
  if (!flags.variation_values.empty()) return ParseVariationValues(flags.variation_values, "--variation-values", scene);
  if (!flags.variation) return ReadNominalVariation(scene);
  const std::uint64_t seed = flags.seed.value_or(static_cast<std::uint64_t>(scene.evaluation.seed));
  return SampleVariation(MakeProblem(scene, scenario.files).variations, seed, RandomStream::kTestVariations,
                         *flags.variation);
}

// The last `count` of `values` are controls or weights, the others design.
void SplitControls(const Eigen::VectorXd& values, std::size_t count, Eigen::VectorXd* design,
                   Eigen::VectorXd* controls) {
  const auto n = static_cast<Eigen::Index>(count);
  *design = values.head(values.size() - n);
  *controls = values.tail(n);
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
  SplitControls(ToVector(query->theta), controls, &input.theta, &input.controls);
  if (!query->theta_reference.empty()) {
    SplitControls(ToVector(query->theta_reference), controls, &input.theta_reference, &input.controls_reference);
  }
  input.variation = query->variation;
  input.want_gradient = query->gradient;
  return input;
}

RolloutInput MakeInput(const RolloutFlags& flags, const LoadedScenario& scenario, const ParameterSpec& parameters,
                       const NamedDesigns& designs) {
  RolloutInput input;
  const std::vector<double> theta = ChooseTheta(flags.theta, parameters, designs);
  SplitControls(ToVector(theta), parameters.controls, &input.theta, &input.controls);
  if (!flags.reference_theta.empty()) {
    const std::vector<double> reference =
        ParseTheta(flags.reference_theta, "--reference-theta", parameters, parameters.initial);
    SplitControls(ToVector(reference), parameters.controls, &input.theta_reference, &input.controls_reference);
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
  const RolloutInput input = is_request
                                 ? FindInput(flags, scenario)
                                 : MakeInput(flags, scenario, parameters, source.NameDesigns(parameters.names.size()));
  RolloutModel model(scenario.files);
  model.clock = ReadSeconds;
  const RolloutOutput output = model.Run(input, {});
  if (form != TrajectoryForm::kNone) {
    if (!output.failure.empty()) throw std::runtime_error("--trajectory: nothing was simulated: " + output.failure);
    WriteTrajectory(model.Record(input, 0.0).recording, form, flags.trajectory);
  }
  std::vector<double> theta(input.theta.begin(), input.theta.end());
  theta.insert(theta.end(), input.controls.begin(), input.controls.end());
  const RolloutRecord record{scene, parameters, theta, input, output, model.forward_s, model.gradient_s};
  WriteOutput(flags.json ? MakeJson(record).dump(2) + "\n" : FormatRecord(record));
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
  rollout->callback([flags, command] { *command = [flags] { return RunRollout(*flags); }; });
}

}  // namespace knap
