// Where every request of a run stands and who holds it: the one place that knows, and the only one that changes it.
//
//   question → kWaiting ⇄ kLeased → kAnswered → acknowledged, and then it is forgotten here
//
// A request is leased to one worker, or to two when it straggles. A suspect was held by a worker that crashed from
// inside: it is given only to a worker that holds nothing else, until it is answered. Whatever the table is told, what
// it holds agrees with itself; tests/coordinator/request_book.h says how to see that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "coordinator/rollout_service.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/value_parts.h"

namespace knap {

enum class RequestState {
  kWaiting,   // nobody holds it; it has its place in the queue
  kLeased,    // one worker holds it, or two
  kAnswered,  // its answer is accepted, and not yet durable
};

struct Lease {
  std::int64_t worker = 0;   // instance
  std::int64_t sent_us = 0;  // when it was last sent, or put among what is sent next
  bool arrived = false;      // the worker's status has listed it
  std::int64_t given_us = 0;
  std::int32_t attempt = 0;  // which of the times the request was given to a worker, from 1
};

// Parts of an answer that have come from one worker.
struct PartialAnswer {
  std::int64_t worker = 0;
  ValueAssembly gradient;
};

struct Request {
  RequestState state = RequestState::kWaiting;
  RolloutQuery query;
  std::vector<RolloutOutcome*> slots;  // where the answer is wanted
  std::vector<Lease> leases;           // oldest first
  std::vector<PartialAnswer> partial;
  std::int64_t opened_us = 0;
  std::int32_t attempts = 0;          // how often it was given to a worker
  std::int32_t fatal_attempts = 0;    // deaths from inside that are charged to it
  std::set<std::int64_t> stalled_on;  // instances that got stuck on it
  std::set<std::string> lacking;      // names of workers that lacked something for it; they do not get it again
  bool suspect = false;
};

// What one worker holds.
struct Holding {
  std::vector<ContentId> ids;     // in the order in which they were given
  std::vector<ContentId> unsent;  // of these: put among what is sent next
  bool alone = false;             // it holds a suspect: nothing else may be given to it
};

// An acknowledgement that waits until the answer is durable.
struct OwedAcknowledgement {
  ContentId id{};
  std::int64_t instance = 0;
  std::string worker;
};

// All that the table holds, for reading.
struct RequestBook {
  std::unordered_map<ContentId, Request, ContentIdHash> requests;
  std::deque<ContentId> queue;               // the waiting ones, next one first
  std::map<std::int64_t, Holding> holdings;  // by instance; workers that hold nothing have none
  std::vector<OwedAcknowledgement> owed;
  std::size_t answered = 0;  // requests in state kAnswered
};

class RequestTable {
 public:
  // Deaths by fault signals, and stuck workers, after which a request is given up.
  static constexpr std::int32_t kMaxFatalAttempts = 3;
  static constexpr std::size_t kMaxStalls = 3;

  const RequestBook& book() const { return book_; }
  std::size_t open() const { return book_.requests.size() - book_.answered; }  // waiting or leased
  // Null unless it is waiting or leased.
  const Request* FindOpen(const ContentId& id) const;
  const Lease* FindLease(const ContentId& id, std::int64_t worker) const;  // null when the worker does not hold it
  const Holding& GetHolding(std::int64_t worker) const;                    // an empty one when it holds nothing

  // A question: its answer is wanted in *slot. False when the same is open already. Its place is at the queue's end.
  bool Ask(const ContentId& id, const RolloutQuery& query, RolloutOutcome* slot, std::int64_t now_us);

  // Gives an open request to a worker that does not hold it; a waiting one leaves the queue.
  void Give(const ContentId& id, std::int64_t worker, std::int64_t now_us);
  // Takes it from one holder and gives it to a worker that does not hold it.
  void Move(const ContentId& id, std::int64_t from, std::int64_t to, std::int64_t now_us);
  // The holder has not got it, or its answer was lost: it is put among what is sent next.
  void Resend(const ContentId& id, std::int64_t worker, std::int64_t now_us);
  // The holder's status lists it.
  void NoteArrival(const ContentId& id, std::int64_t worker);
  // What this worker is to be sent, once.
  std::vector<ContentId> TakeUnsent(std::int64_t worker);

  // The worker holds nothing any more. What nobody else holds goes to the front of the queue, in its order.
  void TakeBack(std::int64_t worker);

  // The worker died of a fault signal: what it held is suspect, and what it ran, or all it held, is charged with it.
  // Returns what has reached kMaxFatalAttempts.
  std::vector<ContentId> ChargeDeath(std::int64_t worker, const ContentId& running);
  // The worker got stuck on it. True when that makes kMaxStalls different workers.
  bool ChargeStall(const ContentId& id, std::int64_t worker);
  // The worker of this name lacked something for what it ran, or, when it ran nothing that it holds, for all it held.
  void NoteLack(std::int64_t worker, const ContentId& running, const std::string& name);

  // A part of an open request's answer: null when it belongs to no whole, else what has come from this worker so far.
  const ValueAssembly* AddPart(const ContentId& id, std::int64_t worker, std::int32_t total, std::int32_t first,
                               const std::vector<double>& values);

  // An open request is answered: nobody holds it and nothing waits for it. Returns it as it was.
  Request Answer(const ContentId& id);
  // It has failed for good, and is forgotten. Returns it as it was.
  Request Drop(const ContentId& id);
  // Forgets all that are open.
  void DropOpen();

  // An answer that came must be acknowledged to its worker when it is durable.
  void Owe(OwedAcknowledgement owed) { book_.owed.push_back(std::move(owed)); }
  // What is owed is durable now; answered requests are forgotten.
  std::vector<OwedAcknowledgement> TakeOwed();

 private:
  Request& GetOpen(const ContentId& id);
  void AddLease(const ContentId& id, Request* request, std::int64_t worker, std::int64_t now_us);
  void RemoveLease(const ContentId& id, Request* request, std::int64_t worker);
  Request TakeOut(const ContentId& id);  // of the queue and its holders' hands: as it was; what remains is empty

  RequestBook book_;
};

}  // namespace knap
