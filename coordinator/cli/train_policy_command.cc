#include "coordinator/cli/train_policy_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/policy_training.h"
#include "coordinator/run/prepared_scenario.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/training_recorder.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"
#include "sim/policy/weights_file.h"
#include "sim/rollout/build_policy.h"

namespace knap {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kMostDemonstrations = 1000;  // each has a thread of its own

constexpr int kMostRounds = 100;

struct TrainPolicyArguments {
  std::string config;
  std::vector<std::string> overrides;
  int demonstrations = 100, evaluations = 150, rounds = 3;
  std::int64_t seed = 0;
  ClusterOptions cluster;
  std::string out, resume;
  bool json = false, quiet = false;
};

// What is trained, and how its demonstrations are found.
struct TrainingPlan {
  PreparedScenario prepared;
  LoadedScenario open_loop;
  Problem problem;  // of the open loop
  DemonstrationOptions demonstrations;
};

fs::path FindPlan(const RunDirectory& folder) { return folder.path() / "training.json"; }

// Beside the configuration, what a training follows from: the first part of training.json.
Json MakePlanJson(const DemonstrationOptions& options) {
  return {{"schema", 1},
          {"demonstrations", options.variations},
          {"evaluations", options.learning.max_evaluations},
          {"rounds", options.rounds},
          {"seed", options.seed}};
}

void ReadPlan(const RunDirectory& folder, TrainPolicyArguments* arguments) {
  const fs::path path = FindPlan(folder);
  if (!fs::exists(path)) {
    throw UsageError(fmt::format("{}: no training (it holds no training.json)", folder.path().string()));
  }
  try {
    const Json plan = Json::parse(ReadFile(path));
    const auto read = [&](const char* key, std::int64_t most) {
      const auto value = plan.at(key).get<std::int64_t>();
      if (value < 1 || value > most) {
        throw UsageError(fmt::format("{}: {} is {}; 1 to {} are allowed", path.string(), key, value, most));
      }
      return static_cast<int>(value);
    };
    arguments->demonstrations = read("demonstrations", kMostDemonstrations);
    arguments->evaluations = read("evaluations", 1000000);
    arguments->rounds = read("rounds", kMostRounds);
    arguments->seed = plan.at("seed").get<std::int64_t>();
  } catch (const Json::exception& e) {
    throw UsageError(fmt::format("{}: {}", path.string(), e.what()));
  }
}

TrainingPlan MakePlan(const fs::path& config, const TrainPolicyArguments& arguments) {
  TrainingPlan plan;
  plan.prepared = PrepareScenario(config, arguments.overrides);
  DemonstrationOptions& options = plan.demonstrations;
  try {
    plan.open_loop = MakeOpenLoopScenario(plan.prepared.scenario);
    plan.problem = MakeProblem(plan.open_loop.parsed.scene, plan.open_loop.files);
    options.learning = MakeLearningOptions(plan.open_loop.parsed.scene);
  } catch (const std::exception& e) {
    throw UsageError(fmt::format("{}: {}", config.string(), e.what()));
  }
  options.variations = plan.problem.variations.empty() ? 1 : arguments.demonstrations;
  options.seed = static_cast<std::uint64_t>(arguments.seed);
  options.rounds = arguments.rounds;
  options.has_success = plan.open_loop.parsed.scene.success.has_value();
  options.learning.max_evaluations = arguments.evaluations;
  CheckRequestVolume("--demonstrations", {static_cast<double>(options.variations)},
                     plan.problem.parameters.names.size() + plan.problem.variations.size());
  return plan;
}

// How often the policy succeeds where it was shown how, with the design of each demonstration and with the initial one.
struct OwnTrials {
  int own_design = 0, initial_design = 0, trials = 0;
};

struct Training {
  std::vector<Demonstration> demonstrations;
  std::size_t examples = 0;
  Imitation imitation;
  OwnTrials trials;
  int successes = 0;
};

OwnTrials TryOnDemonstrations(const TrainingPlan& plan, const Training& training) {
  OwnTrials result;
  const std::vector<double>& initial = plan.prepared.problem.parameters.initial;
  const auto design_size = static_cast<std::size_t>(plan.prepared.model->num_parameters());
  for (const Demonstration& demonstration : training.demonstrations) {
    if (!demonstration.success) continue;
    ++result.trials;
    const auto succeeds = [&](const std::vector<double>& theta) {
      return TryPolicy(*plan.prepared.model, training.imitation.weights, std::span(theta).first(design_size),
                       demonstration.variation)
          .success;
    };
    result.own_design += succeeds(demonstration.theta) ? 1 : 0;
    result.initial_design += succeeds(initial) ? 1 : 0;
  }
  return result;
}

Training Train(const TrainingPlan& plan, std::vector<Demonstration> demonstrations) {
  Training training;
  training.demonstrations = std::move(demonstrations);
  for (const Demonstration& demonstration : training.demonstrations) training.successes += demonstration.success;
  if (training.successes == 0) {
    throw std::runtime_error(
        fmt::format("none of {} demonstrations succeeded, so there is nothing to imitate: allow more --evaluations, "
                    "or make the task easier",
                    training.demonstrations.size()));
  }
  const Policy& policy = *plan.prepared.scenario.parsed.scene.policy;
  RolloutModel open_loop(plan.open_loop.files);
  const Examples examples = CollectExamples(policy, open_loop, training.demonstrations);
  training.examples = examples.seen.size();
  training.imitation = Imitate(MakeNetwork(policy), examples, MakeImitationStart(policy, plan.demonstrations.seed),
                               {.lower = policy.lower, .upper = policy.upper});
  training.trials = TryOnDemonstrations(plan, training);
  return training;
}

// What the weights come from, for people; a line each.
std::string FormatProvenance(const TrainingPlan& plan, const Training& training, const std::string& build) {
  const bool has_success = plan.demonstrations.has_success;
  std::string text =
      fmt::format("weights of scenario {}, trained by knap train-policy\n", plan.prepared.scenario.parsed.scene.name);
  text += fmt::format("demonstrations {}, evaluations {}, rounds {}, seed {}; build {}\n",
                      plan.demonstrations.variations, plan.demonstrations.learning.max_evaluations,
                      plan.demonstrations.rounds, plan.demonstrations.seed, build);
  text +=
      fmt::format("{} demonstrations {}, {} examples, root mean square error of a command {:.4f} ({:.4f} at first)\n",
                  training.successes, has_success ? "succeeded" : "are to be trusted", training.examples,
                  training.imitation.error, training.imitation.start_error);
  if (has_success) {
    text += fmt::format(
        "in these variations the policy succeeds {} times with the design of the demonstration, {} "
        "times with the initial one\n",
        training.trials.own_design, training.trials.initial_design);
  }
  text.pop_back();
  return text;
}

Json MakeResultJson(const TrainingPlan& plan, const Training& training, double wall_s) {
  Json json = MakePlanJson(plan.demonstrations);
  const bool has_success = plan.demonstrations.has_success;
  const auto if_tested = [&](const Json& figure) { return has_success ? figure : Json(); };
  const std::size_t design = plan.problem.parameters.names.size() - plan.problem.parameters.controls;
  json["imitated"] = training.successes;
  json["examples"] = training.examples;
  json["error"] = MakeJsonNumber(training.imitation.error);
  json["start_error"] = MakeJsonNumber(training.imitation.start_error);
  json["imitation_evaluations"] = training.imitation.evaluations;
  json["policy_succeeds"] = {{"with_own_design", if_tested(training.trials.own_design)},
                             {"with_initial_design", if_tested(training.trials.initial_design)}};
  json["variation_names"] = ListNames(plan.problem.variations);
  json["results"] = Json::array();
  for (const Demonstration& d : training.demonstrations) {
    json["results"].push_back(
        {{"variation", d.variation},
         {"design", std::vector<double>(d.theta.begin(), d.theta.begin() + static_cast<std::ptrdiff_t>(design))},
         {"loss", MakeJsonNumber(d.loss)},
         {"success", if_tested(d.success)},
         {"trusted", d.trusted},
         {"round", d.round},
         {"evaluations", d.evaluations}});
  }
  json["wall_s"] = wall_s;
  return json;
}

int RunTrainPolicy(TrainPolicyArguments arguments) {
  if (arguments.config.empty() == arguments.resume.empty()) {
    throw UsageError("knap train-policy: expected either a CONFIG or --resume DIR");
  }
  if (!arguments.resume.empty() && !arguments.overrides.empty()) {
    throw UsageError("knap train-policy: --resume continues a training as it is: without a.b=c");
  }
  fs::path config = arguments.config;
  std::optional<RunDirectory> folder;
  if (!arguments.resume.empty()) {
    folder = OpenRunOfThisBuild(arguments.resume);
    ReadPlan(*folder, &arguments);
    config = folder->config_path();
  }
  const TrainingPlan plan = MakePlan(config, arguments);
  const EngineIdentity engine = FindEngineIdentity(arguments.cluster.engine);
  RunInfo info = MakeRunInfo(plan.prepared.scenario, plan.prepared.config_hash, engine);
  info.method = "train-policy";
  info.seed = plan.demonstrations.seed;
  ClusterSession session(arguments.cluster, engine, ListTaskFiles(plan.open_loop), plan.problem.parameters.controls);
  if (!folder) {
    folder = MakeNewRun({"policies", arguments.out}, info, [&](const RunDirectory& fresh) {
      fresh.WriteRunInfo(info);
      WriteFileAtomically(FindPlan(fresh), MakeJsonText(MakePlanJson(plan.demonstrations), 2) + "\n");
      WriteScenario(plan.prepared.scenario, fresh);
    });
  }
  Journal::Opened journal = OpenRunJournal(*folder, info.identity);
  session.StartWorkers(folder->path());
  JournaledService service(&session.dispatcher(), &journal.journal, std::move(journal.payloads));
  TrainingRecorder recorder(plan.prepared.scenario.parsed.scene.name, plan.demonstrations, *folder, &session, &service,
                            arguments.quiet);
  std::vector<Demonstration> demonstrations;
  try {
    demonstrations = FindDemonstrations(plan.problem, plan.demonstrations, service, recorder.MakeObserver());
  } catch (const Interrupted&) {
    throw Interrupted(fmt::format("interrupted; everything so far is saved, go on with: knap train-policy --resume {}",
                                  folder->path().string()));
  }
  recorder.Finish();
  const Training training = Train(plan, std::move(demonstrations));
  const std::string provenance = FormatProvenance(plan, training, info.build);
  const fs::path weights_path = folder->policy_path() / "trained.txt";
  fs::create_directories(folder->policy_path());
  const std::vector<double>& weights = training.imitation.weights;
  WriteFileAtomically(weights_path, FormatWeights(Eigen::Map<const Eigen::VectorXd>(
                                                      weights.data(), static_cast<Eigen::Index>(weights.size())),
                                                  provenance));
  const Json json = MakeResultJson(plan, training, recorder.elapsed_s());
  WriteFileAtomically(FindPlan(*folder), MakeJsonText(json, 2) + "\n");
  recorder.Say(fmt::format("\n{}\n\n  weights   {}\n  figures   {}\n", provenance, CleanText(weights_path.string()),
                           CleanText(FindPlan(*folder).string())));
  if (arguments.json) WriteOutput(fmt::format("{}\n", MakeJsonText(json, 2)));
  return kExitDone;
}

}  // namespace

void AddTrainPolicyCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<TrainPolicyArguments>();
  CLI::App* train = app->add_subcommand("train-policy", "Trains a policy to imitate demonstrations, found one by one");
  train->add_option("config", arguments->config, "scenario file with a policy");
  train->add_option("overrides", arguments->overrides, "changes to the scenario: a.b=c");
  CLI::Option* demonstrations =
      train->add_option("--demonstrations", arguments->demonstrations, "variations to try (default: 100)");
  demonstrations->check(CLI::Range(1, kMostDemonstrations));
  CLI::Option* evaluations = train->add_option("--evaluations", arguments->evaluations,
                                               "of design and controls in each, at most (default: 150)");
  evaluations->check(CLI::Range(2, 1000000));
  CLI::Option* rounds = train->add_option("--rounds", arguments->rounds,
                                          "at most so often those that failed try again from others (default: 3)");
  rounds->check(CLI::Range(1, kMostRounds));
  CLI::Option* seed = train->add_option("--seed", arguments->seed, "of variations and first weights (default: 0)");
  seed->check(CLI::Range(std::int64_t{0}, std::int64_t{9007199254740991}));
  AddClusterFlags(train, &arguments->cluster);
  CLI::Option* out = train->add_option("--out", arguments->out, "folder (default: policies/<scenario>-<UTC>)");
  train->add_option("--resume", arguments->resume, "continue the training in this folder")
      ->excludes(out)
      ->excludes(demonstrations)
      ->excludes(evaluations)
      ->excludes(rounds)
      ->excludes(seed);
  train->add_flag("--json", arguments->json, "print training.json on stdout");
  train->add_flag("--quiet", arguments->quiet, "no progress and no summary");
  train->callback([arguments, command] { *command = [arguments] { return RunTrainPolicy(*arguments); }; });
}

}  // namespace knap
