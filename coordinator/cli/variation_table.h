// The file of a variation that draws rows of a table.
#pragma once

#include <string>
#include <vector>

namespace knap {

// The columns of the CSV text that have the names of the keys, in their order; SI units, at least one row. Throws
// std::invalid_argument with one line that names the file, and the line and column of what is wrong.
std::vector<std::vector<double>> ReadVariationTable(const std::string& file, const std::string& text,
                                                    const std::vector<std::string>& keys);

}  // namespace knap
