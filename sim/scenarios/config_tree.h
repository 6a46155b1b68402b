// A YAML document as a plain tree in which every node knows where it stands, and errors that say so.
//
// Scenario files use maps, lists and scalars. What YAML offers beyond that is refused rather than guessed at: duplicate
// keys, anchors, aliases, tags, several documents, keys that are not scalars. Scalars stay text: whether `010` or `yes`
// is a number is for the field that holds it to say.
#pragma once

#include <compare>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace knap {

// A place in a file, counted from 1, or on the command line.
struct ConfigPosition {
  int override_index = -1;  // which override the text comes from; -1: a file
  int line = 1;
  int column = 1;
  int file = -1;  // which of the included files (include_files.h); -1: the scenario's own

  auto operator<=>(const ConfigPosition& other) const {
    return std::tie(override_index, file, line, column) <=>
           std::tie(other.override_index, other.file, other.line, other.column);
  }
  bool operator==(const ConfigPosition&) const = default;
};

struct ConfigError {
  ConfigPosition position;
  std::string field;    // "bodies.pea.shapes[0].radius"; empty: the file as a whole
  std::string message;  // "value '10': expected a length with its unit, such as '10 mm'"
};

struct ConfigEntry;

struct ConfigNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  ConfigPosition position;
  std::string text;                  // of a scalar
  std::vector<ConfigNode> items;     // of a list
  std::vector<ConfigEntry> entries;  // of a map, in the order of the file, keys unique

  // Null when this is no map or has no such key.
  const ConfigNode* Find(std::string_view key) const;
  ConfigNode* Find(std::string_view key);
};

struct ConfigEntry {
  std::string key;
  ConfigPosition position;
  ConfigNode value;
};

// How paths name element i of a list: ".pea" when it is a map with a scalar `name`, else "[i]".
std::string CalcElementStep(const ConfigNode& list, std::size_t i);

// Parses one YAML document; an empty text gives a null node. Appends what is wrong to `errors`; a text that is no YAML
// gives a null node and one error.
ConfigNode ParseConfigTree(const std::string& text, std::vector<ConfigError>& errors);

// Applies overrides "a.b[0].c=value" in their order. A path names list elements by their `name` or by [index]; missing
// keys are added, missing elements are errors. The value is YAML. Appends what is wrong to `errors`.
void ApplyOverrides(ConfigNode& root, std::span<const std::string> overrides, std::vector<ConfigError>& errors);

// One line an error, sorted by position, files first: "file:line:column: field: message" or
// "command line: a.b=c: field: message". `overrides` are those that were applied, `included` the names of the files
// that were included.
std::string FormatErrors(std::vector<ConfigError> errors, const std::string& file_name,
                         std::span<const std::string> overrides = {}, std::span<const std::string> included = {});

}  // namespace knap
