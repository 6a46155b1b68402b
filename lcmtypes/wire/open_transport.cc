#include "lcmtypes/wire/open_transport.h"

#include <fmt/format.h>

#include <stdexcept>

#include "lcmtypes/wire/lcm_transport.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/tcpq_transport.h"

namespace knap {

std::unique_ptr<Transport> OpenTransport(const std::string& url, const std::vector<std::string>& channels,
                                         const Clock* clock) {
  if (IsUdpm(url)) return std::make_unique<LcmTransport>(url, channels, clock);
  if (IsTcpq(url)) return std::make_unique<TcpqTransport>(url, channels, clock);
  throw std::invalid_argument(
      fmt::format("LCM URL '{}': udpm://GROUP:PORT?ttl=N and tcpq://HOST:PORT are allowed", url));
}

}  // namespace knap
