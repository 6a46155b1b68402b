// One rollout service for several callers, each on a thread of its own: the runs of a study share one pool of workers.
//
// Questions are answered in rounds: when every member that has not left waits for an answer, the questions of all of
// them, in the order of the members, become one call of the service. So every run gets one evaluation a round, however
// large the pool and whatever the others ask, and the sequence of calls does not depend on how threads are scheduled.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "coordinator/rollout_service.h"

namespace knap {

class SharedService {
 public:
  // `service` is called by the thread in Serve alone; it must outlive this object.
  SharedService(RolloutService* service, std::size_t members);

  // What member i asks; valid until the member leaves. Its Evaluate blocks until a round has answered it, and throws
  // what the service threw.
  RolloutService& member(std::size_t i) { return members_[i]; }

  // Member i asks nothing more. Must be called once for every member, or Serve never ends.
  void Leave(std::size_t i);

  // Answers rounds until all members have left. When the service throws, so does the Evaluate of every member, from
  // then on; Serve throws the same when all have left.
  void Serve();

 private:
  class Member : public RolloutService {
   public:
    explicit Member(SharedService* shared) : shared_(shared) {}
    std::vector<RolloutOutcome> Evaluate(std::span<const RolloutQuery> queries) override;

   private:
    friend class SharedService;
    SharedService* shared_;
    std::span<const RolloutQuery> queries_;
    std::vector<RolloutOutcome> outcomes_;
    bool waiting_ = false;
    bool left_ = false;
  };

  bool IsRoundReady() const;  // everybody waits or has left

  RolloutService* const service_;
  std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  std::deque<Member> members_;
  std::exception_ptr failure_;
};

// Calls work(i, service of member i) for every member on a thread of its own, and answers their questions with
// `service` until all are done. Throws what the service threw, else what the first of them to fail threw.
void RunTogether(RolloutService* service, std::size_t members,
                 const std::function<void(std::size_t, RolloutService*)>& work);

}  // namespace knap
