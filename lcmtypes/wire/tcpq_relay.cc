#include "lcmtypes/wire/tcpq_relay.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <set>
#include <stdexcept>

namespace knap {
namespace {

constexpr std::size_t kMaxClients = 16384;
constexpr std::size_t kMaxUnsent = 4 << 20;    // [byte] a client
constexpr std::size_t kMaxPatterns = 256;      // a client
constexpr std::size_t kPatternOverhead = 100;  // [byte] a node of the set, and more
constexpr std::size_t kKeptBuffer = 4096;      // [byte] not given back when it is empty
constexpr int kLookMs = 200;
constexpr std::chrono::seconds kGreetingTime(5);
constexpr std::chrono::milliseconds kAcceptPause(100);  // when the system has no descriptor or memory for a client

}  // namespace

struct TcpqRelay::Client {
  explicit Client(int socket) : fd(socket), reader(kTcpqClientMagic), unsent(EncodeTcpqHello(kTcpqServerMagic)) {}
  ~Client() { close(fd); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  // Memory that its behaviour decides [byte].
  std::size_t CalcHeld() const { return reader.held() + unsent.capacity() + pattern_bytes; }

  int fd;
  TcpqReader reader;
  std::string unsent;
  std::set<std::string> patterns;
  std::size_t pattern_bytes = 0;
  std::size_t counted = 0;  // what it contributes to TcpqRelay::held_
  std::chrono::steady_clock::time_point accepted = std::chrono::steady_clock::now();
};

TcpqRelay::TcpqRelay(const std::string& host, int port, std::size_t memory)
    : memory_(memory), listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  const int on = 1;
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  socklen_t size = sizeof(address);
  sockaddr* const generic = reinterpret_cast<sockaddr*>(&address);
  std::string failure;
  if (inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    failure = "no IPv4 address";
  } else if (bind(listener_, generic, size) != 0 || listen(listener_, 128) != 0 ||
             getsockname(listener_, generic, &size) != 0) {
    failure = std::strerror(errno);
  }
  if (!failure.empty()) {
    if (listener_ >= 0) close(listener_);
    throw std::runtime_error(fmt::format("cannot listen at {}:{}: {}", host, port, failure));
  }
  port_ = ntohs(address.sin_port);
}

TcpqRelay::~TcpqRelay() { close(listener_); }

void TcpqRelay::Accept() {
  const int fd = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) {
    const bool nobody = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || errno == ECONNABORTED;
    if (nobody) return;
    // No descriptor, no memory: the client waits in the kernel's queue, which would wake us again and again.
    ++counters_.accept_failures;
    accept_after_ = std::chrono::steady_clock::now() + kAcceptPause;
    return;
  }
  if (clients_.size() >= kMaxClients) {
    ++counters_.refused;
    close(fd);
    return;
  }
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof(on));
  ++counters_.clients;
  clients_.push_back(std::make_unique<Client>(fd));
  Account(clients_.back().get());
}

void TcpqRelay::Account(Client* client) {
  const std::size_t held = client->CalcHeld();
  held_ = held_ - client->counted + held;
  client->counted = held;
  counters_.most_held = std::max(counters_.most_held, static_cast<std::int64_t>(held_));
}

