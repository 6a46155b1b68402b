// A request's states, and that every way in which a book could disagree with itself is noticed.
#include "coordinator/dispatch/request_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/coordinator/request_book.h"

namespace knap {
namespace request_table_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kAlice = 1, kBob = 2;

ContentId MakeNumberedId(std::uint8_t number) {
  ContentId id{};
  id[0] = number;
  return id;
}
const ContentId kA = MakeNumberedId(1), kB = MakeNumberedId(2), kC = MakeNumberedId(3);

class RequestTableTest : public ::testing::Test {
 protected:
  RequestTableTest() {
    for (const ContentId& id : {kA, kB, kC}) table_.Ask(id, {}, &outcome_, 10);
  }
  ~RequestTableTest() override { EXPECT_EQ(FindDefect(table_.book()), ""); }

  RolloutOutcome outcome_;
  RequestTable table_;
};

TEST_F(RequestTableTest, AskedTwiceItIsOneRequestWithTwoSlots) {
  RolloutOutcome another;
  EXPECT_FALSE(table_.Ask(kA, {}, &another, 20));
  EXPECT_THAT(table_.book().queue, ElementsAre(kA, kB, kC));
  EXPECT_THAT(table_.FindOpen(kA)->slots, ElementsAre(&outcome_, &another));
}

TEST_F(RequestTableTest, WhatALostWorkerHeldComesFirstInItsOrder) {
  for (const ContentId& id : {kA, kB}) table_.Give(id, kAlice, 20);
  EXPECT_THAT(table_.book().queue, ElementsAre(kC));
  EXPECT_EQ(table_.FindOpen(kA)->state, RequestState::kLeased);
  table_.TakeBack(kAlice);
  EXPECT_THAT(table_.book().queue, ElementsAre(kA, kB, kC));
  EXPECT_EQ(table_.FindOpen(kA)->attempts, 1);
  EXPECT_TRUE(table_.book().holdings.empty());
}

TEST_F(RequestTableTest, ACopyKeepsItLeasedWhenOneHolderIsLost) {
  table_.Give(kA, kAlice, 20);
  table_.Give(kA, kBob, 30);
  table_.TakeBack(kAlice);
  EXPECT_EQ(table_.FindOpen(kA)->state, RequestState::kLeased);
  EXPECT_EQ(table_.FindLease(kA, kBob)->sent_us, 30);
  EXPECT_EQ(table_.FindLease(kA, kAlice), nullptr);
}

TEST_F(RequestTableTest, IsSentOnceUntilSentAgain) {
  table_.Give(kA, kAlice, 20);
  EXPECT_THAT(table_.TakeUnsent(kAlice), ElementsAre(kA));
  EXPECT_TRUE(table_.TakeUnsent(kAlice).empty());
  table_.Resend(kA, kAlice, 40);
  table_.Resend(kA, kAlice, 50);
  EXPECT_EQ(table_.FindLease(kA, kAlice)->sent_us, 50);
  EXPECT_THAT(table_.TakeUnsent(kAlice), ElementsAre(kA));
}

TEST_F(RequestTableTest, WhatIsTakenAwayBeforeItWasSentIsNotSent) {
  table_.Give(kA, kAlice, 20);
  table_.Move(kA, kAlice, kBob, 30);
  EXPECT_TRUE(table_.TakeUnsent(kAlice).empty());
  EXPECT_THAT(table_.TakeUnsent(kBob), ElementsAre(kA));
  EXPECT_EQ(table_.FindOpen(kA)->attempts, 2);
}

TEST_F(RequestTableTest, AnsweredWhileItWaitsOrIsHeldItIsForgottenWhenDurable) {
  table_.Give(kA, kAlice, 20);
  for (const ContentId& id : {kA, kB}) {
    const Request before = table_.Answer(id);
    EXPECT_EQ(before.leases.size(), id == kA ? 1u : 0u);
    EXPECT_THAT(before.slots, ElementsAre(&outcome_));
    table_.Owe({id, kAlice, "alice"});
  }
  EXPECT_EQ(table_.open(), 1u);
  EXPECT_EQ(table_.FindOpen(kA), nullptr);
  EXPECT_THAT(table_.book().queue, ElementsAre(kC));
  EXPECT_TRUE(table_.GetHolding(kAlice).ids.empty());
  EXPECT_EQ(FindDefect(table_.book()), "");
  EXPECT_EQ(table_.TakeOwed().size(), 2u);
  EXPECT_EQ(table_.book().requests.size(), 1u);
}

TEST_F(RequestTableTest, AskedAgainWhileItsAnswerIsOwedItIsOpenAgain) {
  table_.Answer(kA);
  table_.Owe({kA, kAlice, "alice"});
  EXPECT_TRUE(table_.Ask(kA, {}, &outcome_, 30));
  EXPECT_EQ(table_.open(), 3u);
  table_.TakeOwed();
  EXPECT_NE(table_.FindOpen(kA), nullptr);
}

TEST_F(RequestTableTest, DroppedOnesLeaveNothingBehind) {
  for (const ContentId& id : {kA, kB}) table_.Give(id, kAlice, 20);
  table_.Drop(kA);
  EXPECT_THAT(table_.GetHolding(kAlice).ids, ElementsAre(kB));
  table_.Answer(kB);
  table_.Owe({kB, kAlice, "alice"});
  table_.DropOpen();
  EXPECT_EQ(table_.open(), 0u);
  EXPECT_EQ(table_.book().owed.size(), 1u);  // its answer is durable or will be, whatever becomes of the others
}

TEST_F(RequestTableTest, DeathsFromInsideAreChargedToWhatRanOrWasAlone) {
  for (int death = 1; death <= 3; ++death) {
    table_.Give(kA, kAlice, 20);
    if (death == 1) table_.Give(kB, kAlice, 20);
    const std::vector<ContentId> poison = table_.ChargeDeath(kAlice, death == 1 ? kA : ContentId{});
    EXPECT_EQ(poison.size(), death == 3 ? 1u : 0u);
    EXPECT_TRUE(table_.FindOpen(kA)->suspect);
    EXPECT_TRUE(table_.FindOpen(kB)->suspect);
    table_.TakeBack(kAlice);
  }
  EXPECT_EQ(table_.FindOpen(kA)->fatal_attempts, 3);
  EXPECT_EQ(table_.FindOpen(kB)->fatal_attempts, 0);
  table_.Give(kA, kBob, 30);
  EXPECT_TRUE(table_.GetHolding(kBob).alone);
}

TEST_F(RequestTableTest, ALackConcernsWhatRanOrElseAllThatWasHeld) {
  for (const ContentId& id : {kA, kB}) table_.Give(id, kAlice, 20);
  table_.NoteLack(kAlice, kB, "alice");
  EXPECT_TRUE(table_.FindOpen(kA)->lacking.empty());
  EXPECT_THAT(table_.FindOpen(kB)->lacking, ElementsAre("alice"));
  table_.NoteLack(kAlice, ContentId{}, "alice");
  EXPECT_THAT(table_.FindOpen(kA)->lacking, ElementsAre("alice"));
  EXPECT_TRUE(table_.FindOpen(kC)->lacking.empty());
}

TEST_F(RequestTableTest, ThreeDifferentWorkersStuckAreEnough) {
  EXPECT_FALSE(table_.ChargeStall(kA, 1));
  EXPECT_FALSE(table_.ChargeStall(kA, 2));
  EXPECT_FALSE(table_.ChargeStall(kA, 2));
  EXPECT_TRUE(table_.ChargeStall(kA, 3));
}

// Thousands of random steps, legal ones, and the book agrees with itself after each.
TEST(RequestTableRandomTest, AgreesWithItselfAfterEveryStep) {
  std::mt19937 random(4);
  const auto draw = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
  RequestTable table;
  RolloutOutcome outcome;
  int answered = 0;
  for (int step = 0; step < 20000; ++step) {
    const ContentId id = MakeNumberedId(static_cast<std::uint8_t>(draw(12)));
    const std::int64_t worker = 1 + draw(3), another = 1 + worker % 3;
    const Request* open = table.FindOpen(id);
    const bool held = table.FindLease(id, worker) != nullptr;
    const bool free = open != nullptr && open->leases.size() < 2 && !held && !table.GetHolding(worker).alone &&
                      (!open->suspect || table.GetHolding(worker).ids.empty());
    switch (draw(9)) {
      case 0:
        table.Ask(id, {}, &outcome, step);
        break;
      case 1:
      case 2:
        if (free) table.Give(id, worker, step);
        break;
      case 3:
        if (held && table.GetHolding(another).ids.empty()) table.Move(id, worker, another, step);
        break;
      case 4:
        if (held) table.Resend(id, worker, step);
        break;
      case 5:
        table.TakeUnsent(worker);
        break;
      case 6:
        if (draw(4) == 0 && table.GetHolding(worker).ids.size() == 1) table.ChargeDeath(worker, id);
        table.TakeBack(worker);
        break;
      case 7:
        if (open == nullptr) break;
        ++answered;
        table.Answer(id);
        table.Owe({id, worker, "w"});
        break;
      default:
        if (draw(4) == 0) table.TakeOwed();
        if (draw(50) == 0) table.DropOpen();
        break;
    }
    ASSERT_EQ(FindDefect(table.book()), "") << "step " << step;
  }
  EXPECT_GT(answered, 500);
}

struct Damage {
  const char* name;
  std::function<void(RequestBook*)> damage;
  const char* found;
};

class DamagedBookTest : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedBookTest, IsNoticed) {
  RequestTable table;
  RolloutOutcome outcome;
  for (const ContentId& id : {kA, kB, kC}) table.Ask(id, {}, &outcome, 10);
  table.Give(kA, kAlice, 20);
  table.Answer(kB);
  table.Owe({kB, kAlice, "alice"});
  RequestBook book = table.book();
  ASSERT_EQ(FindDefect(book), "");
  GetParam().damage(&book);
  EXPECT_THAT(FindDefect(book), HasSubstr(GetParam().found));
}

