#include "sim/scenarios/number_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/scenarios/csv_text.h"

namespace knap {

std::vector<std::vector<double>> ReadNumberTable(const std::string& file, const std::string& text,
                                                 const std::vector<std::string>& columns) {
  const auto refuse = [&file](std::size_t line, const std::string& message) {
    throw std::invalid_argument(fmt::format("{}:{}: {}", file, line, message));
  };
  std::string lines = text;  // ends of lines as CsvTable has them, the last one included
  lines.erase(std::remove(lines.begin(), lines.end(), '\r'), lines.end());
  if (!lines.ends_with('\n')) lines += '\n';
  const CsvTable table(lines);
  for (const std::string& column : columns) {
    if (!table.Has(column)) refuse(1, fmt::format("no column '{}'", column));
  }
  if (table.size() == 0) refuse(1, "no row follows the names of the columns");
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& column : columns) {
      row.push_back(table.GetNumber(i, column));
      if (std::isfinite(row.back())) continue;
      refuse(i + 2, fmt::format("column '{}': value '{}': expected a number", column, table.Get(i, column)));
    }
  }
  return rows;
}

}  // namespace knap
