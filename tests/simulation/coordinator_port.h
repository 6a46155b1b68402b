// The coordinator's way to the simulated network, and its mortality: every message it sends and everything it does to
// its disk is an effect, and at a drawn effect it dies. From then on nothing of it reaches anyone, whatever its
// destructors and handlers still do.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/simulated_transport.h"
#include "tests/simulation/simulated_disk.h"

namespace knap {

// kill -9. No std::exception, so that nobody believes to handle it.
struct CoordinatorKilled {};

class CoordinatorPort : public Transport {
 public:
  struct Options {
    std::optional<int> effects;    // it dies at this one, counted from 1; empty: never
    double end_s = 0.0;            // simulated time by which the run must have ended
    bool repairs_digests = false;  // a planted defect: damaged messages come with a right digest
    std::function<void()> check;   // called with every message sent or asked for; throws when something is wrong
  };

  CoordinatorPort(SimulatedNetwork* network, SimulatedDisk* disk, const std::vector<std::string>& channels,
                  const Options& options);

  // Throws CoordinatorKilled when this is the effect at which it dies.
  void Effect();
  bool is_alive() const { return alive_; }

  // SIGSTOP until this instant.
  void FreezeUntil(std::int64_t until_us) { frozen_until_us_ = until_us; }
  std::int64_t frozen_until_us() const { return frozen_until_us_; }

  int address() const { return inner_->address(); }  // for SimulatedNetwork::Cut

  // Throws std::runtime_error when it acknowledges an answer that no synced record of the disk holds.
  void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) override;
  // Throws std::runtime_error when the run should have ended.
  std::optional<Message> Receive(std::int64_t timeout_us) override;
  void Wake() override { inner_->Wake(); }
  TransportCounters counters() const override { return inner_->counters(); }

 private:
  void CheckAcknowledgements(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  SimulatedNetwork* network_;
  SimulatedDisk* disk_;
  const Options options_;
  const RunKey key_;
  std::unique_ptr<SimulatedTransport> inner_;
  bool alive_ = true;
  int effects_ = 0;
  std::int64_t frozen_until_us_ = 0;
};

}  // namespace knap
