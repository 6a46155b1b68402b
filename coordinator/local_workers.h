// The worker processes that a run starts on its own machine: kept alive, and stopped at the end.
//
// A worker that dies is started again: at once when it was killed, else after a pause that doubles, up to 10 s, with
// every end by itself in a row (a life of a minute breaks the row). One that ends by itself within a second of its
// start, several times in a row, is not going to live and is given up; when all are given up, Poll throws with the last
// line one of them wrote. Workers die with the coordinator (PR_SET_PDEATHSIG) and run in a process group of their own,
// so that Ctrl-C reaches the coordinator alone.
//
// Belongs to one thread, which must outlive it: the kernel ties the workers' lives to the thread that started them.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "lcmtypes/wire/clock.h"

namespace knap {

struct LocalWorkerOptions {
  int count = 1;
  std::string program;  // path; see FindWorkerProgram
  std::string lcm_url;
  std::string key_file;       // empty: the public default key
  std::string log_directory;  // worker NAME writes its stderr to NAME.log there if it can; empty: to ours
  std::string engine{};       // of those that the program has; empty: its first
};

// `program` in the folder of the running executable.
std::string FindWorkerProgram(const std::string& program = "knap-worker");

class LocalWorkers {
 public:
  // `on_death` is called from Poll when a worker has ended: name, process id, cause. Starts them all. Throws
  // std::runtime_error when the program is not there to be executed.
  LocalWorkers(LocalWorkerOptions options, const Clock* clock,
               std::function<void(const std::string&, pid_t, DeathCause)> on_death);
  ~LocalWorkers();  // stops them all
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;

  // Reaps the dead, and starts them again when it is time; call it about 20 times a second. Throws std::runtime_error
  // when no worker can live.
  void Poll();

  // SIGTERM, then SIGKILL to those that still run after `grace_s`; waits for all of them.
  void Stop(double grace_s);

  // Kills one that is stuck, if it is one of ours; Poll starts it again.
  void Kill(const std::string& name, pid_t pid);

  int restarts() const { return restarts_; }
  std::vector<pid_t> ListProcesses() const;  // those running now

 private:
  struct Slot {
    std::string name;
    pid_t pid = 0;  // 0: none runs
    std::int64_t started_us = 0;
    std::int64_t start_due_us = 0;
    int early_ends = 0;  // in a row
    int own_ends = 0;    // in a row: ended by itself
    bool given_up = false;
  };

  // Empty, or why the system cannot start one now.
  std::string Start(Slot* slot);
  void StartOrWait(Slot* slot);
  void Reap(Slot* slot, int wait_status);
  void PlanRestart(Slot* slot, bool by_itself);
  void NoteEarlyEnd(Slot* slot, const std::string& how);
  std::string MakeLogPath(const Slot& slot) const;

  const LocalWorkerOptions options_;
  const Clock* const clock_;
  const std::function<void(const std::string&, pid_t, DeathCause)> on_death_;
  std::vector<Slot> slots_;
  int restarts_ = 0;
};

}  // namespace knap
