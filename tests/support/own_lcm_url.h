// A bus that two test suites on one machine do not share by chance.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <random>
#include <string>

#include "lcmtypes/wire/multicast.h"

namespace knap {

// One of 65,536 groups on one of 12,000 ports of which nobody on this machine has bound that port now. The port alone
// is free only until the next test looks; a receiver is bound to its group as well.
inline std::string MakeOwnLcmUrl() {
  UdpmAddress address = ParseUdpmUrl(MakeFreeLcmUrl());
  const std::uint32_t bits = std::random_device()();
  address.group = fmt::format("239.255.{}.{}", bits % 256, bits / 256 % 256);
  return address.MakeUrl();
}

}  // namespace knap
