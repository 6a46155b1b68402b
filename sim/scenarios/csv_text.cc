#include "sim/scenarios/csv_text.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace knap {

std::string MakeCsvField(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

std::vector<std::string> SplitCsvLine(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

CsvTable::CsvTable(std::string_view text) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) break;
    std::vector<std::string> fields = SplitCsvLine(text.substr(begin, end - begin));
    if (names_.empty()) {
      names_ = std::move(fields);
    } else {
      rows_.push_back(std::move(fields));
    }
    begin = end + 1;
  }
}

std::size_t CsvTable::FindColumn(std::string_view column) const {
  return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), column) - names_.begin());
}

bool CsvTable::Has(std::string_view column) const { return FindColumn(column) < names_.size(); }

const std::string& CsvTable::Get(std::size_t row, std::string_view column) const {
  static const std::string kEmpty;
  const std::size_t k = FindColumn(column);
  return k < names_.size() && k < rows_[row].size() ? rows_[row][k] : kEmpty;
}

double CsvTable::GetNumber(std::size_t row, std::string_view column) const {
  const std::string& field = Get(row, column);
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  return field.empty() || *end != '\0' ? std::numeric_limits<double>::quiet_NaN() : value;
}

}  // namespace knap
