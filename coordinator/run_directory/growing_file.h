// A file of lines that somebody else appends to, read piece by piece while it grows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace knap {

class GrowingFile {
 public:
  struct Piece {
    std::string lines;         // whole ones, each with its end; empty where there are no new ones
    bool begins_anew = false;  // the file is shorter than what was read of it: these are its first lines
  };

  explicit GrowingFile(std::filesystem::path path) : path_(std::move(path)) {}

  // What was written since the last call. A line without its end waits for the rest of it. Throws std::system_error
  // naming the path when it cannot be read.
  Piece Take();

  // The next piece begins with the file's first line.
  void Rewind() { taken_ = 0; }

 private:
  std::filesystem::path path_;
  std::uint64_t taken_ = 0;  // bytes
};

}  // namespace knap
