#include "lcmtypes/wire/lcm_transport.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string_view>

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

constexpr int kWantedReceiveBuffer = 4 << 20;  // [byte]; the default holds 92 datagrams of 1 KB
constexpr std::size_t kHeaderSize = 8;         // LCM's magic and sequence number; the channel's name follows
constexpr int kDatagramsPerTurn = 256;         // then it looks whether to stop

// As much as we want and the kernel gives.
int ChooseReceiveBuffer() {
  std::ifstream limit("/proc/sys/net/core/rmem_max");
  int maximum = kWantedReceiveBuffer;
  limit >> maximum;
  return std::min(kWantedReceiveBuffer, maximum);
}

// Checks the network, for liblcm stalls or aborts on a bad one.
std::string PrepareUrl(const std::string& url) {
  const UdpmAddress address = ParseUdpmUrl(url);
  CheckMulticast(address);
  return address.MakeUrl();
}

[[noreturn]] void ThrowErrno(const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::strerror(errno)));
}

// A socket that hears these channels of the group. Bound to the group's own address: other groups on the port stay out.
int OpenReceiver(const UdpmAddress& address, const std::vector<std::string>& channels) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) ThrowErrno("socket");
  try {
    AttachFilter(fd, MakeChannelFilter(channels));
    const int on = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    const auto wanted = address.options.find("recv_buf_size");
    const int size = wanted == address.options.end() ? ChooseReceiveBuffer() : std::stoi(wanted->second);
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, sizeof(size));
    sockaddr_in group{};
    group.sin_family = AF_INET;
    group.sin_port = htons(static_cast<std::uint16_t>(address.port));
    inet_pton(AF_INET, address.group.c_str(), &group.sin_addr);
    ip_mreq membership{};
    membership.imr_multiaddr = group.sin_addr;
    membership.imr_interface.s_addr = INADDR_ANY;
    if (bind(fd, reinterpret_cast<const sockaddr*>(&group), sizeof(group)) != 0 ||
        setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
      ThrowErrno(fmt::format("listening at {}:{}", address.group, address.port));
    }
  } catch (...) {
    close(fd);
    throw;
  }
  return fd;
}

}  // namespace

LcmTransport::LcmTransport(const std::string& url, const std::vector<std::string>& channels, const Clock* clock)
    : clock_(clock), lcm_(PrepareUrl(url)) {
  if (!lcm_.good()) throw std::runtime_error(fmt::format("LCM cannot use '{}'", url));
  if (channels.empty()) return;
  receive_fd_ = OpenReceiver(ParseUdpmUrl(url), channels);
  socklen_t size = sizeof(receive_buffer_size_);
  getsockopt(receive_fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_size_, &size);
  stop_fd_ = eventfd(0, EFD_CLOEXEC);
  if (stop_fd_ < 0) {
    close(receive_fd_);
    ThrowErrno("eventfd");
  }
  receiver_ = std::thread([this] { DrainIntoQueue(); });
}

LcmTransport::~LcmTransport() {
  if (receive_fd_ < 0) return;
  stopping_ = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(stop_fd_, &one, sizeof(one));  // ends the poll
  receiver_.join();
  close(stop_fd_);
  close(receive_fd_);
}

void LcmTransport::DrainIntoQueue() {
  while (!stopping_) {
    std::array<pollfd, 2> waiting{pollfd{receive_fd_, POLLIN, 0}, pollfd{stop_fd_, POLLIN, 0}};
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    if (waiting[0].revents == 0) continue;
    try {
      TakeDatagrams();
    } catch (const std::bad_alloc&) {
      queue_.CountNoMemory();  // lost, like any other: this thread must not end the process
    }
  }
}

void LcmTransport::TakeDatagrams() {
  std::array<char, 65536> datagram;
  for (int i = 0; i < kDatagramsPerTurn; ++i) {
    const ssize_t received = recv(receive_fd_, datagram.data(), datagram.size(), 0);
    if (received < 0) return;
    // The filter let nothing pass but a header and a whole channel name; a kernel that did otherwise is not believed.
    const std::string_view bytes(datagram.data(), static_cast<std::size_t>(received));
    const std::size_t end = bytes.find('\0', kHeaderSize);
    if (end == std::string_view::npos) continue;
    const std::string channel(bytes.substr(kHeaderSize, end - kHeaderSize));
    const std::string_view payload = bytes.substr(end + 1);
    queue_.Put(channel, reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size(), clock_->now_us());
  }
}

void LcmTransport::Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  int result = -1;
  {
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    result = lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  queue_.CountPublished(result == 0);
}

}  // namespace knap
