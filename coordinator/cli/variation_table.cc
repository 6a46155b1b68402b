#include "coordinator/cli/variation_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "coordinator/run_directory/csv_text.h"
#include "lcmtypes/wire/text.h"

namespace knap {

std::vector<std::vector<double>> ReadVariationTable(const std::string& file, const std::string& text,
                                                    const std::vector<std::string>& keys) {
  const auto refuse = [&file](std::size_t line, const std::string& message) {
    throw std::invalid_argument(fmt::format("{}:{}: {}", file, line, message));
  };
  std::string lines = text;  // ends of lines as CsvTable has them, the last one included
  lines.erase(std::remove(lines.begin(), lines.end(), '\r'), lines.end());
  if (!lines.ends_with('\n')) lines += '\n';
  const CsvTable table(lines);
  for (const std::string& key : keys) {
    if (!table.Has(key)) refuse(1, fmt::format("no column '{}'", key));
  }
  if (table.size() == 0) refuse(1, "no row follows the names of the columns");
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& key : keys) {
      row.push_back(table.GetNumber(i, key));
      if (std::isfinite(row.back())) continue;
      refuse(i + 2, fmt::format("column '{}': value '{}': expected a number", key, CleanText(table.Get(i, key))));
    }
  }
  return rows;
}

}  // namespace knap
