#include "coordinator/cli/trace_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/report/trace_json.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "lcmtypes/program/standard_streams.h"

namespace knap {
namespace {

struct TraceArguments {
  std::string run, out;
};

int RunTrace(const TraceArguments& arguments) {
  const RunDirectory run = OpenRun(arguments.run);
  const std::filesystem::path path = arguments.out.empty() ? run.trace_path() : std::filesystem::path(arguments.out);
  WriteFileAtomically(path, MakeJsonText(MakeTraceJson(run), -1) + "\n");
  WriteOutput(fmt::format("trace  {} (open it at ui.perfetto.dev or in chrome://tracing)\n", path.string()));
  return kExitDone;
}

}  // namespace

void AddTraceCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<TraceArguments>();
  CLI::App* trace = app->add_subcommand("trace", "Writes who computed what when in a run, for viewers of traces");
  trace->add_option("run", arguments->run, "run directory")->required();
  trace->add_option("--out", arguments->out, "file (default: trace.json in the run directory)");
  trace->callback([arguments, command] { *command = [arguments] { return RunTrace(*arguments); }; });
}

}  // namespace knap
