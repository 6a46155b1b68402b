#include "lcmtypes/wire/lcm_transport.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/socket_filter.h"

#if defined(__SANITIZE_THREAD__)
// glib makes its recursive mutexes on first use with atomics that the thread sanitizer does not see, for glib is not
// instrumented; liblcm locks one in every call.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() { return "race:g_static_rec_mutex_lock\n"; }
#endif

namespace knap {
namespace {

constexpr std::size_t kQueueCapacity = 16384;  // messages: at most 21 MB
constexpr int kWantedReceiveBuffer = 4 << 20;  // [byte]; the default holds 92 datagrams of 1 KB

// As much as we want and the kernel gives: asking for more makes liblcm complain.
int ChooseReceiveBuffer() {
  std::ifstream limit("/proc/sys/net/core/rmem_max");
  int maximum = kWantedReceiveBuffer;
  limit >> maximum;
  return std::min(kWantedReceiveBuffer, maximum);
}

// Checks the network, then completes the URL.
std::string PrepareUrl(const std::string& url) {
  if (!IsUdpm(url)) return url;
  UdpmAddress address = ParseUdpmUrl(url);
  CheckMulticast(address);
  address.options.emplace("recv_buf_size", std::to_string(ChooseReceiveBuffer()));
  return address.MakeUrl();
}

}  // namespace

LcmTransport::LcmTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock)
    : clock_(clock), lcm_(PrepareUrl(url)) {
  if (!lcm_.good()) throw std::runtime_error(fmt::format("LCM cannot use '{}'", url));
  if (IsUdpm(url)) {
    SubscribeFiltered(ParseUdpmUrl(url).port, channels);
  } else {
    SubscribeAll(channels);
  }
  stop_fd_ = eventfd(0, EFD_CLOEXEC);
  if (stop_fd_ < 0) throw std::runtime_error(fmt::format("eventfd: {}", std::strerror(errno)));
  receiver_ = std::thread([this] { DrainIntoQueue(); });
}

LcmTransport::~LcmTransport() {
  stopping_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(stop_fd_, &one, sizeof(one));  // ends the poll
  receiver_.join();
  close(stop_fd_);
}

void LcmTransport::SubscribeAll(const std::vector<std::string>& channels) {
  for (const std::string& channel : channels) {
    lcm_subscription_t* subscription = lcm_subscribe(lcm_.getUnderlyingLCM(), channel.c_str(), &Store, this);
    if (subscription == nullptr) throw std::runtime_error(fmt::format("LCM cannot subscribe to {}", channel));
    lcm_subscription_set_queue_capacity(subscription, 0);  // unlimited: our own queue is the bounded one
  }
}

void LcmTransport::SubscribeFiltered(int port, const std::vector<std::string>& channels) {
  if (channels.empty()) return;
  // liblcm opens its socket at the first subscription and keeps it to itself: it is the one that was not there before.
  static std::mutex finding_mutex;
  const std::lock_guard<std::mutex> finding(finding_mutex);
  const std::vector<int> before = FindUdpSockets(port);
  SubscribeAll(channels);
  bool found = false;
  for (const int fd : FindUdpSockets(port)) {
    if (std::find(before.begin(), before.end(), fd) != before.end()) continue;
    AttachFilter(fd, MakeChannelFilter(channels));
    socklen_t size = sizeof(receive_buffer_size_);
    getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &receive_buffer_size_, &size);
    found = true;
  }
  if (!found) throw std::runtime_error(fmt::format("LCM's socket on port {} cannot be found to filter it", port));
}

void LcmTransport::DrainIntoQueue() {
  // After the server of a tcpq URL has gone there is no descriptor any more, and handle would abort.
  while (!stopping_ && lcm_.getFileno() >= 0) {
    std::array<pollfd, 2> waiting{pollfd{lcm_.getFileno(), POLLIN, 0}, pollfd{stop_fd_, POLLIN, 0}};
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    if (waiting[0].revents != 0 && lcm_.handle() < 0) return;
  }
}

void LcmTransport::Store(const lcm_recv_buf_t* buffer, const char* channel, void* self_pointer) {
  LcmTransport* self = static_cast<LcmTransport*>(self_pointer);
  const std::int64_t arrival_us = self->clock_->now_us();
  const std::uint8_t* data = static_cast<const std::uint8_t*>(buffer->data);
  {
    const std::lock_guard<std::mutex> lock(self->mutex_);
    if (buffer->data_size > kMaxMessageSize) {
      ++self->counters_.dropped_too_large;
      return;
    }
    if (self->queue_.size() >= kQueueCapacity) {
      ++self->counters_.dropped_full_queue;
      return;
    }
    ++self->counters_.received;
    self->queue_.push_back({channel, {data, data + buffer->data_size}, arrival_us});
  }
  self->arrived_.notify_one();
}

void LcmTransport::Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  int result = -1;
  {
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    result = lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  ++(result == 0 ? counters_.published : counters_.publish_failures);
}

std::optional<Message> LcmTransport::Receive(std::int64_t timeout_us) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto ready = [this] { return !queue_.empty() || woken_; };
  if (timeout_us > 0) {
    arrived_.wait_until(lock, std::chrono::steady_clock::now() + std::chrono::microseconds(timeout_us), ready);
  }
  if (queue_.empty()) {
    woken_ = false;
    return std::nullopt;
  }
  Message message = std::move(queue_.front());
  queue_.pop_front();
  return message;
}

void LcmTransport::Wake() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    woken_ = true;
  }
  arrived_.notify_one();
}

TransportCounters LcmTransport::counters() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counters_;
}

}  // namespace knap
