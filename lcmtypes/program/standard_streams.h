// Standard input, output and error as every program of ours treats them: whoever started it may have closed them,
// filled the disk behind them, or gone away.
//
// What a program was asked for goes to stdout, and the program has failed when it cannot get there. Everything else
// goes to stderr, and a line that cannot get there is dropped: no line is worth the work that it tells of.
#pragma once

#include <string_view>
#include <system_error>

namespace knap {

// To be called first in main, before anything opens a file: a file that got the number of a closed stream would be
// written into by everybody who prints. What is closed becomes /dev/null, opened so that using it still fails.
// From now on a write to a pipe without reader, or beyond the limit of a file's size, is an error and no signal.
void SecureStandardStreams();

// Writes all of `text` to stdout at once; std::system_error, whose text names stdout, when that cannot be done.
void WriteOutput(std::string_view text);

// Writes `text` to stderr, or as much of it as can be written, and returns what stood in the way.
std::error_code WriteMessage(std::string_view text);

}  // namespace knap
