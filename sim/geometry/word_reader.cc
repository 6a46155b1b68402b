#include "sim/geometry/word_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace knap {
namespace {

constexpr double kLargestCoordinate = 1e9;
constexpr std::string_view kBlank = " \t\v\f";

}  // namespace

std::string_view SkipByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.substr(0, kMark.size()) == kMark) text.remove_prefix(kMark.size());
  return text;
}

std::string ToLowerCase(std::string_view word) {
  std::string lower(word);
  for (char& c : lower) {
    if ('A' <= c && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

WordReader::WordReader(const std::string& name, std::string_view text, bool joins_lines, char comment)
    : name_(name), text_(SkipByteOrderMark(text)), joins_lines_(joins_lines), comment_(comment) {}

std::string_view WordReader::TakeLine() {
  const std::size_t end = std::min(text_.find_first_of("\r\n", next_line_), text_.size());
  std::string_view line = text_.substr(next_line_, end - next_line_);
  next_line_ = end + (text_.substr(end, 2) == "\r\n" ? 2 : 1);
  ++line_number_;
  at_ = 0;
  if (comment_ != 0) line = line.substr(0, line.find(comment_));
  // A comment ends with its line, whatever stands there: a path with a `\` at its end must not hide the next line.
  goes_on_ = joins_lines_ && !line.empty() && line.back() == '\\';
  if (goes_on_) line.remove_suffix(1);
  return line;
}

bool WordReader::NextLine() {
  while (goes_on_ && next_line_ < text_.size()) TakeLine();  // the rest of what nobody wanted to read
  while (next_line_ < text_.size()) {
    line_ = TakeLine();
    if (line_.find_first_not_of(kBlank) != std::string_view::npos) return true;
  }
  return false;
}

std::string_view WordReader::NextWord() {
  word_begin_ = std::min(line_.find_first_not_of(kBlank, at_), line_.size());
  while (word_begin_ == line_.size() && goes_on_ && next_line_ < text_.size()) {
    line_ = TakeLine();
    word_begin_ = std::min(line_.find_first_not_of(kBlank), line_.size());
  }
  at_ = std::min(line_.find_first_of(kBlank, word_begin_), line_.size());
  return line_.substr(word_begin_, at_ - word_begin_);
}

std::string_view WordReader::NextWordOfAnyLine() {
  std::string_view word = NextWord();
  while (word.empty() && NextLine()) word = NextWord();
  return word;
}

double WordReader::ParseCoordinate(std::string_view word) const {
  if (word.empty()) Fail("a number is missing");
  const std::string_view digits = word.substr(word.front() == '+' ? 1 : 0);
  double value = 0.0;
  auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) {
    value = std::strtod(std::string(digits).c_str(), nullptr);  // tells too small from too large
    error = std::errc();
  }
  if (error != std::errc() || end != digits.data() + digits.size() || !(std::abs(value) <= kLargestCoordinate)) {
    Fail(fmt::format("'{}' is not a number within +-1e9", Shorten(word)));
  }
  return value;
}

void WordReader::Fail(const std::string& what) const {
  throw std::runtime_error(fmt::format("{}:{}:{}: {}", name_, std::max(line_number_, 1), word_begin_ + 1, what));
}

std::string WordReader::Shorten(std::string_view word) {
  std::string shown(word.substr(0, 40));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shown;
}

}  // namespace knap
