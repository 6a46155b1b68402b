// knap-relay [--host ADDRESS] [--port PORT]: the relay behind tcpq:// URLs.
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <exception>
#include <string>

#include "lcmtypes/program/command_line.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/tcpq_relay.h"

namespace {

std::atomic<bool> g_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void CatchSignal(int) { g_stop = true; }

// A descriptor a worker: as many as the system allows.
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

int main(int argc, char** argv) {
  knap::SecureStandardStreams();
  std::string host = "127.0.0.1";
  int port = 7700;
  CLI::App app("Relays LCM messages between clients of a tcpq:// URL, where multicast does not pass.", "knap-relay");
  app.add_option("--host", host, "IPv4 address to listen at (default: 127.0.0.1; 0.0.0.0: every network)");
  app.add_option("--port", port, "TCP port (default: 7700; 0: a free one)")->check(CLI::Range(0, 65535));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return knap::EndParsing(app, e);
  }
  std::signal(SIGTERM, CatchSignal);
  std::signal(SIGINT, CatchSignal);
  try {
    RaiseDescriptorLimit();
    knap::TcpqRelay relay(host, port);
    knap::WriteMessage(fmt::format("knap-relay: listening at tcpq://{}:{}\n", host, relay.port()));
    relay.Run(g_stop);
    const knap::TcpqRelayCounters& counters = relay.counters();
    knap::WriteMessage(fmt::format(
        "knap-relay: {} clients, {} messages, {} delivered, {} dropped, {} connections refused, {} closed for their "
        "hunger, {} times without a descriptor\n",
        counters.clients, counters.relayed, counters.delivered, counters.dropped, counters.refused, counters.hungry,
        counters.accept_failures));
  } catch (const std::exception& e) {
    knap::WriteComplaint("knap-relay", e.what());
    return 1;
  }
  return 0;
}
