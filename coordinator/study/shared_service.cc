#include "coordinator/study/shared_service.h"

#include <algorithm>
#include <iterator>
#include <thread>
#include <utility>

namespace knap {

SharedService::SharedService(RolloutService* service, std::size_t members) : service_(service) {
  for (std::size_t i = 0; i < members; ++i) members_.emplace_back(this);
}

std::vector<RolloutOutcome> SharedService::Member::Evaluate(std::span<const RolloutQuery> queries) {
  std::unique_lock lock(shared_->mutex_);
  queries_ = queries;
  waiting_ = true;
  shared_->changed_.notify_all();
  shared_->changed_.wait(lock, [this] { return !waiting_ || shared_->failure_; });
  waiting_ = false;
  if (shared_->failure_) std::rethrow_exception(shared_->failure_);
  return std::exchange(outcomes_, {});
}

void SharedService::Leave(std::size_t i) {
  const std::lock_guard lock(mutex_);
  members_[i].left_ = true;
  changed_.notify_all();
}

bool SharedService::IsRoundReady() const {
  return std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.waiting_ || m.left_; });
}

void SharedService::Serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return IsRoundReady(); });
    std::vector<RolloutQuery> round;
    for (const Member& member : members_) {
      if (member.waiting_) round.insert(round.end(), member.queries_.begin(), member.queries_.end());
    }
    const bool all_left = std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.left_; });
    if (all_left) break;
    // The members wait, so nobody changes anything while the lock is given up.
    std::vector<RolloutOutcome> outcomes;
    std::exception_ptr failure;
    lock.unlock();
    try {
      outcomes = service_->Evaluate(round);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) {
      failure_ = failure;
      changed_.notify_all();
      changed_.wait(lock, [this] {
        return std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.left_; });
      });
      break;
    }
    auto next = outcomes.begin();
    for (Member& member : members_) {
      if (!member.waiting_) continue;
      const auto end = next + static_cast<std::ptrdiff_t>(member.queries_.size());
      member.outcomes_.assign(std::make_move_iterator(next), std::make_move_iterator(end));
      next = end;
      member.waiting_ = false;
    }
    changed_.notify_all();
  }
  if (failure_) std::rethrow_exception(failure_);
}

void RunTogether(RolloutService* service, std::size_t members,
                 const std::function<void(std::size_t, RolloutService*)>& work) {
  SharedService shared(service, members);
  std::mutex mutex;
  std::exception_ptr failure;  // the first of a member's own
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < members; ++i) {
    threads.emplace_back([&, i] {
      try {
        work(i, &shared.member(i));
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
      }
      shared.Leave(i);
    });
  }
  std::exception_ptr service_failure;
  try {
    shared.Serve();
  } catch (...) {
    service_failure = std::current_exception();  // also every member's; this one is the first cause
  }
  for (std::thread& thread : threads) thread.join();
  if (service_failure) std::rethrow_exception(service_failure);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace knap
