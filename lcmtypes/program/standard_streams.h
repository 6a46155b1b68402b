// Standard input, output and error as every program of ours treats them: whoever started it may have closed them,
// filled the disk behind them, or gone away.
//
// What a program was asked for goes to stdout, and the program has failed when it cannot get there. Everything else
// goes to stderr, and a line that cannot get there is dropped: no line is worth the work that it tells of.
//
// Much of what is printed quotes others: command lines, files, the operating system, other machines. Whatever they
// hold, it comes out as valid UTF-8, and without control characters but our own line ends (text.h).
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

// The message "program: what", on one line whatever `what` quotes.
std::error_code WriteComplaint(std::string_view program, std::string_view what);

// The same two for what moves the cursor of a terminal or colours it: byte by byte as it is. What it quotes is clean.
void DrawOutput(std::string_view text);
std::error_code DrawMessage(std::string_view text);

}  // namespace knap
