// LCM URLs of UDP multicast, and what must hold before liblcm may use one.
//
// liblcm stalls for 10 s or aborts the process when multicast does not work, so we try it first with a socket of our
// own and say what to do.
#pragma once

#include <map>
#include <string>

namespace knap {

inline constexpr char kPreflightChannel[] = "KNAP_PREFLIGHT";
inline constexpr char kDefaultLcmUrl[] = "udpm://239.255.76.67:7667?ttl=0";

struct UdpmAddress {
  std::string group = "239.255.76.67";
  int port = 7667;
  std::map<std::string, std::string> options;  // "ttl", "recv_buf_size"

  int ttl() const;
  std::string MakeUrl() const;
};

bool IsUdpm(const std::string& url);

// Parses udpm://GROUP:PORT?name=value&name=value; each piece may be missing.
// Throws std::invalid_argument naming the URL and the piece.
UdpmAddress ParseUdpmUrl(const std::string& url);

// Sends a preflight_t on kPreflightChannel to the group and waits for it to come back, up to one second. Throws
// std::runtime_error with the reason and the commands that help.
void CheckMulticast(const UdpmAddress& address);

// The default group on a UDP port that nobody on this machine has bound now: a bus of one's own for one run.
std::string MakeFreeLcmUrl();

// `flag` when not empty, else the environment's LCM_DEFAULT_URL when set, else `fallback`.
std::string ChooseLcmUrl(const std::string& flag, const std::string& fallback);

}  // namespace knap
