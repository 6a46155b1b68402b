#include "coordinator/cli/status_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "coordinator/cli/bus_listening.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/progress/progress.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/loss_unit.h"
#include "coordinator/run/run_lives.h"
#include "coordinator/run/stop_signal.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/json_text.h"
#include "coordinator/watch/cluster_view.h"
#include "coordinator/watch/prometheus_text.h"
#include "coordinator/watch/status_text.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/open_transport.h"
#include "sim/scenarios/parse_scene.h"

namespace knap {
namespace {

constexpr const char* kLatestRun = "runs/latest";
constexpr std::int64_t kRedrawUs = 500'000;
constexpr std::int64_t kSettleUs = 1'200'000;  // after the first word: every worker and run speaks at least twice

struct StatusArguments {
  std::string run, lcm_url, key_file, prometheus;
  double wait_s = 3.0;
  bool json = false;
};

struct Bus {
  std::string url;
  RunKey key;
  KnownRuns known;
};

// The run's lives by their numbers on the bus. Without a scenario that can be read nothing is known: that stops nobody
// from watching.
KnownRuns ReadTraits(const RunDirectory& run, const std::vector<RunLife>& lives) {
  KnownRuns known;
  try {
    const ParseResult parsed = ParseScene(ReadFile(run.config_path()), run.config_path().string());
    if (!parsed.ok()) return {};
    for (const RunLife& life : lives) {
      known[life.run_id] = {FormatLossUnit(parsed.scene), parsed.scene.success.has_value()};
    }
  } catch (const std::system_error&) {
  }
  return known;
}

// A run's folder tells address and key, unless flags do, and what its losses mean.
Bus ChooseBus(const StatusArguments& arguments) {
  Bus bus{arguments.lcm_url, {}, {}};
  std::string key_file = arguments.key_file;
  std::string run = arguments.run;
  if (run.empty() && bus.url.empty() && std::filesystem::exists(kLatestRun)) run = kLatestRun;
  if (!run.empty()) {
    const RunDirectory folder = OpenRun(run);
    const std::vector<RunLife> lives = ReadLives(folder);
    if (bus.url.empty()) bus.url = lives.back().lcm_url;
    if (key_file.empty()) key_file = lives.back().key_file;
    bus.known = ReadTraits(folder, lives);
  }
  bus.url = ChooseLcmUrl(bus.url, kDefaultLcmUrl);
  if (!key_file.empty()) bus.key = RunKey::ReadFile(key_file);
  return bus;
}

bool HasSomebody(const ClusterView& view) { return !view.runs().empty() || !view.workers().empty(); }

bool AllRunsAreDone(const ClusterView& view) {
  return !view.runs().empty() && std::all_of(view.runs().begin(), view.runs().end(), [](const auto& entry) {
    return entry.second.status.state == run_status_t::kDone;
  });
}

// A table that is drawn anew in its place until every run is done or Ctrl-C.
void Watch(Transport* transport, const Clock& clock, const KnownRuns& known, ClusterView* view) {
  const std::atomic<bool>& stop = CatchStopSignals();
  std::size_t drawn_lines = 0;
  while (!stop) {
    const TerminalTraits traits = DetectTerminal(STDOUT_FILENO);  // the window may change
    const std::string text = FormatStatus(*view, known, clock.now_us(), traits.width, traits.colour);
    if (drawn_lines > 0) DrawOutput(fmt::format("\x1b[{}A\x1b[J", drawn_lines));
    DrawOutput(text);
    drawn_lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    if (AllRunsAreDone(*view)) return;
    ListenUntil(clock.now_us() + kRedrawUs, transport, clock, view);
    view->Forget(clock.now_us());
  }
}

int RunStatus(const StatusArguments& arguments) {
  const Bus bus = ChooseBus(arguments);
  const SteadyClock clock;
  const std::unique_ptr<Transport> transport = OpenTransport(bus.url, ClusterView::ListChannels(), &clock);
  ClusterView view(bus.key);
  const std::atomic<bool>& stop = CatchStopSignals();
  const std::int64_t give_up_us = clock.now_us() + static_cast<std::int64_t>(arguments.wait_s * 1e6);
  while (!HasSomebody(view) && clock.now_us() < give_up_us && !stop) {
    ListenUntil(std::min(give_up_us, clock.now_us() + 50'000), transport.get(), clock, &view);
  }
  if (!HasSomebody(view)) {
    throw std::runtime_error(fmt::format(
        "nobody is heard at {} within {} s{}", bus.url, arguments.wait_s,
        view.refusals().total() > 0 ? fmt::format(" ({} messages have another key)", view.refusals().total()) : ""));
  }
  const bool live = !arguments.json && arguments.prometheus.empty() && DetectTerminal(STDOUT_FILENO).is_terminal;
  if (live) {
    Watch(transport.get(), clock, bus.known, &view);
    return kExitDone;
  }
  ListenUntil(clock.now_us() + kSettleUs, transport.get(), clock, &view);
  if (!arguments.prometheus.empty()) {
    WriteFileAtomically(arguments.prometheus, FormatPrometheus(view, clock.now_us()));
  } else if (arguments.json) {
    WriteOutput(fmt::format("{}\n", MakeJsonText(MakeStatusJson(view, bus.known, clock.now_us(), bus.url), 2)));
  } else {
    WriteOutput(FormatStatus(view, bus.known, clock.now_us(), 120, false));
  }
  return kExitDone;
}

}  // namespace

void AddStatusCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<StatusArguments>();
  CLI::App* status = app->add_subcommand("status", "Shows coordinator, workers, rates and time left of a run");
  status->add_option("run", arguments->run, "run directory, which tells address and key (default: runs/latest)");
  status->add_option("--lcm-url", arguments->lcm_url,
                     "LCM network (default: the run's; without one LCM_DEFAULT_URL, else LCM's default)");
  status->add_option("--key", arguments->key_file, "file with the run's key (default: the run's, else a public one)");
  status->add_option("--wait", arguments->wait_s, "seconds to wait for a first word (default: 3)")
      ->check(CLI::Range(0.1, 1e6));
  CLI::Option* json = status->add_flag("--json", arguments->json, "one snapshot as JSON on stdout");
  status
      ->add_option("--prometheus", arguments->prometheus,
                   "one snapshot into FILE as text for Prometheus, such as node_exporter collects")
      ->excludes(json);
  status->callback([arguments, command] { *command = [arguments] { return RunStatus(*arguments); }; });
}

}  // namespace knap
