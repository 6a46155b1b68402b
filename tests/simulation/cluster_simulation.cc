#include "tests/simulation/cluster_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run_directory/journal.h"
#include "tests/coordinator/request_book.h"
#include "tests/simulation/coordinator_port.h"
#include "tests/simulation/reference_run.h"
#include "tests/simulation/simulated_disk.h"
#include "tests/worker/closed_form_engine.h"
#include "tests/worker/simulated_worker.h"

namespace knap {
namespace {

constexpr double kFaultsEnd_s = 40.0;
constexpr double kEnd_s = kFaultsEnd_s + 100.0;
constexpr int kMostLives = 4;
constexpr std::size_t kMostWorkers = 5;
constexpr int kMostHangs = 2;  // a request that hangs three times ends the run, as it should
constexpr int kMostLacks = 1;  // what every worker lacks something for ends the run, as it should
constexpr int kMostFailedReads = 2;
constexpr double kLease_s = 1.0;
constexpr double kLeaseSlack_s =
    1.0;                        // a message of the dead may still be on its way, and the coordinator looks at times
constexpr int kMostFaults = 2;  // a request that crashes three workers from inside is poison, as it should be
const RunIdentity kIdentity = {{"configuration", "simulated"}};

// One worker's place: a process that is started again whenever it ends. Local ones are the coordinator's children: they
// die with it, it learns how they died, and it starts them again. External ones live on without it.
struct Place {
  std::string name;
  bool local = false;
  std::unique_ptr<SimulatedWorker> process;
  std::int64_t instance = 0;
  std::optional<DeathCause> unreported;  // of a local one, until the coordinator looks
  bool hangs_next = false, slow_next = false, lacks_next = false;
  bool foreign = false;  // its machine computes other bits, and its fingerprint says so
};

// Of a machine that rounds otherwise.
EngineIdentity MakeForeignIdentity() {
  EngineIdentity identity = ClosedFormEngine().identity();
  identity.fingerprint[0] ^= 1;
  return identity;
}

class Simulation {
 public:
  Simulation(std::uint64_t seed, PlantedDefect defect)
      : problem_index_(seed % kProblems),
        problem_(MakeSimulatedProblem(problem_index_)),
        defect_(defect),
        network_(seed) {}

  SimulationReport Run() {
    const double severity = Draw();  // some seeds are calm
    rates_.drop = 0.3 * severity * Draw();
    rates_.duplicate = 0.3 * severity * Draw();
    rates_.delay = 0.3 * severity * Draw();
    rates_.corrupt = 0.2 * severity * Draw();
    network_.set_faults(rates_);
    mean_fault_interval_s_ = 0.1 + 3.0 * Draw();
    const int count = 1 + DrawBelow(3);
    for (int i = 0; i < count; ++i) AddPlace();
    ScheduleFault();
    network_.set_on_event([this] {
      ReapLacking();
      Check();
    });
    try {
      while (!Live()) Bury();
    } catch (const std::exception& e) {
      report_.failure = e.what();
    }
    report_.simulated_s = 1e-6 * static_cast<double>(network_.now_us());
    network_.set_on_event({});
    EndLife();
    return report_;
  }

 private:
  double Draw() { return network_.DrawUniform(); }
  int DrawBelow(int count) { return static_cast<int>(count * Draw()); }
  std::int64_t After(double seconds) const { return network_.now_us() + static_cast<std::int64_t>(seconds * 1e6); }

  // The coordinator.

