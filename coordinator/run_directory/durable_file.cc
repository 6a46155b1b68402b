#include "coordinator/run_directory/durable_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace knap {
namespace {

[[noreturn]] void Fail(const char* what, const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), std::string(what) + " " + path.string());
}

}  // namespace

DurableFile::DurableFile(const std::filesystem::path& path, int flags, unsigned mode) : path_(path) {
  do {
    descriptor_ = open(path.c_str(), flags | O_CLOEXEC, static_cast<mode_t>(mode));
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) Fail("cannot open", path_);
}

DurableFile::DurableFile(DurableFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

DurableFile& DurableFile::operator=(DurableFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

DurableFile::~DurableFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string DurableFile::ReadAll() const {
  if (lseek(descriptor_, 0, SEEK_SET) < 0) Fail("cannot read", path_);
  std::string text;
  std::array<char, 65536> buffer;
  while (true) {
    const ssize_t count = read(descriptor_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) Fail("cannot read", path_);
    if (count == 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

void DurableFile::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) Fail("cannot write", path_);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

void DurableFile::Sync() {
  if (fdatasync(descriptor_) != 0) Fail("cannot sync", path_);
}

void DurableFile::Truncate(std::uint64_t size) {
  const auto offset = static_cast<off_t>(size);
  if (ftruncate(descriptor_, offset) != 0 || lseek(descriptor_, offset, SEEK_SET) < 0) Fail("cannot truncate", path_);
}

bool DurableFile::TryLock() {
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == EWOULDBLOCK) return false;
  Fail("cannot lock", path_);
}

bool DurableFile::IsAtItsPath() const {
  struct stat opened {
  }, named{};
  if (fstat(descriptor_, &opened) != 0) Fail("cannot stat", path_);
  return stat(path_.c_str(), &named) == 0 && opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

void WriteFileAtomically(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  try {
    DurableFile file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    file.Write(text);
    file.Sync();
    if (rename(temporary.c_str(), path.c_str()) != 0) Fail("cannot rename to", path);
  } catch (...) {
    unlink(temporary.c_str());
    throw;
  }
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  DurableFile(folder, O_RDONLY | O_DIRECTORY).Sync();
}

std::string ReadFile(const std::filesystem::path& path) { return DurableFile(path, O_RDONLY).ReadAll(); }

}  // namespace knap
