// The reference of the scenario format, derived from the same description that reads the files.
#pragma once

#include <string>

namespace knap {

// A page of Markdown: what the format is, then a heading and a table a section of the file, with every key, its type or
// unit, what is allowed, its default and its meaning. Alternatives are headed by their `type`.
std::string DescribeSceneFormat();

}  // namespace knap
