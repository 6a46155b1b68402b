// A kernel filter on a UDP socket: only whole LCM messages on the channels that this process wants pass.
//
// liblcm 1.3.1 reassembles fragmented messages; a duplicated fragment gives wrong bytes as valid, two crafted ones
// crash the process, and so does a channel name without an end. We send no fragments, so nothing but datagrams with the
// short-message magic number and one of the wanted channel names, its NUL included, may pass. This also spares the
// process the cost of waking up for other people's messages.
#pragma once

#include <linux/filter.h>

#include <string>
#include <vector>

namespace knap {

// The classic BPF program. It sees the datagram from the UDP header on: 8 bytes header, then LCM's: magic number,
// sequence number (4 bytes each, big-endian), channel name with NUL, payload.
std::vector<sock_filter> MakeChannelFilter(const std::vector<std::string>& channels);

// Throws std::runtime_error when the kernel refuses the filter.
void AttachFilter(int fd, const std::vector<sock_filter>& program);

}  // namespace knap
