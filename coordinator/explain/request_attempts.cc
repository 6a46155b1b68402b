#include "coordinator/explain/request_attempts.h"

#include <map>
#include <utility>

namespace knap {
namespace {

// One of them may be abbreviated.
bool AreSame(const std::string& a, const std::string& b) { return a.starts_with(b) || b.starts_with(a); }

void AddSetback(const RequestSetback& setback, std::map<std::pair<std::size_t, int>, RequestAttempt>* attempts) {
  const bool waited = setback.worker.empty();  // for the next one, when the run was broken off
  RequestAttempt& attempt = (*attempts)[{setback.life, setback.attempt + (waited ? 1 : 0)}];
  if (!waited) {
    attempt.worker = setback.worker;
    attempt.given_s = setback.time_s - setback.held_s;
  }
  if (setback.why == "message_lost") {
    attempt.resent.push_back(&setback);
  } else if (setback.why == "straggler") {
    attempt.copied = &setback;
    RequestAttempt& copy = (*attempts)[{setback.life, setback.copy_attempt}];
    copy.worker = setback.copy_to;
    copy.given_s = setback.time_s;
    copy.copy_of = &setback;
  } else {
    attempt.lost = &setback;
  }
}

}  // namespace

std::vector<RequestAttempt> ListAttempts(const RunRecord& record, const std::string& id) {
  std::map<std::pair<std::size_t, int>, RequestAttempt> attempts;
  for (const RequestSetback& setback : record.setbacks) {
    if (AreSame(setback.id, id)) AddSetback(setback, &attempts);
  }
  for (const RolloutRow& answer : record.answers) {
    if (!AreSame(answer.id, id)) continue;
    RequestAttempt& attempt = attempts[{record.FindLife(answer.time_s), answer.attempt}];
    attempt.answer = &answer;
    attempt.worker = answer.worker;
    if (answer.held_s >= 0.0) attempt.given_s = answer.time_s - answer.held_s;
  }
  std::map<std::size_t, int> last;  // by life
  for (const auto& [place, attempt] : attempts) last[place.first] = place.second;
  for (const auto& [life, count] : last) {
    for (int number = 1; number < count; ++number) attempts[{life, number}];
  }
  std::vector<RequestAttempt> list;
  for (auto& [place, attempt] : attempts) {
    attempt.life = place.first;
    attempt.number = place.second;
    list.push_back(std::move(attempt));
  }
  return list;
}

bool IsUnrecorded(const RequestAttempt& attempt) {
  return attempt.number > 0 && attempt.answer == nullptr && attempt.lost == nullptr && attempt.copy_of == nullptr &&
         attempt.copied == nullptr;
}

}  // namespace knap
