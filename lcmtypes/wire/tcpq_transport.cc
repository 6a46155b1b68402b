#include "lcmtypes/wire/tcpq_transport.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>

namespace knap {
namespace {

constexpr std::size_t kMaxUnsent = 4 << 20;  // [byte] for a relay that takes nothing; then messages are lost
constexpr int kAnswerMs = 2000;              // a relay that does not answer for so long is none
constexpr int kFirstTries = 4;               // half a second apart
constexpr int kFirstPauseMs = 100;
constexpr int kLongestPauseMs = 2000;
constexpr int kDeadMs = 10'000;  // sent and not acknowledged by the other kernel for so long: the host is gone

void SetOption(int fd, int level, int name, int value) { setsockopt(fd, level, name, &value, sizeof(value)); }

std::string DescribeError(int error) { return std::strerror(error); }

}  // namespace

TcpqTransport::TcpqTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock)
    : address_(ParseTcpqUrl(url)), channels_(channels), clock_(clock), wake_fd_(eventfd(0, EFD_CLOEXEC)) {
  if (wake_fd_ < 0) throw std::runtime_error(fmt::format("eventfd: {}", DescribeError(errno)));
  std::string failure = Connect();
  for (int i = 1; i < kFirstTries && !failure.empty(); ++i) {
    WaitFor(-1, 0, 500);
    failure = Connect();
  }
  if (!failure.empty()) {
    close(wake_fd_);
    throw std::runtime_error(fmt::format("no relay answers at {}:{} ({}); start one there with knap-relay",
                                         address_.host, address_.port, failure));
  }
  thread_ = std::thread([this] { Run(); });
}

TcpqTransport::~TcpqTransport() {
  stopping_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_fd_, &one, sizeof(one));
  thread_.join();
  Disconnect();
  close(wake_fd_);
}

bool TcpqTransport::WaitFor(int fd, short events, int timeout_ms) {
  std::array<pollfd, 2> waiting{pollfd{wake_fd_, POLLIN, 0}, pollfd{fd, events, 0}};
  const int ready = poll(waiting.data(), waiting.size(), timeout_ms);
  if (waiting[0].revents != 0) {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t taken = read(wake_fd_, &count, sizeof(count));
  }
  return ready > 0 && !stopping_;
}

std::string TcpqTransport::Connect() {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int unresolved = getaddrinfo(address_.host.c_str(), std::to_string(address_.port).c_str(), &hints, &found);
  if (unresolved != 0) return gai_strerror(unresolved);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> keep(found, freeaddrinfo);
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return DescribeError(errno);
  SetOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  SetOption(fd, IPPROTO_TCP, TCP_KEEPIDLE, 5);
  SetOption(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, kDeadMs);
  int error = connect(fd, found->ai_addr, found->ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    socklen_t size = sizeof(error);
    const bool answered = WaitFor(fd, POLLOUT, kAnswerMs);
    if (!answered || getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = ETIMEDOUT;
  }
  // Whoever accepts is a relay only when it greets.
  std::array<char, 8> hello{};
  if (error == 0 && (!WaitFor(fd, POLLIN, kAnswerMs) || recv(fd, hello.data(), hello.size(), MSG_PEEK) <= 0)) {
    error = ETIMEDOUT;
  }
  if (error != 0) {
    close(fd);
    return DescribeError(error);
  }
  const std::lock_guard<std::mutex> lock(send_mutex_);
  fd_ = fd;
  unsent_ = EncodeTcpqHello(kTcpqClientMagic);
  for (const std::string& channel : channels_) {
    unsent_ += EncodeTcpqMessage(TcpqType::kSubscribe, channel, nullptr, 0);
  }
  Flush();
  return "";
}

void TcpqTransport::Disconnect() {
  const std::lock_guard<std::mutex> lock(send_mutex_);
  if (fd_ >= 0) close(fd_);
  fd_ = -1;
  unsent_.clear();
}

bool TcpqTransport::Flush() {
  std::size_t sent = 0;
  bool alive = true;
  while (sent < unsent_.size()) {
    const ssize_t n = send(fd_, unsent_.data() + sent, unsent_.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      alive = errno == EAGAIN || errno == EWOULDBLOCK;
      break;
    }
    sent += static_cast<std::size_t>(n);
  }
  unsent_.erase(0, sent);
  return alive;
}

void TcpqTransport::Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  bool sent = false;
  bool left = false;
  {
    const std::lock_guard<std::mutex> lock(send_mutex_);
    if (fd_ >= 0 && unsent_.size() < kMaxUnsent) {
      unsent_ += EncodeTcpqMessage(TcpqType::kPublish, channel, bytes.data(), bytes.size());
      sent = Flush();
      left = !unsent_.empty();
    }
  }
  queue_.CountPublished(sent);
  if (!left) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_fd_, &one, sizeof(one));  // the thread sends the rest
}

bool TcpqTransport::ReadAll(TcpqReader* reader) {
  std::array<char, 65536> buffer;
  const ssize_t size = recv(fd_, buffer.data(), buffer.size(), 0);
  if (size == 0) return false;
  if (size < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  // A relay with Nagle's algorithm on waits for our acknowledgements; the kernel forgets this option by and by.
  SetOption(fd_, IPPROTO_TCP, TCP_QUICKACK, 1);
  const std::int64_t arrival_us = clock_->now_us();
  reader->Append(buffer.data(), static_cast<std::size_t>(size));
  while (const std::optional<TcpqMessage> message = reader->Take()) {
    if (std::find(channels_.begin(), channels_.end(), message->channel) == channels_.end()) continue;
    queue_.Put(message->channel, message->data.data(), message->data.size(), arrival_us);
  }
  return !reader->broken();
}

void TcpqTransport::Serve() {
  TcpqReader reader(kTcpqServerMagic);
  while (!stopping_) {
    bool blocked = false;
    {
      const std::lock_guard<std::mutex> lock(send_mutex_);
      if (!Flush()) return;
      blocked = !unsent_.empty();
    }
    if (!WaitFor(fd_, static_cast<short>(blocked ? POLLIN | POLLOUT : POLLIN), -1)) continue;
    if (!ReadAll(&reader)) return;
  }
}

void TcpqTransport::Run() {
  int pause_ms = kFirstPauseMs;
  while (!stopping_) {
    try {
      if (fd_ >= 0) {
        Serve();
        Disconnect();
        pause_ms = kFirstPauseMs;
      }
      WaitFor(-1, 0, pause_ms);
      pause_ms = std::min(2 * pause_ms, kLongestPauseMs);
      if (!stopping_) Connect();
    } catch (const std::bad_alloc&) {
      queue_.CountNoMemory();  // the connection is lost, like any other: this thread must not end the process
      Disconnect();
    }
  }
}

}  // namespace knap