  // What must hold at any moment. Throws std::runtime_error when it does not.
  void Check() {
    ++report_.checks;
    if (disk_.lost()) throw std::runtime_error("the acknowledged answer to " + FormatShort(*disk_.lost()) + " is lost");
    if (!dispatcher_) return;
    const std::string defect = FindDefect(dispatcher_->requests());
    if (!defect.empty()) throw std::runtime_error("the book of requests: " + defect);
    const std::int64_t listening_us = std::max(life_started_us_, port_->frozen_until_us());
    for (const auto& [worker, holding] : dispatcher_->requests().holdings) {
      const auto known = dispatcher_->roster().workers().find(worker);
      if (known == dispatcher_->roster().workers().end() || known->second.silent || known->second.stalled) {
        throw std::runtime_error(fmt::format("worker {} holds requests and is not believed able to work", worker));
      }
      const auto death = deaths_us_.find(worker);
      const double limit_s = kLease_s + 1e-6 * static_cast<double>(rates_.max_delay_us) + kLeaseSlack_s;
      if (death == deaths_us_.end()) continue;
      if (1e-6 * static_cast<double>(network_.now_us() - std::max(death->second, listening_us)) > limit_s) {
        throw std::runtime_error(fmt::format("worker {} holds requests {:.1f} s after its death", worker, limit_s));
      }
    }
  }

  // From start to end; false when it was killed, or could not begin.
  bool Live() try {
    ++report_.lives;
    life_started_us_ = network_.now_us();
    CoordinatorPort::Options options;
    options.check = [this] { Check(); };
    if (report_.lives < kMostLives && Draw() < 0.6) options.effects = 1 + DrawBelow(Draw() < 0.3 ? 20 : 300);
    options.end_s = kEnd_s;
    options.repairs_digests = defect_ == PlantedDefect::kIgnoresDigests;
    port_ = std::make_unique<CoordinatorPort>(&network_, &disk_, Dispatcher::ListChannels(), options);
    if (!disk_.exists()) {
      port_->Effect();
      disk_.Create(Journal::EncodeHeader(kIdentity));
    }
    SimulatedFile::Hooks hooks;
    hooks.is_alive = [this] { return port_->is_alive(); };
    hooks.on_effect = [this] { port_->Effect(); };
    hooks.draw = [this] { return Draw(); };
    hooks.read_fails = report_.lives > 1 && report_.failed_reads < kMostFailedReads && Draw() < 0.2;
    hooks.read_is_short = defect_ == PlantedDefect::kReadsAreShort;
    report_.failed_reads += hooks.read_fails ? 1 : 0;
    hooks.sync_does_nothing = defect_ == PlantedDefect::kSyncDoesNothing;
    Journal::Opened opened = Journal::Open(std::make_unique<SimulatedFile>(&disk_, hooks), kIdentity);
    report_.torn_bytes += static_cast<std::int64_t>(opened.torn_bytes);

    DispatchOptions dispatch;
    dispatch.run_id = 100 + report_.lives;
    dispatch.engine = engine_.identity();
    dispatch.lease_s = defect_ == PlantedDefect::kLeasesNeverExpire ? 1e6 : kLease_s;
    dispatch.stall_s = defect_ == PlantedDefect::kNoStepProgress ? 1e6 : 4.0;
    dispatcher_ = std::make_unique<Dispatcher>(dispatch, RunKey(), problem_.scenario, port_.get(), &network_);
    JournaledService service(dispatcher_.get(), &opened.journal, opened.payloads);
    if (defect_ == PlantedDefect::kAcknowledgesBeforeJournal) dispatcher_->set_on_commit({});
    dispatcher_->set_on_pump([this] { TendLocalWorkers(); });
    dispatcher_->set_on_stalled([this](const KnownWorker& worker) {
      for (Place& place : places_) {
        if (place.local && place.instance == worker.instance) Crash(&place, DeathCause::kOutside);
      }
    });
    TendLocalWorkers();

    const ReferenceRun& reference = GetReferenceRun(problem_index_);
    ReferenceObserver observer(reference);
    const LearningResult learned = Learn(problem_.problem, problem_.options, service, observer);
    if (!HasSameBits(learned.theta, reference.theta)) throw std::runtime_error("theta has other bits");
    dispatcher_->StopWorkers(2.0);
    return true;
  } catch (const CoordinatorKilled&) {
    return false;
  } catch (const std::system_error&) {
    return false;  // the journal could not be read: nothing is done to it
  }

