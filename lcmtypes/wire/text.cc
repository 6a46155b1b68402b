#include "lcmtypes/wire/text.h"

#include <unistd.h>

#include <array>

namespace knap {
namespace {

// The character at the front of a text that is not empty.
struct Character {
  std::size_t size = 1;
  char32_t code = 0;
  bool valid = false;
};

Character TakeFirst(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (lead < 0x80) return {1, lead, true};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < size) return {};
  char32_t code = lead & (0x7fU >> size);
  for (std::size_t i = 1; i < size; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xc0) != 0x80) return {};
    code = (code << 6) | (next & 0x3fU);
  }
  const bool overlong = (size == 3 && code < 0x800) || (size == 4 && code < 0x10000);
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (overlong || surrogate || code > 0x10ffff) return {};
  return {size, code, true};
}

bool IsControl(char32_t code) {
  const bool control = code < 0x20 || (code >= 0x7f && code <= 0x9f);
  const bool separator = code == 0x2028 || code == 0x2029;
  const bool direction = code == 0x200e || code == 0x200f || code == 0x061c || (code >= 0x202a && code <= 0x202e) ||
                         (code >= 0x2066 && code <= 0x2069);
  return control || separator || direction;
}

}  // namespace

std::string CleanText(std::string_view text, std::size_t max_bytes) {
  std::string clean;
  while (!text.empty()) {
    const Character character = TakeFirst(text);
    std::string_view written = text.substr(0, character.size);
    if (!character.valid) {
      written = "?";
    } else if (IsControl(character.code)) {
      written = " ";
    }
    if (written.size() > max_bytes - clean.size()) break;
    clean += written;
    text.remove_prefix(character.size);
  }
  return clean;
}

std::string CleanLines(std::string_view text) {
  std::string clean;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    clean += CleanText(text.substr(0, end)) + "\n";
    text.remove_prefix(end + 1);
  }
  return clean + CleanText(text);
}

std::string FindHostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return CleanText(name.data());
}

}  // namespace knap
