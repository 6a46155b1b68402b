// Text that comes from outside the program: from a packet, the operating system, the command line or another program's
// log. It may hold anything; what we print, send or write into a JSON file must be valid UTF-8 without control
// characters, or a terminal obeys it and a JSON library refuses it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace knap {

// The text as valid UTF-8 on one line: each byte that belongs to no character becomes '?', each character that acts on
// a terminal or on a line (C0 and C1 controls, DEL, line and paragraph separators, marks of writing direction) becomes
// a space. Cut to max_bytes at a whole character; never longer than the text was. Cleaning twice is cleaning once.
std::string CleanText(std::string_view text, std::size_t max_bytes = std::string_view::npos);

// The same for a text of several lines: its line ends stay.
std::string CleanLines(std::string_view text);

// This machine's name, clean.
std::string FindHostName();

}  // namespace knap
