// Reads a scenario file strictly: every key known, given once and in its place, every value of its type, unit and
// range, every name defined, everything consistent. All that is wrong is reported at once.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/scenarios/config_tree.h"
#include "sim/scenarios/field_log.h"
#include "sim/scenarios/include_files.h"
#include "sim/scenarios/scene.h"

namespace knap {

// A file that the scenario names.
struct FileReference {
  std::string field;  // "design.mesh"
  std::string path;   // relative, with '/', without "." or ".."
};

struct ParseResult {
  Scene scene;                       // to be used only when ok()
  std::vector<FileReference> files;  // in the order of the fields; their existence is for the caller to check
  std::string file_name;
  std::vector<std::string> overrides;
  std::vector<std::string> included;  // names of the files, for messages
  FieldLog log;

  bool ok() const { return log.errors().empty(); }

  // All errors, one a line: "file:line:column: field: value 'x': what is allowed", those of overrides last as
  // "command line: a.b=c: …". Empty when ok().
  std::string FormatErrors() const { return knap::FormatErrors(log.errors(), file_name, overrides, included); }
};

// `overrides` "a.b=c" change the file's content before it is understood, and what it includes; `file_name` is for
// messages alone. Without `read` nothing can be included. Never throws on bad input.
ParseResult ParseScene(const std::string& text, const std::string& file_name,
                       std::span<const std::string> overrides = {}, const IncludeReader& read = {});

}  // namespace knap
