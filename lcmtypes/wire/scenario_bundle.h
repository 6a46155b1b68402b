// The scenario bundle: all files that describe a scenario as one canonical string of bytes, whose hash is its name.
//
// Bytes: "knap-scenario-1\n", then for every file in ascending byte order of its name: unsigned 64-bit little-endian
// length of the name, name, length of the content, content. The scenario's content id is SHA-256 of all these bytes.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "lcmtypes/wire/content_id.h"

namespace knap {

// Throws std::runtime_error when the bundle exceeds kMaxBundleSize.
std::string EncodeBundle(const std::map<std::string, std::string>& files);

// Throws std::runtime_error when the bytes are not what EncodeBundle makes.
std::map<std::string, std::string> DecodeBundle(std::string_view bytes);

inline ContentId CalcScenarioId(std::string_view bundle) { return CalcSha256(bundle); }

}  // namespace knap
