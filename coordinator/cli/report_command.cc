#include "coordinator/cli/report_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/count_progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/report_writing.h"
#include "coordinator/run/usage_error.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
  std::string run, out;
  bool quiet = false;
};

int RunReport(const ReportArguments& arguments) {
  const RunDirectory run = OpenRun(arguments.run);
  if (!fs::exists(run.result_path())) {
    throw UsageError(fmt::format("{}: has no result.json: the run has not ended; go on with: knap learn --resume {}",
                                 arguments.run, arguments.run));
  }
  const LoadedScenario scenario = LoadValidScenario(run.config_path(), {});
  RolloutModel model(scenario.files);
  const fs::path path = arguments.out.empty() ? run.report_path() : fs::path(arguments.out);
  std::optional<std::string> dropped;
  {
    StderrProgress shown(arguments.quiet, [&](const std::string& error) { dropped = error; });
    WriteReport(scenario, run, model, path, &shown);
  }
  WriteOutput(fmt::format("report  {} (open it in a browser)\n", CleanText(path.string())) + FormatDropped(dropped));
  return kExitDone;
}

}  // namespace

void AddReportCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* report = app->add_subcommand("report", "Writes a page on which one sees what came out of a run");
  report->add_option("run", arguments->run, "run directory")->required();
  report->add_option("--out", arguments->out, "file (default: report.html in the run directory)");
  report->add_flag("--quiet", arguments->quiet, "no progress");
  report->callback([arguments, command] { *command = [arguments] { return RunReport(*arguments); }; });
}

}  // namespace knap
