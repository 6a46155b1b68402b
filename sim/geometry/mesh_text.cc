#include "sim/geometry/mesh_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace knap {
namespace {

constexpr double kLargestCoordinate = 1e9;

// Splits a text into lines and words, and knows where it is.
class WordReader {
 public:
  WordReader(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  // Moves to the next line that has words. False at the end of the text.
  bool NextLine() {
    while (next_line_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', next_line_), text_.size());
      line_ = text_.substr(next_line_, end - next_line_);
      line_ = line_.substr(0, line_.find('#'));
      next_line_ = end + 1;
      ++line_number_;
      at_ = 0;
      if (line_.find_first_not_of(kBlank) != std::string_view::npos) return true;
    }
    return false;
  }

  // The next word of this line, "" at its end.
  std::string_view NextWord() {
    word_begin_ = std::min(line_.find_first_not_of(kBlank, at_), line_.size());
    at_ = std::min(line_.find_first_of(kBlank, word_begin_), line_.size());
    return line_.substr(word_begin_, at_ - word_begin_);
  }

  // The next word as a coordinate.
  double NextCoordinate() {
    std::string_view word = NextWord();
    if (word.empty()) Fail("a number is missing");
    if (word.front() == '+') word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= kLargestCoordinate)) {
      Fail(fmt::format("'{}' is not a number within +-1e9", Shorten(word)));
    }
    return value;
  }

  // Requires the rest of the line to begin with these words.
  void Expect(std::initializer_list<std::string_view> words) {
    for (const std::string_view expected : words) {
      const std::string_view word = NextWord();
      if (word != expected) Fail(fmt::format("expected '{}', found '{}'", expected, Shorten(word)));
    }
  }

  void ExpectLine(std::initializer_list<std::string_view> words) {
    if (!NextLine()) Fail(fmt::format("the file ends where '{}' is expected", *words.begin()));
    Expect(words);
  }

  void ExpectEndOfLine() {
    const std::string_view word = NextWord();
    if (!word.empty()) Fail(fmt::format("'{}' is one word too many", Shorten(word)));
  }

  // Names the place of the last word.
  [[noreturn]] void Fail(const std::string& what) const {
    throw std::runtime_error(fmt::format("{}:{}:{}: {}", name_, std::max(line_number_, 1), word_begin_ + 1, what));
  }

  // Foreign text in a message: short, and without control bytes.
  static std::string Shorten(std::string_view word) {
    std::string shown(word.substr(0, 40));
    for (char& c : shown) {
      if (c < ' ' || c > '~') c = '?';
    }
    return shown;
  }

 private:
  static constexpr std::string_view kBlank = " \t\r\v\f";
  const std::string& name_;
  const std::string_view text_;
  std::string_view line_;
  size_t next_line_ = 0;
  size_t at_ = 0;
  size_t word_begin_ = 0;
  int line_number_ = 0;
};

// One corner of a face, "7", "7/1", "7//2", "7/1/2" or counted back from the last vertex, "-1".
int ParseCorner(const WordReader& reader, std::string_view word, int num_vertices) {
  const std::string_view digits = word.substr(0, word.find('/'));
  long long number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    reader.Fail(fmt::format("'{}' is not a vertex number", WordReader::Shorten(word)));
  }
  const long long index = number < 0 ? num_vertices + number : number - 1;
  if (index < 0 || index >= num_vertices) {
    reader.Fail(
        fmt::format("vertex {} does not exist yet or at all: the file has {} up to here", number, num_vertices));
  }
  return static_cast<int>(index);
}

// Keywords that say nothing about the surface's shape.
constexpr std::array<std::string_view, 11> kIgnored = {"vt", "vn", "vp",     "g",      "o",     "s",
                                                       "l",  "p",  "mtllib", "usemtl", "usemap"};

}  // namespace

ObjSurface ParseObjSurface(const std::string& name, std::string_view text) {
  ObjSurface surface;
  WordReader reader(name, text);
  while (reader.NextLine()) {
    const std::string_view keyword = reader.NextWord();
    if (keyword == "v") {
      Eigen::Vector3d v;
      for (int k = 0; k < 3; ++k) v[k] = reader.NextCoordinate();
      surface.vertices.push_back(v);  // what may follow, a weight or a colour, is of no interest
    } else if (keyword == "f") {
      std::vector<int> polygon;
      const int num_vertices = static_cast<int>(surface.vertices.size());
      for (std::string_view word = reader.NextWord(); !word.empty(); word = reader.NextWord()) {
        polygon.push_back(ParseCorner(reader, word, num_vertices));
      }
      if (polygon.size() < 3) reader.Fail("a face needs at least three vertices");
      surface.polygons.push_back(std::move(polygon));
    } else if (std::find(kIgnored.begin(), kIgnored.end(), keyword) == kIgnored.end()) {
      reader.Fail(fmt::format("unknown OBJ keyword '{}'", WordReader::Shorten(keyword)));
    }
  }
  return surface;
}

void CheckTextStl(const std::string& name, std::string_view text) {
  WordReader reader(name, text);
  reader.ExpectLine({"solid"});
  while (true) {
    if (!reader.NextLine()) reader.Fail("the file ends without 'endsolid'");
    const std::string_view keyword = reader.NextWord();
    if (keyword == "endsolid") break;
    if (keyword != "facet") {
      reader.Fail(fmt::format("expected 'facet' or 'endsolid', found '{}'", WordReader::Shorten(keyword)));
    }
    reader.Expect({"normal"});
    for (int k = 0; k < 3; ++k) reader.NextCoordinate();
    reader.ExpectEndOfLine();
    reader.ExpectLine({"outer", "loop"});
    for (int corner = 0; corner < 3; ++corner) {
      reader.ExpectLine({"vertex"});
      for (int k = 0; k < 3; ++k) reader.NextCoordinate();
      reader.ExpectEndOfLine();
    }
    reader.ExpectLine({"endloop"});
    reader.ExpectLine({"endfacet"});
  }
  if (reader.NextLine()) reader.Fail("text after 'endsolid': only one solid a file");
}

}  // namespace knap