  void EndLife() {
    if (dispatcher_) {
      const DispatchCounters& counters = dispatcher_->counters();
      report_.counters.computed += counters.computed;
      report_.counters.reissued += counters.reissued;
      report_.counters.moved += counters.moved;
      report_.counters.copied += counters.copied;
      report_.counters.workers_refused += counters.workers_refused;
      report_.counters.resent += counters.resent;
      report_.counters.duplicates += counters.duplicates;
      report_.counters.workers_lacking += counters.workers_lacking;
      report_.counters.workers_lost += counters.workers_lost;
      report_.counters.workers_stalled += counters.workers_stalled;
      report_.counters.refused.corrupt += counters.refused.corrupt;
    }
    if (port_) report_.messages += port_->counters().received;
    dispatcher_.reset();
    port_.reset();
  }

  void Bury() {
    EndLife();
    disk_.Crash([this] { return Draw(); });
    for (Place& place : places_) {
      if (place.local) End(&place);
      if (place.local) place.unreported.reset();
    }
    network_.Advance(After(4.0 * Draw()), [] { return false; });
  }

  // Its children: buried, and started again.
  void TendLocalWorkers() {
    for (Place& place : places_) {
      if (!place.local || place.process) continue;
      if (place.unreported) {
        const auto pid = static_cast<std::int32_t>(place.instance % 100000);
        dispatcher_->ReportDeath(place.name, pid, *std::exchange(place.unreported, std::nullopt));
      }
      Start(&place);
    }
  }

  // Workers.

  void AddPlace() {
    Place place;
    place.name = fmt::format("w{}", places_.size());
    place.local = Draw() < 0.5;
    place.foreign = !places_.empty() && !place.local && Draw() < 0.1;  // the first one is sound
    places_.push_back(std::move(place));
    if (!places_.back().local) StartLater(places_.size() - 1, 2.0 * Draw() * Draw());
  }

  void StartLater(std::size_t index, double seconds) {
    network_.Schedule(After(seconds), [this, index] {
      if (!places_[index].process) Start(&places_[index]);
    });
  }

  void Start(Place* place) {
    const auto index = static_cast<std::size_t>(place - places_.data());
    place->instance = ++instances_;
    Engine* engine = place->foreign ? static_cast<Engine*>(&foreign_engine_) : &engine_;
    place->process = std::make_unique<SimulatedWorker>(&network_, engine, place->name, place->instance,
                                                       [this, index] { return DrawDuration(index); });
  }

  std::int64_t DrawDuration(std::size_t index) {
    Place& place = places_[index];
    if (std::exchange(place.lacks_next, false)) {
      ++report_.lacks;
      return SimulatedExecutor::kLacks;
    }
    if (std::exchange(place.hangs_next, false)) {
      ++report_.hangs;
      // Nobody kills an external one by the coordinator's word; its operator looks some time.
      if (!place.local) {
        network_.Schedule(After(5.0 + 8.0 * Draw()), [this, index, instance = place.instance] {
          if (places_[index].instance == instance) Crash(&places_[index], DeathCause::kOutside);
        });
      }
      return SimulatedExecutor::kForever;
    }
    const double factor = std::exchange(place.slow_next, false) ? 20.0 : 1.0;
    return static_cast<std::int64_t>(factor * (1e3 + 1.5e5 * Draw() * Draw()));
  }

  void End(Place* place) {
    if (place->process) deaths_us_[place->instance] = network_.now_us();
    place->process.reset();
  }

  // Those that have left because they lacked something; they come again.
  void ReapLacking() {
    for (Place& place : places_) {
      if (place.process && !place.process->reactor().lack().empty()) Leave(&place, DeathCause::kOutside);
    }
  }

  void Crash(Place* place, DeathCause cause) {
    if (!place->process) return;
    ++report_.worker_crashes;
    Leave(place, cause);
  }

