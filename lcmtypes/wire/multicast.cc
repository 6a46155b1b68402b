#include "lcmtypes/wire/multicast.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sodium.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "knap/preflight_t.hpp"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr std::string_view kScheme = "udpm://";

class Socket {
 public:
  Socket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

int ParseInteger(std::string_view text, int lower, int upper, const std::string& url, const char* what) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < lower || value > upper) {
    throw std::invalid_argument(
        fmt::format("LCM URL '{}': {} is '{}'; an integer from {} to {} is allowed", url, what, text, lower, upper));
  }
  return value;
}

sockaddr_in MakeAddress(const char* host, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, host, &address.sin_addr);
  return address;
}

bool Bind(const Socket& socket, const sockaddr_in& address) {
  return bind(socket.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

[[noreturn]] void ThrowNoMulticast(const UdpmAddress& address, const std::string& what) {
  throw std::runtime_error(fmt::format(
      "multicast to {}:{} does not work on this machine ({}). LCM needs a route for it: as root `ip link set lo up; ip "
      "route add 224.0.0.0/4 dev lo`, or without root run the whole command isolated, `unshare -Urn sh -c 'ip link set "
      "lo up; ip route add 224.0.0.0/4 dev lo; …'`",
      address.group, address.port, what));
}

std::uint64_t MakeNonce() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start");
  std::uint64_t nonce = 0;
  randombytes_buf(&nonce, sizeof(nonce));
  return nonce;
}

// The datagram of a short LCM message: magic, sequence number (0), channel with its NUL, the encoded message.
std::vector<char> MakeProbe() {
  constexpr std::string_view kMagicAndSequence("LC02\0\0\0\0", 8);
  preflight_t message{};
  message.nonce = static_cast<std::int64_t>(MakeNonce());
  std::vector<char> probe(kMagicAndSequence.begin(), kMagicAndSequence.end());
  probe.insert(probe.end(), kPreflightChannel, kPreflightChannel + sizeof(kPreflightChannel));
  const std::size_t header_size = probe.size();
  const int size = message.getEncodedSize();
  probe.resize(header_size + static_cast<std::size_t>(size));
  message.encode(probe.data() + header_size, 0, size);
  return probe;
}

}  // namespace

int UdpmAddress::ttl() const {
  const auto found = options.find("ttl");
  return found == options.end() ? 0 : ParseInteger(found->second, 0, 255, MakeUrl(), "ttl");
}

std::string UdpmAddress::MakeUrl() const {
  std::string url = fmt::format("{}{}:{}", kScheme, group, port);
  char separator = '?';
  for (const auto& [name, value] : options) {
    url += fmt::format("{}{}={}", separator, name, value);
    separator = '&';
  }
  return url;
}

bool IsUdpm(const std::string& url) { return url.compare(0, kScheme.size(), kScheme) == 0; }

UdpmAddress ParseUdpmUrl(const std::string& url) {
  if (!IsUdpm(url)) throw std::invalid_argument(fmt::format("LCM URL '{}': does not begin with {}", url, kScheme));
  UdpmAddress address;
  std::string_view rest = std::string_view(url).substr(kScheme.size());
  const std::string_view network = rest.substr(0, rest.find('?'));
  const std::string_view group = network.substr(0, network.find(':'));
  if (!group.empty()) address.group = group;
  in_addr parsed{};
  if (inet_pton(AF_INET, address.group.c_str(), &parsed) != 1 || !IN_MULTICAST(ntohl(parsed.s_addr))) {
    throw std::invalid_argument(
        fmt::format("LCM URL '{}': '{}' is no multicast address (224.0.0.0 to 239.255.255.255)", url, address.group));
  }
  if (network.size() > group.size()) {
    address.port = ParseInteger(network.substr(group.size() + 1), 1, 65535, url, "the port");
  }
  rest.remove_prefix(std::min(rest.size(), network.size() + 1));
  while (!rest.empty()) {
    const std::string_view option = rest.substr(0, rest.find('&'));
    const std::size_t equals = option.find('=');
    const std::string_view name = option.substr(0, equals);
    if (equals == std::string_view::npos || (name != "ttl" && name != "recv_buf_size")) {
      throw std::invalid_argument(
          fmt::format("LCM URL '{}': option '{}'; ttl=N and recv_buf_size=N are allowed", url, option));
    }
    ParseInteger(option.substr(equals + 1), 0, name == "ttl" ? 255 : 1 << 30, url,
                 name == "ttl" ? "ttl" : "recv_buf_size");
    address.options[std::string(name)] = option.substr(equals + 1);
    rest.remove_prefix(std::min(rest.size(), option.size() + 1));
  }
  return address;
}

void CheckMulticast(const UdpmAddress& address) {
  const sockaddr_in group = MakeAddress(address.group.c_str(), address.port);
  const Socket receiver;
  const int on = 1;
  setsockopt(receiver.fd(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  if (!Bind(receiver, MakeAddress("0.0.0.0", address.port))) {
    throw std::runtime_error(fmt::format("UDP port {} cannot be used: {}", address.port, std::strerror(errno)));
  }
  ip_mreq membership{};
  membership.imr_multiaddr = group.sin_addr;
  membership.imr_interface.s_addr = INADDR_ANY;
  if (setsockopt(receiver.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
    ThrowNoMulticast(address, fmt::format("joining the group: {}", std::strerror(errno)));
  }
  const Socket sender;
  const unsigned char ttl = static_cast<unsigned char>(address.ttl());
  setsockopt(sender.fd(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
  const std::vector<char> probe = MakeProbe();
  using SteadyTime = std::chrono::steady_clock;
  const auto deadline = SteadyTime::now() + std::chrono::seconds(1);
  std::vector<char> buffer(65536);
  while (SteadyTime::now() < deadline) {
    if (sendto(sender.fd(), probe.data(), probe.size(), 0, reinterpret_cast<const sockaddr*>(&group), sizeof(group)) <
        0) {
      ThrowNoMulticast(address, fmt::format("sending: {}", std::strerror(errno)));
    }
    pollfd waiting{receiver.fd(), POLLIN, 0};
    const auto next_send = SteadyTime::now() + std::chrono::milliseconds(100);
    while (SteadyTime::now() < next_send && poll(&waiting, 1, 100) > 0) {
      const ssize_t size = recv(receiver.fd(), buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (size == static_cast<ssize_t>(probe.size()) && std::memcmp(buffer.data(), probe.data(), probe.size()) == 0)
        return;
    }
  }
  ThrowNoMulticast(address, "what was sent does not come back: a firewall, or no route over a device that loops back");
}

std::string MakeFreeLcmUrl() {
  UdpmAddress address = ParseUdpmUrl(kDefaultLcmUrl);
  for (int attempt = 0; attempt < 100; ++attempt) {
    address.port = 20000 + static_cast<int>(MakeNonce() % 12000);  // below the kernel's ephemeral ports
    const Socket socket;
    if (Bind(socket, MakeAddress("0.0.0.0", address.port))) return address.MakeUrl();
  }
  throw std::runtime_error("no free UDP port between 20000 and 32000");
}

std::string ChooseLcmUrl(const std::string& flag, const std::string& fallback) {
  if (!flag.empty()) return CleanText(flag);
  const char* environment = std::getenv("LCM_DEFAULT_URL");
  return environment != nullptr && environment[0] != '\0' ? CleanText(environment) : fallback;
}

}  // namespace knap
