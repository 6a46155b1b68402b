// Files that survive a crash: one owned descriptor with checked writes, and whole files replaced in one step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "coordinator/run_directory/append_file.h"

namespace knap {

// An open file. Every failure throws std::system_error whose text names the path. Not copyable.
class DurableFile final : public AppendFile {
 public:
  // flags and mode as for open(2); O_CLOEXEC is added.
  DurableFile(const std::filesystem::path& path, int flags, unsigned mode = 0644);
  DurableFile(DurableFile&& other) noexcept;
  DurableFile& operator=(DurableFile&& other) noexcept;
  ~DurableFile() override;

  const std::filesystem::path& path() const override { return path_; }
  std::string ReadAll() const override;
  void Write(std::string_view bytes) override;  // the kernel has them when it returns
  void Sync() override;                         // fdatasync: the disk has them
  void Truncate(std::uint64_t size) override;
  bool TryLock();            // flock, exclusive; false when another process holds it
  bool IsAtItsPath() const;  // no other file has taken its place since it was opened

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Replaces `path` by a file with this text: a temporary file in the same folder, fsync, rename, fsync of the folder. A
// reader, or a run after a crash, sees the old file or the new one, never a part. A failure leaves no temporary file.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

// The text of a file; throws std::system_error naming the path.
std::string ReadFile(const std::filesystem::path& path);

}  // namespace knap
