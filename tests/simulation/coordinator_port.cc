#include "tests/simulation/coordinator_port.h"

#include <algorithm>
#include <stdexcept>

#include "knap/control_t.hpp"
#include "knap/rollout_request_t.hpp"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {

CoordinatorPort::CoordinatorPort(SimulatedNetwork* network, SimulatedDisk* disk,
                                 const std::vector<std::string>& channels, const Options& options)
    : network_(network), disk_(disk), options_(options), inner_(network->Connect(channels, {})) {}

void CoordinatorPort::Effect() {
  if (!alive_) return;
  if (options_.effects && ++effects_ == *options_.effects) {
    alive_ = false;
    throw CoordinatorKilled();
  }
}

void CoordinatorPort::Publish(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (!alive_) return;
  options_.check();
  CheckAcknowledgements(channel, bytes);
  Effect();
  inner_->Publish(channel, bytes);
}

void CoordinatorPort::CheckAcknowledgements(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  std::vector<ContentId> acknowledged;
  RefusalCounters refusals;
  if (channel.starts_with(MakeRequestChannel(""))) {
    acknowledged = ParseIds(Open<rollout_request_t>(bytes, key_, &refusals)->acknowledged);
  } else if (channel.starts_with(MakeControlChannel(""))) {
    const auto control = Open<control_t>(bytes, key_, &refusals);
    if (control->kind == control_t::kAcknowledge) acknowledged = ParseIds(control->ids);
  }
  for (const ContentId& id : acknowledged) {
    if (!disk_->HoldsAnswer(id)) {
      throw std::runtime_error("the answer to " + FormatShort(id) + " was acknowledged before the disk had it");
    }
    disk_->Rely(id);
  }
}

std::optional<Message> CoordinatorPort::Receive(std::int64_t timeout_us) {
  options_.check();
  if (network_->now_us() > static_cast<std::int64_t>(options_.end_s * 1e6)) {
    throw std::runtime_error("the run has not ended after " + std::to_string(options_.end_s) + " s");
  }
  if (frozen_until_us_ > network_->now_us()) network_->Advance(frozen_until_us_, [] { return false; });
  std::optional<Message> message = inner_->Receive(timeout_us);
  if (message && options_.repairs_digests && message->bytes.size() >= RunKey::kDigestSize) {
    const RunKey::Digest digest = key_.CalcDigest(message->bytes.data(), message->bytes.size());
    std::copy(digest.begin(), digest.end(), message->bytes.end() - RunKey::kDigestSize);
  }
  return message;
}

}  // namespace knap
