// Splits a text file into lines and words, and knows where it is: what the readers of meshes have in common.
#pragma once

#include <string>
#include <string_view>

namespace knap {

// The text without a byte order mark.
std::string_view SkipByteOrderMark(std::string_view text);

// "FACET" → "facet", ASCII alone.
std::string ToLowerCase(std::string_view word);

class WordReader {
 public:
  // Both must outlive the reader. `joins_lines`: a `\` at the end of a line joins it with the next. `comment` begins
  // what is passed over up to the end of its line; 0 for a format without comments.
  WordReader(const std::string& name, std::string_view text, bool joins_lines, char comment);

  // Moves to the next line that has words. False at the end of the text.
  bool NextLine();

  // The next word of this line, "" at its end.
  std::string_view NextWord();

  // The next word of this line or a later one, "" at the end of the text.
  std::string_view NextWordOfAnyLine();

  // The word that was read last, as a coordinate: finite and within ±1e9. A number below the smallest double is zero.
  double ParseCoordinate(std::string_view word) const;

  // Throws std::runtime_error "name:line:column: what", naming the place of the last word.
  [[noreturn]] void Fail(const std::string& what) const;

  int line_number() const { return line_number_; }

  // Foreign text in a message: short, and without control bytes.
  static std::string Shorten(std::string_view word);

 private:
  std::string_view TakeLine();

  const std::string& name_;
  const std::string_view text_;
  const bool joins_lines_;
  const char comment_;
  std::string_view line_;
  std::size_t next_line_ = 0;
  std::size_t at_ = 0;
  std::size_t word_begin_ = 0;
  bool goes_on_ = false;  // the line ended with a `\`
  int line_number_ = 0;
};

}  // namespace knap
