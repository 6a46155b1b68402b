#include "lcmtypes/wire/tcpq_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace knap {
namespace {

constexpr std::string_view kScheme = "tcpq://";
constexpr std::string_view kAnything = ".*";

void AppendInteger(std::uint32_t value, std::string* bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes->push_back(static_cast<char>((value >> shift) & 0xff));
}

}  // namespace

std::string EncodeTcpqHello(std::uint32_t magic) {
  std::string bytes;
  AppendInteger(magic, &bytes);
  AppendInteger(kTcpqVersion, &bytes);
  return bytes;
}

std::string EncodeTcpqMessage(TcpqType type, std::string_view channel, const std::uint8_t* data, std::size_t size) {
  std::string bytes;
  bytes.reserve(12 + channel.size() + size);
  AppendInteger(static_cast<std::uint32_t>(type), &bytes);
  AppendInteger(static_cast<std::uint32_t>(channel.size()), &bytes);
  bytes.append(channel);
  if (type == TcpqType::kPublish) {
    AppendInteger(static_cast<std::uint32_t>(size), &bytes);
    bytes.append(reinterpret_cast<const char*>(data), size);
  }
  return bytes;
}

std::optional<std::uint32_t> TcpqReader::PeekInteger(std::size_t offset) const {
  if (bytes_.size() - begin_ < offset + 4) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = (value << 8) | static_cast<unsigned char>(bytes_[begin_ + offset + i]);
  }
  return value;
}

std::optional<TcpqMessage> TcpqReader::Take() {
  if (broken_) return std::nullopt;
  if (begin_ > 4096 && 2 * begin_ > bytes_.size()) {
    bytes_.erase(0, begin_);
    begin_ = 0;
    if (bytes_.empty()) std::string().swap(bytes_);  // a client that is quiet holds no memory
  }
  if (!greeted_) {
    const auto magic = PeekInteger(0), version = PeekInteger(4);
    if (!magic || !version) return std::nullopt;
    broken_ = *magic != peer_magic_;  // every version since the first speaks alike, so it is not looked at
    if (broken_) return std::nullopt;
    begin_ += 8;
    greeted_ = true;
  }
  const auto type = PeekInteger(0), channel_size = PeekInteger(4);
  if (!type || !channel_size) return std::nullopt;
  broken_ = *type < 1 || *type > 3 || *channel_size > kTcpqMaxChannel;
  if (broken_ || bytes_.size() - begin_ < 8 + *channel_size) return std::nullopt;
  std::size_t end = 8 + *channel_size;
  TcpqMessage message;
  message.type = static_cast<TcpqType>(*type);
  message.channel = bytes_.substr(begin_ + 8, *channel_size);
  if (message.type == TcpqType::kPublish) {
    const auto data_size = PeekInteger(end);
    broken_ = data_size && *data_size > kTcpqMaxData;
    if (broken_ || !data_size || bytes_.size() - begin_ < end + 4 + *data_size) return std::nullopt;
    const auto first = bytes_.begin() + static_cast<std::ptrdiff_t>(begin_ + end + 4);
    message.data.assign(first, first + static_cast<std::ptrdiff_t>(*data_size));
    end += 4 + *data_size;
  }
  begin_ += end;
  return message;
}

bool MatchesTcpqPattern(std::string_view pattern, std::string_view channel) {
  if (pattern == channel) return true;
  if (pattern.size() < kAnything.size() || pattern.substr(pattern.size() - kAnything.size()) != kAnything) return false;
  const std::string_view prefix = pattern.substr(0, pattern.size() - kAnything.size());
  return channel.substr(0, prefix.size()) == prefix;
}

bool IsTcpq(const std::string& url) { return url.compare(0, kScheme.size(), kScheme) == 0; }

TcpqAddress ParseTcpqUrl(const std::string& url) {
  if (!IsTcpq(url)) throw std::invalid_argument(fmt::format("LCM URL '{}': does not begin with {}", url, kScheme));
  TcpqAddress address;
  const std::string_view rest = std::string_view(url).substr(kScheme.size());
  const std::size_t colon = rest.find(':');
  const std::string_view host = rest.substr(0, colon);
  if (!host.empty()) address.host = host;
  const bool named = std::all_of(address.host.begin(), address.host.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
           c == '_';
  });
  if (!named)
    throw std::invalid_argument(fmt::format("LCM URL '{}': '{}' is no host; HOST:PORT is allowed", url, host));
  if (colon != std::string_view::npos) {
    const std::string_view port = rest.substr(colon + 1);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    if (error != std::errc() || end != port.data() + port.size() || address.port < 1 || address.port > 65535) {
      throw std::invalid_argument(
          fmt::format("LCM URL '{}': the port is '{}'; an integer from 1 to 65535 is allowed", url, port));
    }
  }
  return address;
}

}  // namespace knap
