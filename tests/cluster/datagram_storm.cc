// datagram_storm URL COUNT RATE SEED: throws hostile datagrams at a bus, so many, so many a second.
//
// In turn: random bytes; LCM headers with random rest; channel names without an end; fragments that come twice, wrap
// around or contradict each other (liblcm 1.3.1 crashes on some of these); knap's channels with random payload; and
// real datagrams of the bus itself, which it listens to, replayed, with bits flipped, cut, or on another channel.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/multicast.h"

namespace {

constexpr std::size_t kKept = 512;  // datagrams overheard
constexpr const char* kChannels[] = {"KNAP_RESULT",   "KNAP_WORKER_STATUS",   "KNAP_RUN_STATUS",     "KNAP_CONTROL",
                                     "KNAP_SCENARIO", "KNAP_REQUEST_local-1", "KNAP_CONTROL_local-2"};

std::string MakeBigEndian(std::uint64_t value, int bytes) {
  std::string s;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) s.push_back(static_cast<char>((value >> shift) & 0xff));
  return s;
}

class Storm {
 public:
  Storm(const knap::UdpmAddress& address, std::uint64_t seed) : random_(seed) {
    fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    const int on = 1;
    setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    const unsigned char ttl = 0;
    setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<std::uint16_t>(address.port));
    inet_pton(AF_INET, address.group.c_str(), &group_.sin_addr);
    ip_mreq membership{};
    membership.imr_multiaddr = group_.sin_addr;
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&group_), sizeof(group_)) != 0 ||
        setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
      throw std::runtime_error("cannot listen to the bus");
    }
  }
  ~Storm() { close(fd_); }
  Storm(const Storm&) = delete;
  Storm& operator=(const Storm&) = delete;

  // Keeps whole messages that others sent; our own, which come back too, are told by their sequence number's top bit.
  void Overhear() {
    char buffer[65536];
    for (int i = 0; i < 64; ++i) {
      const ssize_t size = recv(fd_, buffer, sizeof(buffer), 0);
      if (size < 0) return;
      if (size < 16 || std::string(buffer, 4) != "LC02" || (buffer[4] & 0x80) != 0) continue;
      std::string datagram(buffer, static_cast<std::size_t>(size));
      if (overheard_.size() < kKept) {
        overheard_.push_back(datagram);
      } else {
        overheard_[Draw(kKept)] = datagram;
      }
    }
  }

  void SendOne() {
    const std::string datagram = MakeDatagram();
    sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group_), sizeof(group_));
  }

  std::size_t overheard() const { return overheard_.size(); }

 private:
  std::size_t Draw(std::size_t below) { return static_cast<std::size_t>(random_() % below); }

  std::string MakeNoise(std::size_t size) {
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random_());
    return bytes;
  }

  std::string MakeShort(const std::string& channel, const std::string& payload) {
    return "LC02" + MakeBigEndian(0x80000000U | random_(), 4) + channel + std::string(1, '\0') + payload;
  }

  std::string PickChannel() { return kChannels[Draw(std::size(kChannels))]; }

  std::string MakeFragment() {
    const std::size_t count = Draw(4) == 0 ? 65535 : 1 + Draw(4);
    const std::uint64_t sequence = 0x80000000U + Draw(8);
    const std::uint64_t total = Draw(4) == 0 ? 0xffffffffU : Draw(3000);
    const std::uint64_t offset = Draw(3) == 0 ? 0xfffffff0U + Draw(16) : Draw(4000);
    return "LC03" + MakeBigEndian(sequence, 4) + MakeBigEndian(total, 4) + MakeBigEndian(offset, 4) +
           MakeBigEndian(Draw(count + 1), 2) + MakeBigEndian(count, 2) +
           (Draw(2) == 0 ? PickChannel() + std::string(1, '\0') : "") + MakeNoise(Draw(1200));
  }

  std::string MakeMutant() {
    if (overheard_.empty()) return MakeNoise(40);
    std::string datagram = overheard_[Draw(overheard_.size())];
    datagram[4] = static_cast<char>(datagram[4] | '\x80');
    switch (Draw(4)) {
      case 0:  // as it was: a replay
        break;
      case 1:
        for (std::size_t flips = 1 + Draw(8); flips > 0; --flips) {
          const std::size_t at = 8 + Draw(datagram.size() - 8);
          datagram[at] = static_cast<char>(datagram[at] ^ static_cast<char>(1 << Draw(8)));
        }
        break;
      case 2:
        datagram.resize(8 + Draw(datagram.size() - 8));
        break;
      default: {
        const std::size_t end = datagram.find('\0', 8);
        if (end != std::string::npos) datagram = MakeShort(PickChannel(), datagram.substr(end + 1));
      }
    }
    return datagram;
  }

  std::string MakeDatagram() {
    switch (Draw(6)) {
      case 0:
        return MakeNoise(Draw(1500));
      case 1:
        return (Draw(2) == 0 ? "LC02" : "LC03") + MakeNoise(Draw(100));
      case 2:
        return "LC02" + MakeBigEndian(0x80000000U, 4) + (Draw(2) == 0 ? PickChannel() : std::string(Draw(1400), 'K'));
      case 3:
        return MakeFragment();
      case 4:
        return MakeShort(PickChannel(), MakeNoise(Draw(1400)));
      default:
        return MakeMutant();
    }
  }

  std::mt19937_64 random_;
  int fd_ = -1;
  sockaddr_in group_{};
  std::vector<std::string> overheard_;
};

}  // namespace

int main(int argc, char** argv) try {
  knap::SecureStandardStreams();
  if (argc != 5) {
    knap::WriteMessage("usage: datagram_storm URL COUNT RATE SEED\n");
    return 2;
  }
  const long count = std::atol(argv[2]), rate = std::atol(argv[3]);
  Storm storm(knap::ParseUdpmUrl(argv[1]), std::strtoull(argv[4], nullptr, 10));
  const auto begin = std::chrono::steady_clock::now();
  for (long i = 0; i < count; ++i) {
    if (i % 16 == 0) {
      storm.Overhear();
      std::this_thread::sleep_until(begin + std::chrono::microseconds(1'000'000 * i / rate));
    }
    storm.SendOne();
  }
  knap::WriteOutput(fmt::format("{} datagrams, {} of the bus's own known\n", count, storm.overheard()));
  return 0;
} catch (const std::exception& e) {
  knap::WriteComplaint("datagram_storm", e.what());
  return 1;
}
