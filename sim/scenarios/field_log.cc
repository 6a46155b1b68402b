#include "sim/scenarios/field_log.h"

#include <fmt/format.h>

#include <algorithm>

namespace knap {
namespace {

// "a.b[0].c" → "a.b[0]" → "a.b" → "a" → "".
std::string CalcParentPath(const std::string& path) {
  const std::size_t end = path.find_last_of(".[");
  return end == std::string::npos ? std::string() : path.substr(0, end);
}

// Whether `inner` is `outer` or lies in it.
bool IsWithin(const std::string& inner, const std::string& outer) {
  return inner.compare(0, outer.size(), outer) == 0 &&
         (inner.size() == outer.size() || inner[outer.size()] == '.' || inner[outer.size()] == '[');
}

}  // namespace

std::string QuoteValue(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  if (text.empty()) return {};
  if (text.size() > kLongest) return fmt::format("value '{}…': ", text.substr(0, kLongest));
  return fmt::format("value '{}': ", text);
}

void FieldLog::Note(const std::string& path, const ConfigPosition& position, const std::string& text) {
  places_[path] = {position, text};
}

void FieldLog::Fail(const std::string& path, const ConfigPosition& position, const std::string& message) {
  failed_.insert(path);
  errors_.push_back({position, path, message});
}

void FieldLog::Report(std::span<const std::string> paths, const std::string& message) {
  if (std::any_of(paths.begin(), paths.end(), [this](const std::string& path) { return HasFailedNear(path); })) return;
  const std::string& field = paths.front();
  const auto own = places_.find(field);
  const std::string value = own == places_.end() ? std::string() : QuoteValue(own->second.text);
  errors_.push_back({FindPosition(paths), field, value + message});
}

ConfigPosition FieldLog::FindPosition(std::span<const std::string> paths) const {
  for (const std::string& path : paths) {
    if (const auto place = places_.find(path); place != places_.end()) return place->second.position;
  }
  for (std::string above = CalcParentPath(paths.front()); !above.empty(); above = CalcParentPath(above)) {
    if (const auto place = places_.find(above); place != places_.end()) return place->second.position;
  }
  return {};
}

bool FieldLog::HasFailedNear(const std::string& path) const {
  return std::any_of(failed_.begin(), failed_.end(),
                     [&](const std::string& f) { return IsWithin(f, path) || IsWithin(path, f); });
}

}  // namespace knap
