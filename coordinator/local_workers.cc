#include "coordinator/local_workers.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr std::int64_t kEarlyUs = 1'000'000;  // an end by itself before this age counts as early
constexpr int kMaxEarlyEnds = 5;
constexpr std::int64_t kSteadyUs = 60'000'000;    // a life that says nothing about the next one
constexpr std::int64_t kRestartDelayUs = 20'000;  // doubles with every end by itself in a row
constexpr std::int64_t kLongestDelayUs = 10'000'000;
constexpr int kMostDoublings = 9;
constexpr auto kStopPoll = std::chrono::milliseconds(5);

bool IsFaultSignal(int signal) {
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGFPE || signal == SIGILL || signal == SIGABRT ||
         signal == SIGSYS || signal == SIGTRAP;
}

std::string DescribeEnd(int wait_status) {
  if (WIFSIGNALED(wait_status))
    return fmt::format("signal {} ({})", WTERMSIG(wait_status), strsignal(WTERMSIG(wait_status)));
  return fmt::format("exit code {}", WEXITSTATUS(wait_status));
}

std::string ReadLastLine(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return CleanText(last);
}

// Between fork and exec only async-signal-safe calls are allowed: everything is prepared before.
// `log_fd` < 0: no log could be opened, and the worker does without one.
[[noreturn]] void BecomeWorker(char* const* arguments, bool log_wanted, int log_fd, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it died before we asked to die with it
  const int null_fd = open("/dev/null", O_RDWR);
  if (null_fd >= 0) {
    dup2(null_fd, STDIN_FILENO);
    dup2(null_fd, STDOUT_FILENO);  // the coordinator's stdout is for its own document
    if (log_wanted) dup2(null_fd, STDERR_FILENO);
  }
  if (log_fd >= 0) dup2(log_fd, STDERR_FILENO);
  close_range(3, ~0U, 0);  // liblcm's sockets are not close-on-exec
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execv(arguments[0], arguments);
  _exit(127);
}

}  // namespace

std::string FindWorkerProgram(const std::string& program) {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / program).string();
}

LocalWorkers::LocalWorkers(LocalWorkerOptions options, const Clock* clock,
                           std::function<void(const std::string&, pid_t, DeathCause)> on_death)
    : options_(std::move(options)), clock_(clock), on_death_(std::move(on_death)) {
  if (access(options_.program.c_str(), X_OK) != 0) {
    throw std::runtime_error(fmt::format("worker program {}: {}", options_.program, std::strerror(errno)));
  }
  slots_.resize(static_cast<std::size_t>(std::max(0, options_.count)));
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    slots_[i].name = fmt::format("local-{}", i + 1);
    StartOrWait(&slots_[i]);
  }
}

LocalWorkers::~LocalWorkers() { Stop(1.0); }

std::string LocalWorkers::MakeLogPath(const Slot& slot) const {
  return options_.log_directory.empty() ? "" : options_.log_directory + "/" + slot.name + ".log";
}