  void Leave(Place* place, DeathCause cause) {
    End(place);
    if (place->local) {
      place->unreported = cause;
    } else {
      StartLater(static_cast<std::size_t>(place - places_.data()), 3.0 * Draw() * Draw());
    }
  }

  // Faults.

  void ScheduleFault() {
    network_.Schedule(After(2.0 * mean_fault_interval_s_ * Draw()), [this] {
      if (network_.now_us() > static_cast<std::int64_t>(kFaultsEnd_s * 1e6)) return;
      InjectFault();
      ScheduleFault();
    });
  }

  void InjectFault() {
    const auto index = static_cast<std::size_t>(DrawBelow(static_cast<int>(places_.size())));
    Place& place = places_[index];
    switch (DrawBelow(10)) {
      case 0:
        Crash(&place, DeathCause::kOutside);
        break;
      case 1:
        if (place.local && place.process && faults_++ < kMostFaults) Crash(&place, DeathCause::kFault);
        break;
      case 2:
        Freeze(index, 4.0 * Draw() * Draw());
        break;
      case 3:
        place.hangs_next = place.hangs_next || hangs_drawn_++ < kMostHangs;
        break;
      case 4:
        place.slow_next = true;
        break;
      case 5:
        FallSilent(2.0 * Draw() * Draw());
        break;
      case 6:
        CutOneWay(index, 12.0 * Draw() * Draw(), Draw() < 0.5);
        break;
      case 7:
        // The first place is sound: somebody can always do the work.
        if (index > 0) place.lacks_next = place.lacks_next || lacks_drawn_++ < kMostLacks;
        break;
      case 8:
        if (port_) port_->FreezeUntil(After(3.0 * Draw() * Draw()));
        break;
      default:
        if (places_.size() < kMostWorkers) AddPlace();
        break;
    }
  }

  void Freeze(std::size_t index, double seconds) {
    if (!places_[index].process) return;
    ++report_.freezes;
    places_[index].process->Freeze();
    network_.Schedule(After(seconds), [this, index, instance = places_[index].instance] {
      if (places_[index].process && places_[index].instance == instance) places_[index].process->Thaw();
    });
  }

  void CutOneWay(std::size_t index, double seconds, bool deaf) {
    if (!places_[index].process || !port_) return;
    ++report_.cuts;
    const int worker = places_[index].process->address(), coordinator = port_->address();
    const auto [from, to] = deaf ? std::pair(coordinator, worker) : std::pair(worker, coordinator);
    network_.Cut(from, to);
    network_.Schedule(After(seconds), [this, from = from, to = to] { network_.Mend(from, to); });
  }

  void FallSilent(double seconds) {
    ++report_.silences;
    FaultRates silence = rates_;
    silence.drop = 1.0;
    network_.set_faults(silence);
    network_.Schedule(After(seconds), [this] { network_.set_faults(rates_); });
  }

  const std::uint64_t problem_index_;
  const SimulatedProblem problem_;
  const PlantedDefect defect_;
  ClosedFormEngine engine_;
  WrongEngine foreign_engine_{MakeForeignIdentity()};
  SimulatedNetwork network_;
  FaultRates rates_;
  SimulatedDisk disk_;
  std::vector<Place> places_;
  std::int64_t instances_ = 1000;
  double mean_fault_interval_s_ = 1.0;
  int faults_ = 0;
  int hangs_drawn_ = 0;
  int lacks_drawn_ = 0;
  std::map<std::int64_t, std::int64_t> deaths_us_;  // by instance
  std::int64_t life_started_us_ = 0;                // of the coordinator
  std::unique_ptr<CoordinatorPort> port_;
  std::unique_ptr<Dispatcher> dispatcher_;
  SimulationReport report_;
};

}  // namespace

SimulationReport RunSimulation(std::uint64_t seed, PlantedDefect defect) { return Simulation(seed, defect).Run(); }

}  // namespace knap
