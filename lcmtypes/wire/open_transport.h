// The transport behind an LCM URL.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

// Hears `channels` at udpm://… (lcm_transport.h) or tcpq://… (tcpq_transport.h). Throws std::invalid_argument for
// another or a wrong URL, std::runtime_error with one clear line when the network does not work. `clock` must outlive
// the transport.
std::unique_ptr<Transport> OpenTransport(const std::string& url, const std::vector<std::string>& channels,
                                         const Clock* clock);

}  // namespace knap
