#include "worker/worker_program.h"

#include <fmt/format.h>
#include <sodium.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "lcmtypes/program/command_line.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/open_transport.h"
#include "lcmtypes/wire/text.h"
#include "worker/threaded_executor.h"
#include "worker/worker_reactor.h"

namespace knap {
namespace {

// A signal only sets this; the loop sees it within kSignalPollUs, so that nothing unsafe happens in the handler.
std::atomic<bool> g_interrupted{false};
std::atomic<bool> g_out_of_time{false};
constexpr std::int64_t kSignalPollUs = 100'000;
static_assert(std::atomic<bool>::is_always_lock_free);

void CatchSignal(int) { g_interrupted = true; }
void CatchTimeLimit(int) { g_out_of_time = true; }

void Complain(const std::string& what) { WriteComplaint("knap-worker", what); }

std::string MakeDefaultName(const std::string& host) {
  std::string name = host.substr(0, 24);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !IsName(std::string(1, c)); }, '-');
  return fmt::format("{}-{}", name.empty() ? "worker" : name, getpid());
}

std::int64_t MakeNonce() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start");
  std::int64_t nonce = 0;
  while (nonce == 0) randombytes_buf(&nonce, sizeof(nonce));
  return nonce;
}

// When this thread lacks something, the coordinator is told like when the computing one does.
void Work(WorkerReactor* reactor) {
  try {
    while (!g_interrupted && !g_out_of_time && !reactor->stopped()) reactor->Turn(kSignalPollUs);
    if (!reactor->stopped()) reactor->SayGoodbye(g_out_of_time ? "out of processor time (RLIMIT_CPU)" : "");
  } catch (const std::bad_alloc&) {
    reactor->SayGoodbye("out of memory");
  } catch (const std::system_error& e) {
    reactor->SayGoodbye(e.what());
  }
}

}  // namespace

int RunWorkerProgram(int argc, char** argv, const std::vector<EngineChoice>& engines) {
  SecureStandardStreams();
  const std::string host = FindHostName();
  std::string url;
  std::string key_file;
  std::string name = MakeDefaultName(host);
  std::string engine_name = engines.front().name;
  CLI::App app("Computes rollouts for a knap coordinator.", "knap-worker");
  app.add_option("--lcm-url", url, fmt::format("LCM network (default: LCM_DEFAULT_URL, else {})", kDefaultLcmUrl));
  app.add_option("--key", key_file, "file with the run's key (default: a public one)");
  app.add_option("--name", name, "name of this worker, 1 to 40 of A-Z a-z 0-9 _ - (default: HOST-PID)");
  if (engines.size() > 1) {
    std::vector<std::string> names;
    for (const EngineChoice& choice : engines) names.push_back(choice.name);
    app.add_option("--engine", engine_name, fmt::format("that computes (default: {})", engine_name))
        ->check(CLI::IsMember(names));
  }
  try {
    app.parse(argc, argv);
    if (!IsName(name)) {
      throw CLI::ValidationError("--name", fmt::format("'{}': 1 to 40 of A-Z a-z 0-9 _ -", name));
    }
  } catch (const CLI::ParseError& e) {
    return EndParsing(app, e);
  }
  RunKey key;
  try {
    if (!key_file.empty()) key = RunKey::ReadFile(key_file);
  } catch (const std::exception& e) {
    Complain(e.what());
    return 2;
  }
  std::signal(SIGTERM, CatchSignal);
  std::signal(SIGINT, CatchSignal);
  std::signal(SIGXCPU, CatchTimeLimit);
  try {
    const SteadyClock clock;
    const std::unique_ptr<Transport> transport =
        OpenTransport(ChooseLcmUrl(url, kDefaultLcmUrl), WorkerReactor::ListChannels(name), &clock);
    const auto choice =
        std::find_if(engines.begin(), engines.end(), [&](const EngineChoice& c) { return c.name == engine_name; });
    const std::unique_ptr<Engine> engine = choice->make();
    ThreadedExecutor executor(engine.get(), [&transport] { transport->Wake(); });
    WorkerReactor reactor({name, MakeNonce(), engine->identity(), host, static_cast<std::int32_t>(getpid())}, key,
                          transport.get(), &clock, &executor);
    Work(&reactor);
    const int exit_code = reactor.lack().empty() ? 0 : 1;
    if (exit_code != 0) Complain("leaves: " + reactor.lack());
    // A computation cannot be broken off, and nobody waits for this one: leave without it.
    if (executor.busy()) std::_Exit(exit_code);
    return exit_code;
  } catch (const std::invalid_argument& e) {
    Complain(e.what());  // the URL
    return 2;
  } catch (const std::bad_alloc&) {
    Complain("out of memory");
  } catch (const std::exception& e) {
    Complain(e.what());
  }
  return 1;
}

}  // namespace knap
