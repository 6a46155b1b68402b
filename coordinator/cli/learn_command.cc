#include "coordinator/cli/learn_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/cli/cluster_flags.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/listen_flag.h"
#include "coordinator/learning/evaluation.h"
#include "coordinator/report/report_document.h"
#include "coordinator/run/live_watch.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/prepared_scenario.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/report_writing.h"
#include "coordinator/run/run_recorder.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"
#include "sim/rollout/rollout.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

struct LearnArguments {
  std::string config;
  std::vector<std::string> overrides;
  ClusterOptions cluster;
  std::string out, resume, from, method, listen;
  std::optional<std::int64_t> seed;
  bool watch = false, dry_run = false, json = false, quiet = false;
};

// What the scenario is to start at, as an override.
std::string MakeStart(const RunDirectory& from, const fs::path& config, std::span<const std::string> overrides) {
  const LoadedScenario scenario = LoadValidScenario(config, overrides);
  const std::vector<std::string> names = MakeProblem(scenario.parsed.scene, scenario.files).parameters.names;
  // As few digits as give the same number again.
  return fmt::format("learning.start=[{}]", fmt::join(ReadLearnedByName(from, names, "--from"), ", "));
}

PreparedScenario Prepare(const LearnArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.method.empty()) overrides.push_back("learning.method=" + arguments.method);
  if (arguments.seed) overrides.push_back(fmt::format("learning.seed={}", *arguments.seed));
  if (!arguments.resume.empty()) return PrepareScenario(OpenRunOfThisBuild(arguments.resume).config_path(), overrides);
  if (arguments.from.empty()) return PrepareScenario(arguments.config, overrides);
  const RunDirectory from = OpenRun(arguments.from);
  const fs::path config = arguments.config.empty() ? from.config_path() : fs::path(arguments.config);
  // Where that run itself started is of no account.
  overrides.push_back("learning.start=[]");
  overrides.back() = MakeStart(from, config, overrides);
  return PrepareScenario(config, overrides);
}

int CountTests(const PreparedScenario& prepared) {
  return static_cast<int>(prepared.scenario.parsed.scene.evaluation.variations);
}

void PrintPlan(const PreparedScenario& prepared, const ClusterOptions& cluster) {
  const LearningOptions& options = prepared.options;
  const ParameterSpec& parameters = prepared.problem.parameters;
  WriteOutput(fmt::format("scenario    {}\n", prepared.scenario.parsed.scene.name));
  WriteOutput(fmt::format("method      {}, seed {}\n", GetName(options.method), options.seed));
  WriteOutput(fmt::format("parameters  {}\n", parameters.names.size()));
  for (std::size_t i = 0; i < parameters.names.size(); ++i) {
    const std::string unit = parameters.GetUnit(i);
    WriteOutput(fmt::format("  {:<20} {:g} in [{:g}, {:g}]{}{}{}\n", parameters.names[i], parameters.initial[i],
                            parameters.lower[i], parameters.upper[i], unit.empty() ? "" : " ", unit,
                            parameters.IsFixed(i) ? ", fixed" : ""));
  }
  WriteOutput(
      fmt::format("variations  {} in {} batches of {}\n", options.variations, CalcBatchCount(options), options.batch));
  WriteOutput(fmt::format("rollouts    at most {} for learning, {} for the test\n", CalcMostRollouts(options),
                          2 * CountTests(prepared)));
  WriteOutput(
      fmt::format("workers     {}\n", cluster.external ? "external" : std::to_string(CalcWorkerCount(cluster))));
}

// The run's folder with everything that does not depend on the answers.
RunDirectory MakeRun(const LearnArguments& arguments, const PreparedScenario& prepared, const RunInfo& info) {
  if (!arguments.resume.empty()) return OpenRun(arguments.resume);
  return MakeNewRun({"runs", arguments.out}, info, [&](const RunDirectory& run) {
    run.WriteRunInfo(info);
    WriteTools(*prepared.model, prepared.problem.parameters.initial, run, "initial");
    WriteScenario(prepared.scenario, run);
  });
}

std::string FormatRate(const TestSummary& test) {
  return fmt::format("{:.1f}% ({:.1f} to {:.1f}%)", 100.0 * test.success_rate, 100.0 * test.success_interval.lower,
                     100.0 * test.success_interval.upper);
}

std::string FormatFaults(const std::string& design, const TestSummary& test) {
  std::string text;
  if (const std::int64_t lost = test.not_converged + test.not_finite; lost > 0) {
    text += fmt::format(
        "  failed    {}: {} of {} test rollouts did not converge or are not finite, and count as failures "
        "with the worst loss\n",
        design, lost, test.variations);
  }
  if (test.untrusted > 0) {
    text += fmt::format("  distrust  {}: {} of {} test rollouts are not to be trusted: {}\n", design, test.untrusted,
                        test.variations, test.distrust);
  }
  return text;
}

