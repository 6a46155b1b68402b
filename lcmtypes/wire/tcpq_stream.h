// LCM's tcpq protocol as bytes: what clients and a relay say to each other over one TCP connection.
//
// Both sides begin with a magic number and the version, 4 bytes each; all integers are big-endian uint32. Then follow
// messages: type (1 publish, 2 subscribe, 3 unsubscribe), length of the channel, channel, and for publish also length
// of the data, data. The relay sends `publish` alone. A subscription's channel is a regular expression; we know two
// forms of them, an exact name and a prefix with `.*` behind it, so that no stranger's expression is ever run.
//
// Lengths are checked before anything is kept of what they announce.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace knap {

inline constexpr std::uint32_t kTcpqServerMagic = 0x287617fa;
inline constexpr std::uint32_t kTcpqClientMagic = 0x287617fb;
inline constexpr std::uint32_t kTcpqVersion = 0x0100;
inline constexpr std::size_t kTcpqMaxChannel = 255;
inline constexpr std::size_t kTcpqMaxData = 1 << 16;  // larger than any message of ours: other programs share a relay

enum class TcpqType : std::uint32_t { kPublish = 1, kSubscribe = 2, kUnsubscribe = 3 };

struct TcpqMessage {
  TcpqType type = TcpqType::kPublish;
  std::string channel;
  std::vector<std::uint8_t> data;  // of kPublish
};

std::string EncodeTcpqHello(std::uint32_t magic);
std::string EncodeTcpqMessage(TcpqType type, std::string_view channel, const std::uint8_t* data, std::size_t size);

// Takes a connection's bytes as they come and gives back whole messages.
class TcpqReader {
 public:
  // `peer_magic`: what the other side must begin with.
  explicit TcpqReader(std::uint32_t peer_magic) : peer_magic_(peer_magic) {}

  void Append(const char* bytes, std::size_t size) { bytes_.append(bytes, size); }

  // The next whole message; empty when more bytes are needed, or after the stream broke the protocol.
  std::optional<TcpqMessage> Take();

  std::size_t held() const { return bytes_.capacity(); }  // memory of bytes not taken yet
  bool greeted() const { return greeted_; }               // Take has seen the other side's hello
  bool broken() const { return broken_; }                 // nothing more can be understood: close the connection

 private:
  std::optional<std::uint32_t> PeekInteger(std::size_t offset) const;

  std::uint32_t peer_magic_;
  std::string bytes_;
  std::size_t begin_ = 0;  // of what was not taken yet
  bool greeted_ = false;
  bool broken_ = false;
};

// Whether a subscription's pattern means this channel.
bool MatchesTcpqPattern(std::string_view pattern, std::string_view channel);

struct TcpqAddress {
  std::string host = "127.0.0.1";  // a name or an IPv4 address
  int port = 7700;
};

bool IsTcpq(const std::string& url);

// Parses tcpq://HOST:PORT, where each piece may be missing. Throws std::invalid_argument naming the URL and the piece.
TcpqAddress ParseTcpqUrl(const std::string& url);

}  // namespace knap
