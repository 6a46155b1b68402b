// lossy_bridge URL_A URL_B SEED: joins two LCM buses by a bad line, until it is killed.
//
// Every datagram of one bus is sent on the other one: a fifth is lost, a tenth comes twice, and a fifth waits up to
// 30 ms, so that later ones overtake it. What the bridge itself sent is known by its source port and not sent back.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/multicast.h"

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLoss = 0.2, kTwice = 0.1, kDelayed = 0.2;
constexpr int kMostDelayUs = 30'000;

volatile std::sig_atomic_t g_stopped = 0;

void CatchSignal(int) { g_stopped = 1; }

// One bus: a socket that hears it, and one that speaks.
class Bus {
 public:
  explicit Bus(const std::string& url)
      : hears_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)), speaks_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const knap::UdpmAddress address = knap::ParseUdpmUrl(url);
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<std::uint16_t>(address.port));
    inet_pton(AF_INET, address.group.c_str(), &group_.sin_addr);
    const int on = 1, buffer = 4 << 20;
    setsockopt(hears_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    setsockopt(hears_, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof(buffer));
    ip_mreq membership{};
    membership.imr_multiaddr = group_.sin_addr;
    const unsigned char ttl = 0;
    socklen_t size = sizeof(own_);
    sockaddr_in any{};
    any.sin_family = AF_INET;
    if (bind(hears_, reinterpret_cast<const sockaddr*>(&group_), sizeof(group_)) != 0 ||
        setsockopt(hears_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0 ||
        setsockopt(speaks_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl)) != 0 ||
        bind(speaks_, reinterpret_cast<const sockaddr*>(&any), sizeof(any)) != 0 ||
        getsockname(speaks_, reinterpret_cast<sockaddr*>(&own_), &size) != 0) {
      throw std::runtime_error(url + ": cannot join this bus");
    }
  }
  ~Bus() {
    close(hears_);
    close(speaks_);
  }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  // The next datagram of somebody else's; empty when none waits. Messages are not longer than one Ethernet frame.
  std::string Hear() {
    char buffer[2048];
    while (true) {
      sockaddr_in from{};
      socklen_t size = sizeof(from);
      const ssize_t got = recvfrom(hears_, buffer, sizeof(buffer), 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) return {};
      if (got > 0 && from.sin_port != own_.sin_port) return {buffer, static_cast<std::size_t>(got)};
    }
  }

  void Speak(const std::string& datagram) {
    sendto(speaks_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group_), sizeof(group_));
  }

  int hears() const { return hears_; }

 private:
  int hears_, speaks_;
  sockaddr_in group_{}, own_{};
};

class Bridge {
 public:
  Bridge(const std::string& url_a, const std::string& url_b, std::uint64_t seed)
      : buses_{Bus(url_a), Bus(url_b)}, random_(seed) {}

  void Turn() {
    std::array<pollfd, 2> sockets{{{buses_[0].hears(), POLLIN, 0}, {buses_[1].hears(), POLLIN, 0}}};
    poll(sockets.data(), sockets.size(), delayed_.empty() ? 100 : 1);
    for (std::size_t from = 0; from < 2; ++from) {
      for (std::string datagram = buses_[from].Hear(); !datagram.empty(); datagram = buses_[from].Hear()) {
        ++heard_;
        if (Happens(kLoss)) {
          ++lost_;
          continue;
        }
        const bool twice = Happens(kTwice);
        twice_ += twice ? 1 : 0;
        for (int copy = 0; copy < (twice ? 2 : 1); ++copy) Carry(1 - from, datagram);
      }
    }
    while (!delayed_.empty() && delayed_.begin()->first <= Clock::now()) {
      const auto& [to, datagram] = delayed_.begin()->second;
      buses_[to].Speak(datagram);
      delayed_.erase(delayed_.begin());
    }
  }

  void Report() const {
    knap::WriteOutput(fmt::format("{} datagrams: {} lost, {} twice, {} late\n", heard_, lost_, twice_, late_));
  }

 private:
  bool Happens(double probability) { return std::uniform_real_distribution<>()(random_) < probability; }

  void Carry(std::size_t to, const std::string& datagram) {
    if (!Happens(kDelayed)) {
      buses_[to].Speak(datagram);
      return;
    }
    ++late_;
    const std::chrono::microseconds delay(static_cast<int>(random_() % kMostDelayUs));
    delayed_.emplace(Clock::now() + delay, std::pair(to, datagram));
  }

  std::array<Bus, 2> buses_;
  std::mt19937_64 random_;
  std::multimap<Clock::time_point, std::pair<std::size_t, std::string>> delayed_;
  std::int64_t heard_ = 0, lost_ = 0, twice_ = 0, late_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  knap::SecureStandardStreams();
  if (argc != 4) {
    knap::WriteMessage("usage: lossy_bridge URL_A URL_B SEED\n");
    return 2;
  }
  std::signal(SIGTERM, CatchSignal);
  std::signal(SIGINT, CatchSignal);
  try {
    Bridge bridge(argv[1], argv[2], std::strtoull(argv[3], nullptr, 10));
    while (!g_stopped) bridge.Turn();
    bridge.Report();
  } catch (const std::exception& e) {
    knap::WriteComplaint("lossy_bridge", e.what());
    return 1;
  }
}
