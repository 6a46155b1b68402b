// Comma-separated values as the files of a run have them [RFC 4180]: one record a line, quoted where the text needs it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace knap {

// One field. A line break within it comes out as a space, so that a record stays one line.
std::string MakeCsvField(std::string_view text);

// The fields of one line without its end; a quote that is never closed ends with the line.
std::vector<std::string> SplitCsvLine(std::string_view line);

// A file with a header. What stands behind the last line's end, the half record that a crash leaves, does not count.
class CsvTable {
 public:
  explicit CsvTable(std::string_view text);

  std::size_t size() const { return rows_.size(); }
  bool Has(std::string_view column) const;
  // The field, empty where the row is too short or has no such column.
  const std::string& Get(std::size_t row, std::string_view column) const;
  // The same as a number; NaN where it is none.
  double GetNumber(std::size_t row, std::string_view column) const;

 private:
  std::size_t FindColumn(std::string_view column) const;  // the number of columns where there is none

  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace knap