INSTANTIATE_TEST_SUITE_P(
    Damages, DamagedBookTest,
    ::testing::Values(
        Damage{"LeftTheQueue", [](RequestBook* b) { b->queue.clear(); }, "0 times in the queue"},
        Damage{"QueuedTwice", [](RequestBook* b) { b->queue.push_back(kC); }, "2 times in the queue"},
        Damage{"LeasedAndQueued", [](RequestBook* b) { b->queue.push_back(kA); }, "does not wait"},
        Damage{"AnsweredAndQueued", [](RequestBook* b) { b->queue.push_back(kB); }, "does not wait"},
        Damage{"QueueOfNothing", [](RequestBook* b) { b->queue.push_back(MakeNumberedId(9)); }, "in the queue alone"},
        Damage{"LeasedToNobody", [](RequestBook* b) { b->requests[kA].leases.clear(); }, "0 holders"},
        Damage{"HolderDoesNotKnow", [](RequestBook* b) { b->holdings.clear(); }, "does not hold it"},
        Damage{"HoldsTheAnswered", [](RequestBook* b) { b->holdings[kAlice].ids.push_back(kB); }, "not leased to it"},
        Damage{"ThreeHolders",
               [](RequestBook* b) {
                 for (const std::int64_t worker : {kBob, kBob + 1}) {
                   b->requests[kA].leases.push_back({worker, 0, false});
                   b->holdings[worker].ids.push_back(kA);
                 }
               },
               "held by 3"},
        Damage{"MoreHoldersThanAttempts", [](RequestBook* b) { b->requests[kA].attempts = 0; }, "attempts"},
        Damage{"WantedByNobody", [](RequestBook* b) { b->requests[kC].slots.clear(); }, "wanted by nobody"},
        Damage{"NothingOwed", [](RequestBook* b) { b->owed.clear(); }, "no acknowledgement is owed"},
        Damage{"WronglyCounted", [](RequestBook* b) { b->answered = 0; }, "counted"},
        Damage{"SendsWhatItDoesNotHold", [](RequestBook* b) { b->holdings[kAlice].unsent.push_back(kC); },
               "does not hold"},
        Damage{"ApartWithoutASuspect", [](RequestBook* b) { b->holdings[kAlice].alone = true; }, "no suspect"}),
    [](const auto& damage) { return std::string(damage.param.name); });

}  // namespace request_table_test
}  // namespace knap
