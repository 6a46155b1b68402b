#include "coordinator/cli/watch_command.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/listen_flag.h"
#include "coordinator/run/live_watch.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/run_lives.h"
#include "coordinator/run/stop_signal.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/growing_file.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr auto kLook = std::chrono::milliseconds(200);

struct WatchArguments {
  std::string run = "runs/latest", lcm_url, key_file, listen;
};

int RunWatch(const WatchArguments& arguments) {
  const RunDirectory run = OpenRun(arguments.run);
  if (std::filesystem::exists(run.result_path())) {
    throw UsageError(
        fmt::format("{0}: the run has ended; see its report.html, or make it: knap report {0}", arguments.run));
  }
  const LoadedScenario scenario = LoadValidScenario(run.config_path(), {});
  const RunLife life = ReadLives(run).back();
  const std::atomic<bool>& stop = CatchStopSignals();
  LiveWatch watch(ReadListenFlag(arguments.listen), scenario, run,
                  arguments.lcm_url.empty() ? life.lcm_url : arguments.lcm_url,
                  arguments.key_file.empty() ? life.key_file : arguments.key_file);
  WriteOutput(fmt::format("watch   {} (Ctrl-C ends it, not the run)\n", watch.url()));
  GrowingFile events(run.events_path());
  while (events.Take().lines.find("\"event\":\"done\"") == std::string::npos) {
    if (stop) return kExitDone;
    std::this_thread::sleep_for(kLook);
  }
  if (std::filesystem::exists(run.report_path())) {
    WriteOutput(fmt::format("ended   report {}\n", CleanText(run.report_path().string())));
    watch.HandOver(run.report_path());
  }
  return kExitDone;
}

}  // namespace

void AddWatchCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<WatchArguments>();
  CLI::App* watch = app->add_subcommand("watch", "Serves a page on which one sees a run go on, for a browser");
  watch->add_option("run", arguments->run, "run directory (default: runs/latest)");
  watch->add_option("--lcm-url", arguments->lcm_url, "LCM network (default: the run's)");
  watch->add_option("--key", arguments->key_file, "file with the run's key (default: the run's)");
  AddListenFlag(watch, &arguments->listen);
  watch->callback([arguments, command] { *command = [arguments] { return RunWatch(*arguments); }; });
}

}  // namespace knap
