// The cluster of one command: a transport, a dispatcher and the workers this program starts itself.
//
// Own workers share a random run key in a file that only this user can read, and a bus of their own: a free port,
// unless a URL is given by flag or LCM_DEFAULT_URL. External workers are started by hand or by a batch system; then
// nothing is started here. A run that is finished tells them to stop as well; one that was interrupted, or that failed,
// leaves them to its next life.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/local_workers.h"
#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

struct ClusterOptions {
  bool external = false;
  std::string engine = "knap";  // that workers must have; when not external one of knap-worker's own
  int workers = 0;              // to start; 0: one a core. Without meaning when external.
  std::string lcm_url;          // empty: LCM_DEFAULT_URL, else a free port (external: the default address)
  std::string key_file;         // empty: a random key of this run's (external: the public key)
  double no_worker_s = 30.0;    // so long without any worker: NoWorkers
};

// What a run of this program expects of its workers' engine: for those of knap-worker its build beside this program and
// how this machine computes; any other name must stand for one arithmetic, without build and fingerprint.
// Throws std::runtime_error when knap-worker is not there.
EngineIdentity FindEngineIdentity(const std::string& name);

// Belongs to one thread (see local_workers.h).
class ClusterSession {
 public:
  // engine: what the workers have to be, FindEngineIdentity(options.engine). `scenario`: file name → bytes, as
  // LoadScenario gives them. `controls`: how many of every query's last values are controls or weights. Leaves nothing
  // on the disk, so that what is refused here is refused before a run has a folder. Throws std::invalid_argument for a
  // URL or a key file that is none, std::runtime_error with one line when the network fails.
  ClusterSession(const ClusterOptions& options, const EngineIdentity& engine,
                 const std::map<std::string, std::string>& scenario, std::size_t controls);
  ~ClusterSession();  // stops own workers
  ClusterSession(const ClusterSession&) = delete;
  ClusterSession& operator=(const ClusterSession&) = delete;

  // Starts own workers, whose key and logs are kept in `directory`; without one, in a temporary folder that is removed
  // at the end. External workers are not started here: no effect. Throws std::runtime_error with one line when the key
  // cannot be written or the workers' program cannot run.
  void StartWorkers(const std::filesystem::path& directory = {});

  // Evaluate throws as the dispatcher's does: NoWorkers (exit code 4), Interrupted (130, after SIGINT or SIGTERM),
  // std::runtime_error.
  RolloutService& service() { return *dispatcher_; }
  Dispatcher& dispatcher() { return *dispatcher_; }

  // Called about 20 times a second while the service works.
  void set_on_pump(std::function<void()> hook) { on_pump_ = std::move(hook); }

  // The run is over: sends its last status (see Dispatcher::SetProgress) and ends its workers. Nothing may be evaluated
  // afterwards.
  void Finish();

  std::int64_t run_id() const { return run_id_; }
  const std::string& lcm_url() const { return lcm_url_; }
  const std::string& key_file() const { return key_file_; }  // empty: the public key
  int workers_wanted() const { return workers_wanted_; }     // 0: whoever comes
  int worker_restarts() const { return workers_ ? workers_->restarts() : 0; }

 private:
  std::int64_t run_id_;
  std::string lcm_url_;
  std::unique_ptr<TemporaryFolder> temporary_;
  std::string key_file_;
  RunKey key_;
  std::string engine_;
  int workers_wanted_ = 0;
  SteadyClock clock_;
  std::unique_ptr<Transport> transport_;
  std::unique_ptr<Dispatcher> dispatcher_;
  std::unique_ptr<LocalWorkers> workers_;
  std::function<void()> on_pump_;
};

// `options.workers`, or the number of cores this process may use.
int CalcWorkerCount(const ClusterOptions& options);

}  // namespace knap
