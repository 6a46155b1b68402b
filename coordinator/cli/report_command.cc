#include "coordinator/cli/report_command.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/progress/progress.h"
#include "coordinator/progress/stderr_progress.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/report_writing.h"
#include "coordinator/run/usage_error.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
  std::string run, other, out;
  bool quiet = false;
};

RunDirectory OpenEnded(const std::string& path) {
  const RunDirectory run = OpenRun(path);
  if (!fs::exists(run.result_path())) {
    throw UsageError(
        fmt::format("{0}: has no result.json: the run has not ended; go on with: knap learn --resume {0}", path));
  }
  return run;
}

int RunReport(const ReportArguments& arguments) {
  const RunDirectory run = OpenRun(arguments.run);
  const bool is_study = fs::exists(run.study_path());
  const LoadedScenario scenario = LoadValidScenario(run.config_path(), {});
  fs::path path = arguments.out.empty() ? run.report_path() : fs::path(arguments.out);
  std::optional<std::string> dropped;
  if (!arguments.other.empty()) {
    if (arguments.out.empty()) path = "comparison.html";
    WriteComparison(scenario, OpenEnded(arguments.run), OpenEnded(arguments.other), path);
  } else if (is_study) {
    WriteStudyReport(scenario, run, path);
  } else {
    OpenEnded(arguments.run);
    if (!fs::exists(run.journal_path())) {
      throw UsageError(
          fmt::format("{}: has no journal, as a run of a study: see the study's own report, or give two "
                      "of its runs",
                      arguments.run));
    }
    RolloutModel model(scenario.files);
    StderrProgress shown(arguments.quiet, [&](const std::string& error) { dropped = error; });
    const SteadyClock clock;
    const std::int64_t started_us = clock.now_us();
    ProgressState state;
    state.title = scenario.parsed.scene.name;
    state.phase = ProgressPhase::kReporting;
    WriteReport(scenario, run, model, path, [&](int done, int total) {
      state.elapsed_s = static_cast<double>(clock.now_us() - started_us) * 1e-6;
      state.replayed = done;
      state.replays = total;
      shown.Update(state);
    });
  }
  WriteOutput(fmt::format("report  {} (open it in a browser)\n", CleanText(path.string())) + FormatDropped(dropped));
  return kExitDone;
}

}  // namespace

void AddReportCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* report =
      app->add_subcommand("report", "Writes a page on which one sees what came out of a run or study, or of two runs");
  report->add_option("run", arguments->run, "run directory or study")->required();
  report->add_option("other", arguments->other, "another run, to be shown beside it");
  report->add_option("--out", arguments->out,
                     "file (default: report.html in the run directory; of two runs comparison.html here)");
  report->add_flag("--quiet", arguments->quiet, "no progress");
  report->callback([arguments, command] { *command = [arguments] { return RunReport(*arguments); }; });
}

}  // namespace knap