// Whether it was worth it, and which batch's design it is.
std::string FormatVerdict(const ResultDocument& document, const std::string& loss_unit) {
  std::string text;
  const std::vector<BatchValidation>& validations = document.validations;
  if (!validations.empty()) {
    const auto& kept = validations[static_cast<std::size_t>(document.batch)];
    const std::string success =
        document.has_success ? fmt::format("{:.0f}% succeed, ", 100.0 * kept.test.success_rate) : "";
    text += fmt::format("  kept      {}, by {} validation variations: {}mean loss {:.4g}{}\n",
                        document.batch == 0 ? "the initial design"
                                            : fmt::format("batch {} of {}", document.batch, validations.size() - 1),
                        kept.test.variations, success, kept.test.loss_mean, loss_unit);
  }
  if (IsClearlyBetter(document.test_learned, document.test_initial)) return text;
  return text +
         "  verdict   no better than the initial design, as far as these variations tell; what to try: "
         "docs/when_it_does_not_learn.md\n";
}

std::string FormatSummary(const Scene& scene, const ResultDocument& document, const RunDirectory& run,
                          const std::string& from, bool has_report) {
  std::string text = fmt::format("\n{}: learned with {} ({} rollouts) in {}\n", document.scenario, document.method,
                                 document.rollouts_total, FormatDuration(document.wall_s));
  if (scene.success) {
    text +=
        fmt::format("  success   {} -> {} of {} unseen variations (95% interval)\n", FormatRate(document.test_initial),
                    FormatRate(document.test_learned), document.test_learned.variations);
  } else {
    text += "  success   no success test\n";
  }
  if (!scene.learning.start.empty()) {
    text += fmt::format("  started   at learning.start of the run's config.yaml, which is called initial here{}\n",
                        from.empty() ? "" : ": what " + CleanText(from) + " learned");
  }
  text += fmt::format("  mean loss {:.4g} -> {:.4g}{}\n", document.test_initial.loss_mean,
                      document.test_learned.loss_mean, FormatLossUnit(scene));
  text += FormatVerdict(document, FormatLossUnit(scene));
  text += FormatFaults("initial", document.test_initial) + FormatFaults("learned", document.test_learned);
  if (scene.design) {
    text += fmt::format(
        "  tool      {} and .3mf (millimetres)\n",
        CleanText((run.tool_path() / (scene.design->bodies.size() == 1 ? "learned.stl" : "learned_*.stl")).string()));
  }
  if (scene.policy) text += fmt::format("  policy    {}\n", CleanText((run.policy_path() / "learned.txt").string()));
  if (has_report) {
    text += fmt::format("  report    {} (open it in a browser)\n", CleanText(run.report_path().string()));
  }
  return text + fmt::format("  figures   {}, metrics.csv and more beside it\n", CleanText(run.result_path().string()));
}

ResultDocument LearnAndTest(const PreparedScenario& prepared, JournaledService& service, RunRecorder& recorder) {
  const LearningResult learned = Learn(prepared.problem, prepared.options, service, recorder);
  recorder.BeginTest();
  const Evaluation& evaluation = prepared.scenario.parsed.scene.evaluation;
  const auto seed = static_cast<std::uint64_t>(evaluation.seed);
  const auto test = [&](const std::vector<double>& theta) {
    return EvaluateDesign(prepared.problem.variations, theta, CountTests(prepared), seed, service).summary;
  };
  ResultDocument document;
  document.batch = learned.batch;
  document.validations = learned.validations;
  document.scenario = prepared.scenario.parsed.scene.name;
  document.method = GetName(prepared.options.method);
  document.seed = prepared.options.seed;
  document.parameters = prepared.problem.parameters;
  document.learned = learned.theta;
  document.has_success = prepared.scenario.parsed.scene.success.has_value();
  document.test_initial = test(prepared.problem.parameters.initial);
  document.test_learned = test(learned.theta);
  document.rollouts_total = service.total();
  document.rollouts_distinct = service.distinct();
  document.rollouts_reissued = recorder.reissued();
  document.wall_s = recorder.elapsed_s();
  recorder.FinishTest();
  return document;
}

// Without it the run is still whole, so what keeps it from being made is an event.
bool TryWriteReport(const PreparedScenario& prepared, const RunDirectory& run, RunRecorder* recorder) try {
  WriteReport(prepared.scenario, run, *prepared.model, run.report_path(),
              [recorder](int done, int total) { recorder->ShowReplay(done, total); });
  return true;
} catch (const std::exception& e) {
  recorder->TryRecordEvent("no_report", {{"error", CleanText(e.what())}});
  return false;
}

// The run does without what cannot be served.
void TryWatch(const ListenAddress& listen, const PreparedScenario& prepared, const RunDirectory& run,
              const ClusterSession& session, RunRecorder* recorder, std::optional<LiveWatch>* watch) try {
  watch->emplace(listen, prepared.scenario, run, session.lcm_url(), session.key_file());
  recorder->Say(fmt::format("watch   {}\n", (*watch)->url()));
} catch (const std::exception& e) {
  recorder->TryRecordEvent("no_watch", {{"error", CleanText(e.what())}});
  recorder->Say(fmt::format("no page to watch: {}\n", CleanText(e.what())));
}

