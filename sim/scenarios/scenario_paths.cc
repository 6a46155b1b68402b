#include "sim/scenarios/scenario_paths.h"

#include <algorithm>

namespace knap {

bool IsScenarioFilePath(std::string_view path) {
  constexpr std::size_t kLongest = 200;
  if (path.empty() || path.size() > kLongest || path == kScenarioFileName) return false;
  const bool plain = std::all_of(path.begin(), path.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f && c != '\\' && c != ':';
  });
  if (!plain) return false;
  std::size_t begin = 0;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view component = path.substr(begin, end - begin);
    if (component.empty() || component == "." || component == "..") return false;
    begin = end + 1;
  }
  return true;
}

}  // namespace knap
