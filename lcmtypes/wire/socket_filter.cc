#include "lcmtypes/wire/socket_filter.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace knap {
namespace {

constexpr std::uint32_t kShortMessageMagic = 0x4c433032;  // "LC02"
constexpr std::uint32_t kMagicOffset = 8;
constexpr std::uint32_t kChannelOffset = 16;

sock_filter MakeStatement(int code, std::uint32_t k) { return {static_cast<std::uint16_t>(code), 0, 0, k}; }

// Goes on when the loaded value equals k, else skips `skip` instructions.
sock_filter MakeMatch(std::uint32_t k, std::size_t skip) {
  return {static_cast<std::uint16_t>(BPF_JMP | BPF_JEQ | BPF_K), 0, static_cast<std::uint8_t>(skip), k};
}

}  // namespace

std::vector<sock_filter> MakeChannelFilter(const std::vector<std::string>& channels) {
  std::vector<sock_filter> program;
  program.push_back(MakeStatement(BPF_LD | BPF_W | BPF_ABS, kMagicOffset));
  program.push_back(MakeMatch(kShortMessageMagic, 1));
  program.push_back(MakeStatement(BPF_JMP | BPF_JA, 1));
  program.push_back(MakeStatement(BPF_RET | BPF_K, 0));
  for (const std::string& channel : channels) {
    // One load and one comparison a byte, the NUL included; a load beyond the datagram's end refuses it.
    const std::size_t bytes = channel.size() + 1;
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::uint32_t offset = kChannelOffset + static_cast<std::uint32_t>(i);
      program.push_back(MakeStatement(BPF_LD | BPF_B | BPF_ABS, offset));
      // After a mismatch: past this channel's remaining instructions and its acceptance.
      program.push_back(MakeMatch(static_cast<unsigned char>(channel.c_str()[i]), 2 * (bytes - i - 1) + 1));
    }
    program.push_back(MakeStatement(BPF_RET | BPF_K, 0xffffffff));
  }
  program.push_back(MakeStatement(BPF_RET | BPF_K, 0));
  return program;
}

void AttachFilter(int fd, const std::vector<sock_filter>& program) {
  sock_fprog filter{};
  filter.len = static_cast<unsigned short>(program.size());
  filter.filter = const_cast<sock_filter*>(program.data());
  if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter)) != 0) {
    throw std::runtime_error(fmt::format("the kernel refuses the socket filter: {}", std::strerror(errno)));
  }
}

}  // namespace knap
