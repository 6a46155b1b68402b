#include "coordinator/run_directory/growing_file.h"

#include <cerrno>
#include <fstream>
#include <system_error>

namespace knap {

GrowingFile::Piece GrowingFile::Take() {
  std::ifstream file(path_, std::ios::binary | std::ios::ate);
  if (!file) throw std::system_error(errno, std::generic_category(), path_.string());
  const auto size = static_cast<std::uint64_t>(file.tellg());
  Piece piece;
  if (size < taken_) {
    piece.begins_anew = true;
    taken_ = 0;
  }
  piece.lines.resize(size - taken_);
  file.seekg(static_cast<std::streamoff>(taken_));
  file.read(piece.lines.data(), static_cast<std::streamsize>(piece.lines.size()));
  if (file.bad()) throw std::system_error(errno, std::generic_category(), path_.string());
  // It may have been cut while it was read.
  piece.lines.resize(static_cast<std::size_t>(file.gcount()));
  const std::size_t end = piece.lines.rfind('\n');
  piece.lines.resize(end == std::string::npos ? 0 : end + 1);
  taken_ += piece.lines.size();
  return piece;
}

}  // namespace knap