int RunLearn(LearnArguments arguments) {
  // Behind --from a config may be left out; the first override then stands in its place.
  if (!arguments.from.empty() && arguments.config.find('=') != std::string::npos && !fs::exists(arguments.config)) {
    arguments.overrides.insert(arguments.overrides.begin(), std::move(arguments.config));
    arguments.config.clear();
  }
  const bool begins = !arguments.config.empty() || !arguments.from.empty();
  if (begins == !arguments.resume.empty()) {
    throw UsageError(
        "knap learn: expected either a CONFIG or --resume DIR, or --from RUN, with a CONFIG of its own or not");
  }
  if (!arguments.resume.empty() &&
      (!arguments.overrides.empty() || !arguments.method.empty() || arguments.seed || !arguments.out.empty())) {
    throw UsageError("knap learn: --resume continues a run as it is: without a.b=c, --method, --seed and --out");
  }
  const ListenAddress listen = ReadListenFlag(arguments.listen);
  const PreparedScenario prepared = Prepare(arguments);
  if (arguments.dry_run) {
    PrintPlan(prepared, arguments.cluster);
    return kExitDone;
  }
  const EngineIdentity engine = FindEngineIdentity(arguments.cluster.engine);
  RunInfo info = MakeRunInfo(prepared.scenario, prepared.config_hash, engine);
  info.started_from = CleanText(arguments.from);
  ClusterSession session(arguments.cluster, engine, ListTaskFiles(prepared.scenario),
                         prepared.problem.parameters.controls);
  const RunDirectory run = MakeRun(arguments, prepared, info);
  Journal::Opened journal = OpenRunJournal(run, info.identity);
  session.StartWorkers(run.path());
  JournaledService service(&session.dispatcher(), &journal.journal, std::move(journal.payloads));
  const RunPlan plan{prepared.scenario.parsed.scene.name,
                     GetName(prepared.options.method),
                     prepared.problem.parameters.names,
                     FormatLossUnit(prepared.scenario.parsed.scene),
                     2 * CountTests(prepared),
                     CountReplays(CountTests(prepared)),
                     prepared.scenario.parsed.scene.success.has_value()};
  RunRecorder recorder(plan, run, &session, &service, arguments.quiet);
  std::optional<LiveWatch> watch;
  if (arguments.watch) TryWatch(listen, prepared, run, session, &recorder, &watch);
  ResultDocument document;
  try {
    document = LearnAndTest(prepared, service, recorder);
  } catch (const Interrupted&) {
    recorder.TryRecordEnd("interrupted", {});
    throw Interrupted(fmt::format("interrupted; everything so far is saved, go on with: knap learn --resume {}",
                                  run.path().string()));
  } catch (const std::exception& e) {
    recorder.TryRecordEnd("failed", {{"error", CleanText(e.what())}});
    throw;
  }
  WriteTools(*prepared.model, document.learned, run, "learned");
  run.WriteResult(document);
  const bool has_report = TryWriteReport(prepared, run, &recorder);
  recorder.ShowEnd();
  recorder.TryRecordEvent("done", {{"wall_s", document.wall_s}});
  recorder.Say(FormatSummary(prepared.scenario.parsed.scene, document, run, arguments.from, has_report));
  if (arguments.json) WriteOutput(fmt::format("{}\n", MakeJsonText(MakeResultJson(document), 2)));
  if (watch && has_report) watch->HandOver(run.report_path());
  return kExitDone;
}

}  // namespace

void AddLearnCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<LearnArguments>();
  CLI::App* learn = app->add_subcommand("learn", "Learns the shape of a tool and writes a run directory");
  learn->add_option("config", arguments->config, "scenario file");
  learn->add_option("overrides", arguments->overrides, "changes to the scenario: a.b=c");
  AddClusterFlags(learn, &arguments->cluster);
  CLI::Option* out = learn->add_option("--out", arguments->out, "run directory (default: runs/<scenario>-<UTC>)");
  learn->add_option("--from", arguments->from,
                    "starts at what the run in this directory learned, whose parameters have the same names; without a "
                    "config its own scenario");
  learn->add_option("--resume", arguments->resume, "continue the run in this directory")->excludes(out);
  learn->add_option("--method", arguments->method, "ours, simple_continual or diffhand (default: the scenario's)");
  learn->add_option("--seed", arguments->seed, "of everything random (default: the scenario's)");
  CLI::Option* watch = learn->add_flag("--watch", arguments->watch, "serve a page on which one sees the run go on");
  AddListenFlag(learn, &arguments->listen)->needs(watch);
  learn->add_flag("--dry-run", arguments->dry_run, "check everything, print the plan and stop");
  learn->add_flag("--json", arguments->json, "print result.json on stdout");
  learn->add_flag("--quiet", arguments->quiet, "no progress and no summary");
  learn->callback([arguments, command] { *command = [arguments] { return RunLearn(*arguments); }; });
}

}  // namespace knap