std::string LocalWorkers::Start(Slot* slot) {
  std::vector<std::string> words = {options_.program, "--lcm-url", options_.lcm_url, "--name", slot->name};
  if (!options_.key_file.empty()) words.insert(words.end(), {"--key", options_.key_file});
  if (!options_.engine.empty()) words.insert(words.end(), {"--engine", options_.engine});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string log_path = MakeLogPath(*slot);
  int log_fd = -1;
  if (!log_path.empty()) {
    log_fd = open(log_path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) BecomeWorker(arguments.data(), !log_path.empty(), log_fd, parent);
  const int error = errno;
  if (log_fd >= 0) close(log_fd);
  if (pid < 0) return fmt::format("a worker cannot be started: {}", std::strerror(error));
  slot->pid = pid;
  slot->started_us = clock_->now_us();
  return "";
}

void LocalWorkers::StartOrWait(Slot* slot) {
  const std::string failure = Start(slot);
  if (!failure.empty()) NoteEarlyEnd(slot, failure);
}

void LocalWorkers::Poll() {
  for (Slot& slot : slots_) {
    int wait_status = 0;
    if (slot.pid != 0 && waitpid(slot.pid, &wait_status, WNOHANG) == slot.pid) Reap(&slot, wait_status);
    if (slot.pid == 0 && !slot.given_up && clock_->now_us() >= slot.start_due_us) {
      ++restarts_;
      StartOrWait(&slot);
    }
  }
}

void LocalWorkers::Reap(Slot* slot, int wait_status) {
  const pid_t pid = std::exchange(slot->pid, 0);
  const bool fault = WIFSIGNALED(wait_status) && IsFaultSignal(WTERMSIG(wait_status));
  on_death_(slot->name, pid, fault ? DeathCause::kFault : DeathCause::kOutside);
  const std::int64_t life_us = clock_->now_us() - slot->started_us;
  // What is killed from outside may live next time; what ends by itself at once will not. Faults are judged by the
  // dispatcher first: three of one request are poison, before these five.
  const bool by_itself = fault || WIFEXITED(wait_status);
  if (!by_itself || life_us >= kSteadyUs) slot->own_ends = 0;
  if (!by_itself || life_us >= kEarlyUs) slot->early_ends = 0;
  if (by_itself && life_us < kEarlyUs) {
    NoteEarlyEnd(slot, DescribeEnd(wait_status));
  } else {
    PlanRestart(slot, by_itself);
  }
}

void LocalWorkers::PlanRestart(Slot* slot, bool by_itself) {
  if (by_itself) ++slot->own_ends;
  const std::int64_t delay_us = kRestartDelayUs << std::min(slot->own_ends, kMostDoublings);
  slot->start_due_us = clock_->now_us() + std::min(delay_us, kLongestDelayUs);
}

void LocalWorkers::NoteEarlyEnd(Slot* slot, const std::string& how) {
  PlanRestart(slot, true);
  if (++slot->early_ends < kMaxEarlyEnds) return;
  slot->given_up = true;
  if (std::any_of(slots_.begin(), slots_.end(), [](const Slot& other) { return !other.given_up; })) return;
  const std::string log_path = MakeLogPath(*slot);
  const std::string last_line = log_path.empty() ? "" : ReadLastLine(log_path);
  throw std::runtime_error(fmt::format("worker {} ended {} times within a second of its start, last with {}{}{}{}",
                                       slot->name, kMaxEarlyEnds, how, last_line.empty() ? "" : ": ", last_line,
                                       log_path.empty() ? "" : fmt::format(" (see {})", log_path)));
}

void LocalWorkers::Stop(double grace_s) {
  for (const Slot& slot : slots_) {
    if (slot.pid != 0) kill(slot.pid, SIGTERM);
  }
  const std::int64_t end_us = clock_->now_us() + static_cast<std::int64_t>(grace_s * 1e6);
  for (Slot& slot : slots_) {
    while (slot.pid != 0) {
      if (waitpid(slot.pid, nullptr, WNOHANG) != 0) {
        slot.pid = 0;
      } else if (clock_->now_us() >= end_us) {
        kill(slot.pid, SIGKILL);
        waitpid(slot.pid, nullptr, 0);
        slot.pid = 0;
      } else {
        std::this_thread::sleep_for(kStopPoll);
      }
    }
  }
}

void LocalWorkers::Kill(const std::string& name, pid_t pid) {
  for (const Slot& slot : slots_) {
    if (slot.name == name && slot.pid == pid && pid != 0) kill(pid, SIGKILL);
  }
}

std::vector<pid_t> LocalWorkers::ListProcesses() const {
  std::vector<pid_t> processes;
  for (const Slot& slot : slots_) {
    if (slot.pid != 0) processes.push_back(slot.pid);
  }
  return processes;
}

}  // namespace knap
