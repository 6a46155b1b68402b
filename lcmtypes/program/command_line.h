// How a program ends whose command line could not be carried out, or asked for help alone.
#pragma once

#include <CLI/CLI.hpp>

namespace knap {

// Writes the help, the version or what is wrong with the command line, and returns the exit code: 0 done, 1 when stdout
// does not take it, 2 bad usage.
int EndParsing(const CLI::App& app, const CLI::ParseError& end);

}  // namespace knap
