#include "coordinator/cli/explain_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/cli/bus_listening.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/rollout_arguments.h"
#include "coordinator/explain/explanation.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/run_lives.h"
#include "coordinator/run/usage_error.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/open_transport.h"
#include "lcmtypes/wire/scenario_bundle.h"
#include "lcmtypes/wire/text.h"
#include "sim/scenarios/numeric_keys.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewestDigits = 4;
constexpr std::size_t kMostDigits = 64;
constexpr std::size_t kMostMatches = 16;       // that a complaint lists
constexpr std::int64_t kSettleUs = 1'200'000;  // after the run's first word: every worker speaks at least twice

struct ExplainArguments {
  std::string run, request;
  double wait_s = 3.0;
};

RunDirectory OpenRecorded(const std::string& path) {
  RunDirectory run = OpenRun(path);
  if (fs::exists(run.rollouts_path()) && fs::exists(run.info_path())) return run;
  throw UsageError(fmt::format("{}: no record of single requests ({} is missing), as only `knap learn` writes one",
                               path, fs::exists(run.info_path()) ? "rollouts.csv" : "run.json"));
}

// In lower case. Checked before anything is read.
std::string ParseDigits(const std::string& text) {
  std::string digits = text;
  std::transform(digits.begin(), digits.end(), digits.begin(), [](unsigned char c) { return std::tolower(c); });
  if (digits.size() >= kFewestDigits && digits.size() <= kMostDigits &&
      digits.find_first_not_of("0123456789abcdef") == std::string::npos) {
    return digits;
  }
  throw UsageError(
      fmt::format("knap explain: '{}' is no request: the first {} to {} digits (0-9, a-f) of an id are "
                  "allowed",
                  text, kFewestDigits, kMostDigits));
}

std::string ChooseRequest(const ExplainedRun& run, const std::string& path, const std::string& digits) {
  const std::vector<std::string> found = FindRequests(run, digits);
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    throw UsageError(fmt::format("{}: no request on record begins with {}", path, digits));
  }
  std::vector<std::string> shown;
  for (std::size_t i = 0; i < std::min(found.size(), kMostMatches); ++i)
    shown.push_back(found[i].substr(0, kShortDigits));
  throw UsageError(fmt::format("{}: {} requests begin with {}: {}{}", path, found.size(), digits,
                               fmt::join(shown, ", "), shown.size() < found.size() ? ", …" : ""));
}

RunNames ReadNames(const RunDirectory& run, const RunRecord& record) {
  const LoadedScenario scenario = LoadScenario(run.config_path());
  if (!scenario.parsed.ok()) {
    const std::string errors = scenario.parsed.FormatErrors();
    throw std::runtime_error(errors.substr(0, errors.find('\n')));
  }
  Scene scene = scenario.parsed.scene;
  RunNames names;
  names.engine = record.engine.empty() ? "knap" : record.engine;
  names.scenario = CalcScenarioId(EncodeBundle(ListTaskFiles(scenario)));
  names.problem = MakeProblem(scene, scenario.files);
  names.learning = MakeLearningOptions(scene);
  names.tests = static_cast<int>(scene.evaluation.variations);
  names.test_seed = static_cast<std::uint64_t>(scene.evaluation.seed);
  std::map<std::string, Dimension> dimensions;
  for (const NumericKey& key : ListNumericKeys(scene)) dimensions[key.path] = key.dimension;
  for (const std::string& key : ListVariedKeys(scene.variation)) names.varied.emplace_back(key, dimensions[key]);
  names.loss_unit = FormatLossUnit(scene);
  names.has_success = scene.success.has_value();
  names.tried = ReadTriedDesigns(run, names.problem.parameters.names);
  if (fs::exists(run.result_path())) names.learned = ReadLearnedTheta(run, names.problem.parameters.names.size());
  return names;
}

std::string DescribeEnd(const RecordedLife& life, const std::string& path) {
  if (life.end == "done") return "it has ended, and waits for nothing";
  return fmt::format("it was {} at {:.3f} s; go on with: knap learn --resume {}", life.end, life.end_s, path);
}

// What the run's latest life says on the bus, unless its files say that it has ended.
void Listen(const ExplainArguments& arguments, const RunDirectory& folder, ExplainedRun* run) try {
  const std::vector<RecordedLife>& recorded = run->record.lives;
  if (!recorded.empty() && !recorded.back().end.empty()) {
    run->silence = DescribeEnd(recorded.back(), run->path);
    return;
  }
  const RunLife life = ReadLives(folder).back();
  const SteadyClock clock;
  const std::unique_ptr<Transport> transport = OpenTransport(life.lcm_url, ClusterView::ListChannels(), &clock);
  ClusterView view(life.key_file.empty() ? RunKey() : RunKey::ReadFile(life.key_file));
  const std::int64_t give_up_us = clock.now_us() + static_cast<std::int64_t>(arguments.wait_s * 1e6);
  while (view.runs().count(life.run_id) == 0 && clock.now_us() < give_up_us) {
    ListenUntil(std::min(give_up_us, clock.now_us() + 50'000), transport.get(), clock, &view);
  }
  if (view.runs().count(life.run_id) > 0) ListenUntil(clock.now_us() + kSettleUs, transport.get(), clock, &view);
  run->live = FindLiveRun(view, life.run_id);
  run->silence = fmt::format(
      "no end is on record, and at {} it was not heard within {} s; if it was killed, go on with: "
      "knap learn --resume {}",
      life.lcm_url, arguments.wait_s, run->path);
} catch (const std::exception& e) {
  run->silence = std::string("no end is on record, and it cannot be listened to: ") + e.what();
}

int RunExplain(const ExplainArguments& arguments) {
  const std::string digits = arguments.request.empty() ? "" : ParseDigits(arguments.request);
  const RunDirectory folder = OpenRecorded(arguments.run);
  ExplainedRun run;
  run.path = QuoteForShell(arguments.run);
  run.record = ReadRunRecord(folder);
  try {
    run.names = ReadNames(folder, run.record);
  } catch (const std::exception& e) {
    run.nameless = e.what();
  }
  Listen(arguments, folder, &run);
  WriteOutput(
      CleanLines(digits.empty() ? ExplainRun(run) : ExplainRequest(run, ChooseRequest(run, arguments.run, digits))));
  return kExitDone;
}

}  // namespace

void AddExplainCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<ExplainArguments>();
  CLI::App* explain =
      app->add_subcommand("explain", "Tells where requests of a run are or were, and why they were sent again");
  explain->add_option("run", arguments->run, "run directory")->required();
  explain->add_option("request", arguments->request,
                      "one of them: the first digits of its id, at least 4 (default: the whole run)");
  explain->add_option("--wait", arguments->wait_s, "seconds to listen for a run without an end (default: 3)")
      ->check(CLI::Range(0.1, 1e6));
  explain->callback([arguments, command] { *command = [arguments] { return RunExplain(*arguments); }; });
}

}  // namespace knap
