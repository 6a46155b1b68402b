// A library to be preloaded (LD_PRELOAD): a disk, a pipe or a terminal that fails in a program which knows nothing of
// it. It works where nobody may mount a small or a read-only disk. In each process for itself:
//
//   KNAP_FULL=TARGET and KNAP_FULL_FROM=N: from the N-th write to TARGET on, counted from 1, every one fails with
//   ENOSPC.
//     The first failure makes the file KNAP_FULL_NOTE, which tells that there were N. TARGET is 1 or 2, a descriptor,
//     or a folder: all files beneath it.
//   KNAP_READ_ONLY=FOLDER: nothing beneath it can be made, opened for writing, renamed or removed: EROFS.
//   KNAP_NO_LINKS=1: the disk knows no symbolic links, EPERM.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

template <typename Function>
Function FindNext(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

bool IsBeneath(std::string_view path, const char* folder) {
  if (folder == nullptr) return false;
  const std::string_view prefix = folder;
  return path.substr(0, prefix.size()) == prefix && (path.size() == prefix.size() || path[prefix.size()] == '/');
}

std::string FindWorkingFolder() {
  std::array<char, 4096> folder{};
  return getcwd(folder.data(), folder.size()) == nullptr ? "" : folder.data();
}

bool IsReadOnly(const char* path) {
  const std::string whole = path[0] == '/' ? path : FindWorkingFolder() + "/" + path;
  if (!IsBeneath(whole, std::getenv("KNAP_READ_ONLY"))) return false;
  errno = EROFS;
  return true;
}

bool IsTarget(int descriptor) {
  const char* target = std::getenv("KNAP_FULL");
  if (target == nullptr) return false;
  if (target[0] != '/') return descriptor == std::atoi(target);
  std::array<char, 4096> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return readlink(link.c_str(), path.data(), path.size() - 1) > 0 && IsBeneath(path.data(), target);
}

int OpenChecked(int (*next)(const char*, int, ...), const char* path, int flags, mode_t mode) {
  if ((flags & (O_WRONLY | O_RDWR | O_CREAT)) != 0 && IsReadOnly(path)) return -1;
  return next(path, flags, mode);
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, size_t size) {
  static const auto next = FindNext<ssize_t (*)(int, const void*, size_t)>("write");
  static std::atomic<int> writes{0};
  if (IsTarget(descriptor)) {
    const int first = std::atoi(std::getenv("KNAP_FULL_FROM"));
    const int number = ++writes;
    if (number == first) close(creat(std::getenv("KNAP_FULL_NOTE"), 0644));
    if (number >= first) {
      errno = ENOSPC;
      return -1;
    }
  }
  return next(descriptor, bytes, size);
}

int open(const char* path, int flags, ...) {
  static const auto next = FindNext<int (*)(const char*, int, ...)>("open");
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return OpenChecked(next, path, flags, mode);
}

int mkdir(const char* path, mode_t mode) {
  static const auto next = FindNext<int (*)(const char*, mode_t)>("mkdir");
  return IsReadOnly(path) ? -1 : next(path, mode);
}

int rename(const char* from, const char* to) {
  static const auto next = FindNext<int (*)(const char*, const char*)>("rename");
  return IsReadOnly(from) || IsReadOnly(to) ? -1 : next(from, to);
}

int remove(const char* path) {
  static const auto next = FindNext<int (*)(const char*)>("remove");
  return IsReadOnly(path) ? -1 : next(path);
}

int symlink(const char* target, const char* path) {
  static const auto next = FindNext<int (*)(const char*, const char*)>("symlink");
  if (std::getenv("KNAP_NO_LINKS") == nullptr) return next(target, path);
  errno = EPERM;
  return -1;
}

int unlink(const char* path) {
  static const auto next = FindNext<int (*)(const char*)>("unlink");
  return IsReadOnly(path) ? -1 : next(path);
}
}
