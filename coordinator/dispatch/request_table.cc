#include "coordinator/dispatch/request_table.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace knap {
namespace {

bool Contains(const std::vector<ContentId>& ids, const ContentId& id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace

const Request* RequestTable::FindOpen(const ContentId& id) const {
  const auto found = book_.requests.find(id);
  return found == book_.requests.end() || found->second.state == RequestState::kAnswered ? nullptr : &found->second;
}

Request& RequestTable::GetOpen(const ContentId& id) {
  Request& request = book_.requests.at(id);
  if (request.state == RequestState::kAnswered) throw std::logic_error("request " + FormatHex(id) + " is not open");
  return request;
}

const Lease* RequestTable::FindLease(const ContentId& id, std::int64_t worker) const {
  const Request* request = FindOpen(id);
  if (request == nullptr) return nullptr;
  const auto lease = std::find_if(request->leases.begin(), request->leases.end(),
                                  [&](const Lease& held) { return held.worker == worker; });
  return lease == request->leases.end() ? nullptr : &*lease;
}

const Holding& RequestTable::GetHolding(std::int64_t worker) const {
  static const Holding kNothing;
  const auto found = book_.holdings.find(worker);
  return found == book_.holdings.end() ? kNothing : found->second;
}

bool RequestTable::Ask(const ContentId& id, const RolloutQuery& query, RolloutOutcome* slot, std::int64_t now_us) {
  const auto [found, is_new] = book_.requests.try_emplace(id);
  Request& request = found->second;
  if (!is_new && request.state != RequestState::kAnswered) {
    request.slots.push_back(slot);
    return false;
  }
  if (!is_new) --book_.answered;  // answered, and the answer is forgotten already: it is computed again
  request = Request{};
  request.query = query;
  request.slots = {slot};
  request.opened_us = now_us;
  book_.queue.push_back(id);
  return true;
}

void RequestTable::AddLease(const ContentId& id, Request* request, std::int64_t worker, std::int64_t now_us) {
  request->leases.push_back({worker, now_us, false, now_us, ++request->attempts});
  Holding& holding = book_.holdings[worker];
  holding.ids.push_back(id);
  holding.unsent.push_back(id);
  holding.alone = request->suspect;
}

void RequestTable::RemoveLease(const ContentId& id, Request* request, std::int64_t worker) {
  std::erase_if(request->leases, [&](const Lease& lease) { return lease.worker == worker; });
  Holding& holding = book_.holdings.at(worker);
  std::erase(holding.ids, id);
  std::erase(holding.unsent, id);
  if (holding.ids.empty()) book_.holdings.erase(worker);
}

void RequestTable::Give(const ContentId& id, std::int64_t worker, std::int64_t now_us) {
  Request& request = GetOpen(id);
  if (request.state == RequestState::kWaiting) std::erase(book_.queue, id);
  request.state = RequestState::kLeased;
  AddLease(id, &request, worker, now_us);
}

void RequestTable::Move(const ContentId& id, std::int64_t from, std::int64_t to, std::int64_t now_us) {
  Request& request = GetOpen(id);
  RemoveLease(id, &request, from);
  AddLease(id, &request, to, now_us);
}

void RequestTable::Resend(const ContentId& id, std::int64_t worker, std::int64_t now_us) {
  for (Lease& lease : GetOpen(id).leases) {
    if (lease.worker == worker) lease.sent_us = now_us;
  }
  Holding& holding = book_.holdings.at(worker);
  if (!Contains(holding.unsent, id)) holding.unsent.push_back(id);
}

void RequestTable::NoteArrival(const ContentId& id, std::int64_t worker) {
  for (Lease& lease : GetOpen(id).leases) {
    if (lease.worker == worker) lease.arrived = true;
  }
}

std::vector<ContentId> RequestTable::TakeUnsent(std::int64_t worker) {
  const auto found = book_.holdings.find(worker);
  return found == book_.holdings.end() ? std::vector<ContentId>{} : std::exchange(found->second.unsent, {});
}

void RequestTable::TakeBack(std::int64_t worker) {
  const std::vector<ContentId> ids = GetHolding(worker).ids;
  for (auto id = ids.rbegin(); id != ids.rend(); ++id) {
    Request& request = GetOpen(*id);
    RemoveLease(*id, &request, worker);
    if (!request.leases.empty()) continue;
    request.state = RequestState::kWaiting;
    book_.queue.push_front(*id);
  }
}

std::vector<ContentId> RequestTable::ChargeDeath(std::int64_t worker, const ContentId& running) {
  std::vector<ContentId> poison;
  const std::vector<ContentId>& ids = GetHolding(worker).ids;
  for (const ContentId& id : ids) {
    Request& request = GetOpen(id);
    request.suspect = true;
    // Among several the culprit is not known: from now on each of them runs alone.
    if (ids.size() > 1 && id != running) continue;
    if (++request.fatal_attempts >= kMaxFatalAttempts) poison.push_back(id);
  }
  return poison;
}

bool RequestTable::ChargeStall(const ContentId& id, std::int64_t worker) {
  Request& request = GetOpen(id);
  return request.stalled_on.insert(worker).second && request.stalled_on.size() >= kMaxStalls;
}

void RequestTable::NoteLack(std::int64_t worker, const ContentId& running, const std::string& name) {
  const std::vector<ContentId>& ids = GetHolding(worker).ids;
  const bool runs_own = Contains(ids, running);
  for (const ContentId& id : ids) {
    if (!runs_own || id == running) GetOpen(id).lacking.insert(name);
  }
}

const ValueAssembly* RequestTable::AddPart(const ContentId& id, std::int64_t worker, std::int32_t total,
                                           std::int32_t first, const std::vector<double>& values) {
  std::vector<PartialAnswer>& partial = GetOpen(id).partial;
  auto part = std::find_if(partial.begin(), partial.end(), [&](const PartialAnswer& p) { return p.worker == worker; });
  if (part == partial.end()) {
    partial.push_back({worker, ValueAssembly(total)});
    part = partial.end() - 1;
  }
  return part->gradient.Add(total, first, values) ? &part->gradient : nullptr;
}

Request RequestTable::TakeOut(const ContentId& id) {
  Request& request = GetOpen(id);
  if (request.state == RequestState::kWaiting) std::erase(book_.queue, id);
  const std::vector<Lease> leases = request.leases;
  for (const Lease& lease : leases) RemoveLease(id, &request, lease.worker);
  Request before = std::exchange(request, Request{});
  before.leases = leases;
  return before;
}

Request RequestTable::Answer(const ContentId& id) {
  Request before = TakeOut(id);
  book_.requests.at(id).state = RequestState::kAnswered;
  ++book_.answered;
  return before;
}

Request RequestTable::Drop(const ContentId& id) {
  Request before = TakeOut(id);
  book_.requests.erase(id);
  return before;
}

void RequestTable::DropOpen() {
  std::erase_if(book_.requests, [](const auto& entry) { return entry.second.state != RequestState::kAnswered; });
  book_.queue.clear();
  book_.holdings.clear();
}

std::vector<OwedAcknowledgement> RequestTable::TakeOwed() {
  for (const OwedAcknowledgement& owed : book_.owed) {
    const auto found = book_.requests.find(owed.id);
    if (found == book_.requests.end() || found->second.state != RequestState::kAnswered) continue;
    book_.requests.erase(found);
    --book_.answered;
  }
  return std::exchange(book_.owed, {});
}

}  // namespace knap
