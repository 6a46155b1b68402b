#include "lcmtypes/wire/simulated_transport.h"

#include <algorithm>
#include <optional>

namespace knap {
namespace {

constexpr std::int64_t kMinLatencyUs = 50;
constexpr std::int64_t kLatencySpreadUs = 100;

}  // namespace

SimulatedNetwork::SimulatedNetwork(std::uint64_t seed) : random_(seed) {}

double SimulatedNetwork::DrawUniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

std::unique_ptr<SimulatedTransport> SimulatedNetwork::Connect(const std::vector<std::string>& channels,
                                                              std::function<void()> on_arrival) {
  std::unique_ptr<SimulatedTransport> transport(new SimulatedTransport(
      this, next_receiver_++, std::set<std::string>(channels.begin(), channels.end()), std::move(on_arrival)));
  receivers_[transport->index_] = transport.get();
  return transport;
}

void SimulatedNetwork::Schedule(std::int64_t at_us, std::function<void()> action) {
  events_.emplace(std::make_pair(std::max(at_us, now_us_), event_count_++), std::move(action));
}

void SimulatedNetwork::Advance(std::int64_t until_us, const std::function<bool()>& done) {
  while (!done()) {
    if (events_.empty() || events_.begin()->first.first > until_us) {
      now_us_ = std::max(now_us_, until_us);
      return;
    }
    auto event = events_.extract(events_.begin());
    now_us_ = event.key().first;
    event.mapped()();
    if (on_event_) on_event_();
  }
}

void SimulatedNetwork::Send(int from, const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  for (const auto& [index, receiver] : receivers_) {
    if (receiver->channels_.count(channel) == 0 || DrawUniform() < faults_.drop) continue;
    if (cut_.count({from, index}) != 0) continue;
    const int copies = DrawUniform() < faults_.duplicate ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      std::vector<std::uint8_t> copy = bytes;
      if (DrawUniform() < faults_.corrupt) Corrupt(&copy);
      const double spread =
          static_cast<double>(DrawUniform() < faults_.delay ? faults_.max_delay_us : kLatencySpreadUs);
      const std::int64_t at_us = now_us_ + kMinLatencyUs + static_cast<std::int64_t>(spread * DrawUniform());
      Schedule(at_us, [this, to = index, channel, copy] { Deliver(to, channel, copy); });
    }
  }
}

void SimulatedNetwork::Deliver(int receiver, const std::string& channel, std::vector<std::uint8_t> bytes) {
  const auto found = receivers_.find(receiver);
  if (found == receivers_.end()) return;  // it has left meanwhile
  SimulatedTransport* transport = found->second;
  transport->inbox_.push_back({channel, std::move(bytes), now_us_});
  ++transport->counters_.received;
  if (transport->on_arrival_) transport->on_arrival_();
}

void SimulatedNetwork::Corrupt(std::vector<std::uint8_t>* bytes) {
  if (bytes->empty()) return;
  const auto draw_index = [&] { return static_cast<std::size_t>(DrawUniform() * static_cast<double>(bytes->size())); };
  if (DrawUniform() < 0.2) {
    bytes->resize(draw_index());
    return;
  }
  const int flips = 1 + static_cast<int>(4 * DrawUniform());
  for (int i = 0; i < flips; ++i)
    (*bytes)[draw_index()] ^= static_cast<std::uint8_t>(1 << static_cast<int>(8 * DrawUniform()));
}

SimulatedTransport::SimulatedTransport(SimulatedNetwork* network, int index, std::set<std::string> channels,
                                       std::function<void()> on_arrival)
    : network_(network), index_(index), channels_(std::move(channels)), on_arrival_(std::move(on_arrival)) {}

SimulatedTransport::~SimulatedTransport() { network_->receivers_.erase(index_); }

void SimulatedTransport::Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  ++counters_.published;
  network_->Send(index_, channel, bytes);
}

std::optional<Message> SimulatedTransport::Receive(std::int64_t timeout_us) {
  if (inbox_.empty() && timeout_us > 0) {
    network_->Advance(network_->now_us() + timeout_us, [this] { return !inbox_.empty() || woken_; });
  }
  if (inbox_.empty()) {
    woken_ = false;
    return std::nullopt;
  }
  Message message = std::move(inbox_.front());
  inbox_.pop_front();
  return message;
}

}  // namespace knap
