#include "tests/coordinator/request_book.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "lcmtypes/wire/channels.h"

namespace knap {
namespace {

constexpr std::size_t kMaxCopies = 2;

template <typename Range>
std::ptrdiff_t Count(const Range& ids, const ContentId& id) {
  return std::count(ids.begin(), ids.end(), id);
}

std::string FindDefect(const RequestBook& book, const ContentId& id, const Request& request) {
  const bool waits = request.state == RequestState::kWaiting;
  const bool leased = request.state == RequestState::kLeased;
  const bool answered = request.state == RequestState::kAnswered;
  if (Count(book.queue, id) != (waits ? 1 : 0)) {
    return fmt::format("is {} times in the queue and {}", Count(book.queue, id), waits ? "waits" : "does not wait");
  }
  if (leased == request.leases.empty()) {
    return fmt::format("has {} holders and is {}leased", request.leases.size(), leased ? "" : "not ");
  }
  if (answered != request.slots.empty()) return answered ? "is answered, and still wanted" : "is wanted by nobody";
  if (request.leases.size() > kMaxCopies) return fmt::format("is held by {} workers", request.leases.size());
  if (static_cast<std::size_t>(request.attempts) < request.leases.size()) return "has more holders than attempts";
  for (const Lease& lease : request.leases) {
    const auto holding = book.holdings.find(lease.worker);
    if (holding == book.holdings.end() || Count(holding->second.ids, id) != 1) {
      return fmt::format("is leased to worker {:016x}, which does not hold it once",
                         static_cast<std::uint64_t>(lease.worker));
    }
  }
  const auto owed = [&](const OwedAcknowledgement& entry) { return entry.id == id; };
  if (answered && std::none_of(book.owed.begin(), book.owed.end(), owed))
    return "is answered, and no acknowledgement is owed";
  return "";
}

std::string FindDefect(const RequestBook& book, std::int64_t worker, const Holding& holding) {
  if (holding.ids.empty()) return "holds nothing and is listed";
  if (holding.ids.size() > static_cast<std::size_t>(kMaxQueue)) return fmt::format("holds {}", holding.ids.size());
  for (const ContentId& id : holding.ids) {
    const auto request = book.requests.find(id);
    const bool leased =
        request != book.requests.end() && std::any_of(request->second.leases.begin(), request->second.leases.end(),
                                                      [&](const Lease& lease) { return lease.worker == worker; });
    if (!leased) return fmt::format("holds request {}, which is not leased to it", FormatHex(id));
    if (holding.alone && !request->second.suspect) return "is kept apart for a request that is no suspect";
  }
  if (holding.alone && holding.ids.size() > 1) return "holds a suspect and something else";
  for (const ContentId& id : holding.unsent) {
    if (Count(holding.ids, id) == 0)
      return fmt::format("is to be sent request {}, which it does not hold", FormatHex(id));
    if (Count(holding.unsent, id) > 1) return fmt::format("is to be sent request {} twice", FormatHex(id));
  }
  return "";
}

}  // namespace

std::string FindDefect(const RequestBook& book) {
  std::size_t answered = 0;
  for (const auto& [id, request] : book.requests) {
    answered += request.state == RequestState::kAnswered ? 1 : 0;
    const std::string defect = FindDefect(book, id, request);
    if (!defect.empty()) return fmt::format("request {} {}", FormatHex(id), defect);
  }
  if (answered != book.answered) return fmt::format("{} requests are answered, {} counted", answered, book.answered);
  for (const ContentId& id : book.queue) {
    if (book.requests.count(id) == 0) return fmt::format("request {} is in the queue alone", FormatHex(id));
  }
  for (const auto& [worker, holding] : book.holdings) {
    const std::string defect = FindDefect(book, worker, holding);
    if (!defect.empty()) return fmt::format("worker {:016x} {}", static_cast<std::uint64_t>(worker), defect);
  }
  return "";
}

}  // namespace knap
