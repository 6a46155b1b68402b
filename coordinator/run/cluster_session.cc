#include "coordinator/run/cluster_session.h"

#include <fmt/format.h>
#include <sched.h>
#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "coordinator/run/stop_signal.h"
#include "lcmtypes/wire/multicast.h"
#include "lcmtypes/wire/open_transport.h"
#include "worker/knap_identity.h"

namespace knap {
namespace {

namespace fs = std::filesystem;

constexpr double kStopGrace_s = 1.0;
constexpr double kExternalStop_s = 5.0;  // they may be busy, and far away; who has not heard by then is left alone

std::int64_t MakeRunId() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start");
  std::int64_t id = 0;
  while (id == 0) randombytes_buf(&id, sizeof(id));
  return id;
}

std::string ChooseUrl(const ClusterOptions& options) {
  // A bus of its own keeps runs on one machine apart; external workers have to know where to look.
  const std::string url = ChooseLcmUrl(options.lcm_url, options.external ? kDefaultLcmUrl : "");
  return url.empty() ? MakeFreeLcmUrl() : url;
}

RunKey ChooseKey(const ClusterOptions& options) {
  if (options.key_file.empty()) return options.external ? RunKey() : RunKey::MakeRandom();
  try {
    return RunKey::ReadFile(options.key_file);
  } catch (const std::runtime_error& e) {
    throw std::invalid_argument(e.what());
  }
}

}  // namespace

int CalcWorkerCount(const ClusterOptions& options) {
  if (options.workers > 0) return options.workers;
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) return 1;
  return std::max(1, CPU_COUNT(&cores));
}

EngineIdentity FindEngineIdentity(const std::string& name) {
  if (IsOwnEngine(name)) return MakeOwnIdentity(name, FindWorkerProgram());
  return {name, "", {}};
}

ClusterSession::ClusterSession(const ClusterOptions& options, const EngineIdentity& engine,
                               const std::map<std::string, std::string>& scenario, std::size_t controls)
    : run_id_(MakeRunId()),
      lcm_url_(ChooseUrl(options)),
      key_file_(options.key_file),
      key_(ChooseKey(options)),
      engine_(engine.name),
      workers_wanted_(options.external ? 0 : CalcWorkerCount(options)) {
  transport_ = OpenTransport(lcm_url_, Dispatcher::ListChannels(), &clock_);
  DispatchOptions dispatch;
  dispatch.run_id = run_id_;
  dispatch.engine = engine;
  dispatch.control_size = controls;
  dispatch.no_worker_s = options.no_worker_s;
  dispatcher_ = std::make_unique<Dispatcher>(dispatch, key_, scenario, transport_.get(), &clock_);
  dispatcher_->set_stop_flag(&CatchStopSignals());
  dispatcher_->set_on_pump([this] {
    if (workers_) workers_->Poll();
    if (on_pump_) on_pump_();
  });
}

void ClusterSession::Finish() {
  dispatcher_->StopWorkers(workers_ ? kStopGrace_s : kExternalStop_s);
  workers_.reset();
}

ClusterSession::~ClusterSession() {
  if (workers_) workers_->Stop(kStopGrace_s);
}

void ClusterSession::StartWorkers(const fs::path& directory) {
  if (workers_wanted_ == 0) return;
  if (directory.empty()) temporary_ = std::make_unique<TemporaryFolder>();
  const fs::path folder = directory.empty() ? temporary_->path() : directory;
  if (key_file_.empty()) {
    const fs::path path = folder / "key";
    fs::remove(path);  // of an earlier life of this run; its workers are gone
    key_.WriteFile(path.string());
    key_file_ = path.string();
  }
  const fs::path logs = folder / "workers";
  std::error_code no_logs;  // then the workers do without
  fs::create_directories(logs, no_logs);
  LocalWorkerOptions options;
  options.count = workers_wanted_;
  options.program = FindWorkerProgram();
  options.engine = engine_;
  options.lcm_url = lcm_url_;
  options.key_file = key_file_;
  options.log_directory = logs.string();
  workers_ = std::make_unique<LocalWorkers>(
      options, &clock_,
      [this](const std::string& name, pid_t pid, DeathCause cause) { dispatcher_->ReportDeath(name, pid, cause); });
  dispatcher_->set_on_stalled([this](const KnownWorker& worker) { workers_->Kill(worker.name, worker.pid); });
}

}  // namespace knap
