// What a run leaves behind, as tests read it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace knap {

// The columns of a CSV file without quoted fields.
std::map<std::string, std::vector<std::string>> ReadCsv(const std::filesystem::path& path);

// Everything reproducible of two finished runs: theta, the test's figures, and every evaluation, to the last bit.
void ExpectSameRun(const std::filesystem::path& run, const std::filesystem::path& reference);

}  // namespace knap
