// Numbers in a CSV file that a scenario names: a header with the columns' names, then rows.
#pragma once

#include <string>
#include <vector>

namespace knap {

// Of each row the columns that have these names, in their order; SI units, at least one row. Throws
// std::invalid_argument with one line that names the file, and the line and column of what is wrong.
std::vector<std::vector<double>> ReadNumberTable(const std::string& file, const std::string& text,
                                                 const std::vector<std::string>& columns);

}  // namespace knap
