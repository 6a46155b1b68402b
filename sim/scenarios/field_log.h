// Where the fields of a scenario file stand and what is wrong with them.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "sim/scenarios/config_tree.h"

namespace knap {

class FieldLog {
 public:
  FieldLog() = default;
  // Errors found so far; they concern the text alone.
  explicit FieldLog(std::vector<ConfigError> errors) : errors_(std::move(errors)) {}

  // The file gives the field at `path`; `text` is its value as written, empty for sections and lists.
  void Note(const std::string& path, const ConfigPosition& position, const std::string& text);

  // The field itself is wrong or missing: `position` says where to look.
  void Fail(const std::string& path, const ConfigPosition& position, const std::string& message);

  // The first of `paths`, right by itself, does not fit together with the others. The error stands where the file gives
  // it; a field left to its default has no place, then the others' places serve, then the section around. Says nothing
  // when one of the fields failed before: that error comes first.
  void Report(std::span<const std::string> paths, const std::string& message);
  void Report(const std::string& path, const std::string& message) { Report(std::span(&path, 1), message); }

  bool IsGiven(const std::string& path) const { return places_.count(path) != 0; }

  // A field failed at, above or below `path`.
  bool HasFailedNear(const std::string& path) const;

  const std::vector<ConfigError>& errors() const { return errors_; }

 private:
  struct Place {
    ConfigPosition position;
    std::string text;
  };

  ConfigPosition FindPosition(std::span<const std::string> paths) const;

  std::map<std::string, Place> places_;
  std::set<std::string> failed_;
  std::vector<ConfigError> errors_;
};

// "value 'x': " in front of what is allowed; empty for an empty text.
std::string QuoteValue(const std::string& text);

}  // namespace knap
