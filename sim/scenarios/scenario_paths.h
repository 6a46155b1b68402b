// Which file names a scenario may carry.
#pragma once

#include <string_view>

namespace knap {

// The scenario's own entry among its files.
inline constexpr char kScenarioFileName[] = "scenario.yaml";

// A relative path of non-empty components joined by '/', none of them "." or "..", without control characters,
// backslashes or colons, at most 200 bytes long, and not kScenarioFileName: it names the same file on every system and
// cannot leave the folder it is joined to.
bool IsScenarioFilePath(std::string_view path);

}  // namespace knap
