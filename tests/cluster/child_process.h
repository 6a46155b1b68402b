// A program run by a test, as a user would run it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace knap {

class ChildProcess {
 public:
  // Starts `program` in `folder`, with stdout and stderr into folder/NAME.out and folder/NAME.err.
  ChildProcess(const std::string& program, std::vector<std::string> arguments, const std::filesystem::path& folder,
               const std::string& name);
  ~ChildProcess();  // kills it if it still runs
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool HasEnded();  // does not wait
  int Wait();       // its exit code, or minus the signal that ended it
  void Signal(int signal) const;
  std::vector<pid_t> ListChildren() const;  // processes that it started and that run

  std::string ReadOut() const;
  std::string ReadErr() const;

 private:
  std::filesystem::path out_, err_;
  pid_t pid_ = 0;
  bool ended_ = false;
  int code_ = 0;
};

struct Ended {
  int code;
  std::string out, err;
};

// Waits for the program's end.
Ended RunToEnd(const std::string& program, std::vector<std::string> arguments, const std::filesystem::path& folder,
               const std::string& name);

// The text of a file; empty when there is none.
std::string ReadText(const std::filesystem::path& path);

}  // namespace knap