bool TcpqRelay::Read(Client* client) {
  std::array<char, 65536> buffer;
  // Its buffer may double, and it may subscribe as often as it may.
  const std::size_t growth =
      2 * std::max(buffer.size(), client->reader.held()) + kMaxPatterns * (kTcpqMaxChannel + kPatternOverhead);
  if (held_ + growth > memory_) return true;  // it waits until others are closed
  const ssize_t size = recv(client->fd, buffer.data(), buffer.size(), 0);
  if (size == 0) return false;
  if (size < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  client->reader.Append(buffer.data(), static_cast<std::size_t>(size));
  Account(client);  // before what it sends is held for others
  while (const std::optional<TcpqMessage> message = client->reader.Take()) {
    if (message->type == TcpqType::kPublish) {
      Relay(*message);
    } else if (message->type == TcpqType::kUnsubscribe) {
      const std::size_t erased = client->patterns.erase(message->channel);
      client->pattern_bytes -= erased * (message->channel.size() + kPatternOverhead);
    } else if (client->patterns.size() < kMaxPatterns && client->patterns.insert(message->channel).second) {
      client->pattern_bytes += message->channel.size() + kPatternOverhead;
    }
  }
  Account(client);
  if (client->reader.broken()) ++counters_.refused;
  return !client->reader.broken();
}

void TcpqRelay::Relay(const TcpqMessage& message) {
  ++counters_.relayed;
  std::string bytes;  // made for the first who wants it
  for (const auto& client : clients_) {
    const bool wanted = std::any_of(client->patterns.begin(), client->patterns.end(), [&](const std::string& pattern) {
      return MatchesTcpqPattern(pattern, message.channel);
    });
    if (!wanted) continue;
    if (bytes.empty()) {
      bytes = EncodeTcpqMessage(TcpqType::kPublish, message.channel, message.data.data(), message.data.size());
    }
    // A string that grows may take twice its capacity.
    const std::size_t size = client->unsent.size() + bytes.size();
    const std::size_t growth = size <= client->unsent.capacity() ? 0 : std::max(size, client->unsent.capacity());
    if (client->unsent.size() > kMaxUnsent || held_ + growth > memory_) {
      ++counters_.dropped;
      continue;
    }
    client->unsent += bytes;
    Account(client.get());
    ++counters_.delivered;
  }
}

bool TcpqRelay::Flush(Client* client) {
  std::size_t sent = 0;
  bool alive = true;
  while (sent < client->unsent.size()) {
    const ssize_t n = send(client->fd, client->unsent.data() + sent, client->unsent.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      alive = errno == EAGAIN || errno == EWOULDBLOCK;
      break;
    }
    sent += static_cast<std::size_t>(n);
  }
  client->unsent.erase(0, sent);
  if (client->unsent.empty() && client->unsent.capacity() > kKeptBuffer) std::string().swap(client->unsent);
  Account(client);
  return alive;
}

void TcpqRelay::Wait() {
  const bool accepts = std::chrono::steady_clock::now() >= accept_after_;
  waiting_.assign(1, {listener_, static_cast<short>(accepts ? POLLIN : 0), 0});
  for (const auto& client : clients_) {
    waiting_.push_back({client->fd, static_cast<short>(client->unsent.empty() ? POLLIN : POLLIN | POLLOUT), 0});
  }
  const int look_ms = accepts ? kLookMs : static_cast<int>(kAcceptPause.count());
  if (poll(waiting_.data(), waiting_.size(), look_ms) < 0 && errno != EINTR) {
    throw std::runtime_error(fmt::format("poll: {}", std::strerror(errno)));
  }
}

void TcpqRelay::Close(const std::vector<bool>& lost) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    if (lost[i]) {
      held_ -= clients_[i]->counted;
      accept_after_ = {};  // a descriptor is free
    } else {
      clients_[kept++] = std::move(clients_[i]);
    }
  }
  clients_.resize(kept);
}

// So that a few who do not read cannot make all others lose their messages.
void TcpqRelay::CloseHungriest(std::vector<bool>* lost) {
  std::size_t held = held_;
  while (held > memory_ / 4 * 3) {
    std::size_t hungriest = lost->size();
    for (std::size_t i = 0; i < lost->size(); ++i) {
      if ((*lost)[i]) continue;
      if (hungriest == lost->size() || clients_[i]->counted > clients_[hungriest]->counted) hungriest = i;
    }
    if (hungriest == lost->size()) return;
    (*lost)[hungriest] = true;
    held -= clients_[hungriest]->counted;
    ++counters_.hungry;
  }
}

void TcpqRelay::Run(const std::atomic<bool>& stop) {
  while (!stop) {
    Wait();
    const auto now = std::chrono::steady_clock::now();
    std::vector<bool> lost(clients_.size(), false);
    for (std::size_t i = 0; i < lost.size(); ++i) {
      Client* client = clients_[i].get();
      if ((waiting_[i + 1].revents & ~POLLOUT) != 0) lost[i] = !Read(client);
      if (!client->reader.greeted() && now - client->accepted > kGreetingTime) lost[i] = true;
    }
    for (std::size_t i = 0; i < lost.size(); ++i) lost[i] = lost[i] || !Flush(clients_[i].get());
    CloseHungriest(&lost);
    Close(lost);
    if (waiting_[0].revents != 0) Accept();
  }
}

}  // namespace knap
