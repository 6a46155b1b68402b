// A growing file as the journal sees it: the disk's is DurableFile; the fault simulator has one in memory that loses
// what was not synced.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace knap {

// Every failure throws std::system_error whose text names the path.
class AppendFile {
 public:
  virtual ~AppendFile() = default;

  virtual const std::filesystem::path& path() const = 0;
  virtual std::string ReadAll() const = 0;         // from the beginning; leaves the write position at the end
  virtual void Write(std::string_view bytes) = 0;  // all of them, at the end; a crash may still lose any part
  virtual void Sync() = 0;                         // what was written survives a crash from now on
  virtual void Truncate(std::uint64_t size) = 0;   // and moves the write position there
};

}  // namespace knap
