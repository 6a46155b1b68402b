#include "worker/worker_program.h"

#include <fmt/format.h>
#include <sodium.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <exception>
#include <stdexcept>
#include <string>

#include "lcmtypes/program/command_line.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/open_transport.h"
#include "worker/threaded_executor.h"
#include "worker/worker_reactor.h"

namespace knap {
namespace {

// A signal only sets this; the loop sees it within kSignalPollUs, so that nothing unsafe happens in the handler.
std::atomic<bool> g_interrupted{false};
constexpr std::int64_t kSignalPollUs = 100'000;
static_assert(std::atomic<bool>::is_always_lock_free);

void CatchSignal(int) { g_interrupted = true; }

std::string FindHostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

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

void Work(WorkerReactor* reactor, Transport* transport, const Clock& clock) {
  while (!g_interrupted && !reactor->stopped()) {
    const std::int64_t wait_us =
        std::clamp<std::int64_t>(reactor->next_deadline_us() - clock.now_us(), 0, kSignalPollUs);
    std::optional<Message> message = transport->Receive(wait_us);
    while (message) {
      reactor->Handle(*message);
      message = transport->Receive(0);
    }
    reactor->Tick();
  }
  if (!reactor->stopped()) reactor->SayGoodbye();
}

}  // namespace

int RunWorkerProgram(int argc, char** argv, std::unique_ptr<Engine> engine) {
  SecureStandardStreams();
  const std::string host = FindHostName();
  std::string url;
  std::string key_file;
  std::string name = MakeDefaultName(host);
  CLI::App app("Computes rollouts for a knap coordinator.", "knap-worker");
  app.add_option("--lcm-url", url, fmt::format("LCM network (default: LCM_DEFAULT_URL, else {})", kDefaultLcmUrl));
  app.add_option("--key", key_file, "file with the run's key (default: a public one)");
  app.add_option("--name", name, "name of this worker, 1 to 40 of A-Z a-z 0-9 _ - (default: HOST-PID)");
  try {
    app.parse(argc, argv);
    if (!IsName(name)) throw CLI::ValidationError("--name", fmt::format("'{}': 1 to 40 of A-Z a-z 0-9 _ -", name));
  } catch (const CLI::ParseError& e) {
    return EndParsing(app, e);
  }
  RunKey key;
  try {
    if (!key_file.empty()) key = RunKey::ReadFile(key_file);
  } catch (const std::exception& e) {
    WriteMessage(fmt::format("knap-worker: {}\n", e.what()));
    return 2;
  }
  std::signal(SIGTERM, CatchSignal);
  std::signal(SIGINT, CatchSignal);
  try {
    const SteadyClock clock;
    const std::unique_ptr<Transport> transport =
        OpenTransport(ChooseLcmUrl(url, kDefaultLcmUrl), WorkerReactor::ListChannels(name), &clock);
    ThreadedExecutor executor(engine.get(), [&transport] { transport->Wake(); });
    WorkerReactor reactor({name, MakeNonce(), engine->identity(), host, static_cast<std::int32_t>(getpid())}, key,
                          transport.get(), &clock, &executor);
    Work(&reactor, transport.get(), clock);
    // A computation cannot be broken off, and nobody waits for this one: leave without it.
    if (executor.busy()) std::_Exit(0);
  } catch (const std::invalid_argument& e) {
    WriteMessage(fmt::format("knap-worker: {}\n", e.what()));  // the URL
    return 2;
  } catch (const std::exception& e) {
    WriteMessage(fmt::format("knap-worker: {}\n", e.what()));
    return 1;
  }
  return 0;
}

}  // namespace knap
