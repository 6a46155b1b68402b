#include "lcmtypes/wire/scenario_bundle.h"

#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::string_view kMagic = "knap-scenario-1\n";

void AppendString(std::string_view s, std::string* bytes) {
  for (int shift = 0; shift < 64; shift += 8) {
    bytes->push_back(static_cast<char>((static_cast<std::uint64_t>(s.size()) >> shift) & 0xff));
  }
  bytes->append(s);
}

// Takes one length-prefixed string off the front of *rest.
std::string_view TakeString(std::string_view* rest) {
  if (rest->size() < 8) throw std::runtime_error("scenario bundle: ends inside a length");
  std::uint64_t size = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    size |= static_cast<std::uint64_t>(static_cast<unsigned char>((*rest)[i])) << (8 * i);
  }
  rest->remove_prefix(8);
  if (size > rest->size()) {
    throw std::runtime_error(fmt::format("scenario bundle: a length of {} with {} bytes left", size, rest->size()));
  }
  const std::string_view s = rest->substr(0, size);
  rest->remove_prefix(size);
  return s;
}

}  // namespace

std::string EncodeBundle(const std::map<std::string, std::string>& files) {
  std::string bytes(kMagic);
  for (const auto& [name, content] : files) {
    AppendString(name, &bytes);
    AppendString(content, &bytes);
  }
  if (bytes.size() > static_cast<std::size_t>(kMaxBundleSize)) {
    throw std::runtime_error(
        fmt::format("scenario: its files have {} bytes together, at most {} travel", bytes.size(), kMaxBundleSize));
  }
  return bytes;
}

std::map<std::string, std::string> DecodeBundle(std::string_view bytes) {
  if (bytes.substr(0, kMagic.size()) != kMagic) throw std::runtime_error("scenario bundle: unknown format");
  std::string_view rest = bytes.substr(kMagic.size());
  std::map<std::string, std::string> files;
  while (!rest.empty()) {
    const std::string name(TakeString(&rest));
    if (!files.empty() && name <= files.rbegin()->first) {
      throw std::runtime_error("scenario bundle: file names are not in ascending order");
    }
    files.emplace(name, TakeString(&rest));
  }
  return files;
}

}  // namespace knap
