// A whole cluster in one thread: a simulated clock and a network that, by the seed alone, drops, duplicates, delays,
// reorders and corrupts. Equal seeds give equal histories.
//
// One participant, the driver, calls Receive with a timeout: that alone moves time on, event by event. All others are
// reactive: they are called when a message arrives for them or at an instant they asked for, and must not block.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/wire/clock.h"
#include "lcmtypes/wire/transport.h"

namespace knap {

struct FaultRates {
  double drop = 0.0;       // probability that a delivery is lost
  double duplicate = 0.0;  // probability that it comes twice
  double delay = 0.0;      // probability that it takes up to max_delay_us instead of about 100 us; this also reorders
  double corrupt = 0.0;    // probability that bits are flipped or the end is cut off
  std::int64_t max_delay_us = 400'000;
};

class SimulatedTransport;

class SimulatedNetwork : public Clock {
 public:
  explicit SimulatedNetwork(std::uint64_t seed);

  std::int64_t now_us() const override { return now_us_; }
  std::int64_t wall_us() const override { return now_us_; }

  void set_faults(const FaultRates& faults) { faults_ = faults; }

  // From now on nothing that participant `from` sends reaches participant `to`, until Mend; the other way is open.
  void Cut(int from, int to) { cut_.insert({from, to}); }
  void Mend(int from, int to) { cut_.erase({from, to}); }

  // Called after every event, before the next one.
  void set_on_event(std::function<void()> hook) { on_event_ = std::move(hook); }

  // A participant that hears these channels. `on_arrival` (may be empty, for the driver) is called after a message was
  // put into its inbox. The network must outlive it.
  std::unique_ptr<SimulatedTransport> Connect(const std::vector<std::string>& channels,
                                              std::function<void()> on_arrival);

  // Calls `action` at this instant (not before now).
  void Schedule(std::int64_t at_us, std::function<void()> action);

  // Lets events happen until `done()` holds after one, or until the instant.
  void Advance(std::int64_t until_us, const std::function<bool()>& done);

  // A number in [0, 1) from the network's own stream, for schedules of faults beside the network's.
  double DrawUniform();

 private:
  friend class SimulatedTransport;
  void Send(int from, const std::string& channel, const std::vector<std::uint8_t>& bytes);
  void Deliver(int receiver, const std::string& channel, std::vector<std::uint8_t> bytes);
  void Corrupt(std::vector<std::uint8_t>* bytes);

  std::int64_t now_us_ = 0;
  std::int64_t event_count_ = 0;
  int next_receiver_ = 0;
  FaultRates faults_;
  std::set<std::pair<int, int>> cut_;  // (from, to)
  std::function<void()> on_event_;
  std::mt19937_64 random_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::function<void()>> events_;  // (instant, order of creation)
  std::map<int, SimulatedTransport*> receivers_;                                   // by order of connection
};

class SimulatedTransport : public Transport {
 public:
  ~SimulatedTransport() override;
  SimulatedTransport(const SimulatedTransport&) = delete;
  SimulatedTransport& operator=(const SimulatedTransport&) = delete;

  void Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) override;
  std::optional<Message> Receive(std::int64_t timeout_us) override;  // timeout 0 never moves time
  void Wake() override { woken_ = true; }
  TransportCounters counters() const override { return counters_; }
  int address() const { return index_; }  // for SimulatedNetwork::Cut

 private:
  friend class SimulatedNetwork;
  SimulatedTransport(SimulatedNetwork* network, int index, std::set<std::string> channels,
                     std::function<void()> on_arrival);

  SimulatedNetwork* network_;
  int index_;
  std::set<std::string> channels_;
  std::function<void()> on_arrival_;
  std::deque<Message> inbox_;
  bool woken_ = false;
  TransportCounters counters_;
};

}  // namespace knap
