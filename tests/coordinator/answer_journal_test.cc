#include "coordinator/run/answer_journal.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/coordinator/simulated_cluster.h"

namespace knap {
namespace answer_journal_test {

JournaledAnswer MakeAnswer(std::uint8_t number) {
  JournaledAnswer answer;
  answer.id.fill(number);
  answer.outcome.loss = 0.1 * number;
  answer.outcome.success = number % 2 == 1;
  for (std::uint8_t i = 0; i < number; ++i) answer.outcome.gradient.push_back(-1.0 / (3.0 + i));
  answer.outcome.certificate = {true, number % 3 == 0, number % 2 == 0, 1e-11 * number, number, 2 * number};
  answer.outcome.steps = 1000 + number;
  answer.outcome.forward_s = 0.25;
  answer.outcome.gradient_s = 0.5;
  return answer;
}

void ExpectSame(const JournaledAnswer& a, const JournaledAnswer& b) {
  EXPECT_EQ(a.id, b.id);
  // As bits: a NaN is to come back as it was.
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a.outcome.loss), std::bit_cast<std::uint64_t>(b.outcome.loss));
  EXPECT_EQ(a.outcome.success, b.outcome.success);
  EXPECT_EQ(a.outcome.gradient, b.outcome.gradient);
  EXPECT_EQ(a.outcome.certificate.finite, b.outcome.certificate.finite);
  EXPECT_EQ(a.outcome.certificate.converged, b.outcome.certificate.converged);
  EXPECT_EQ(a.outcome.certificate.gradient_reliable, b.outcome.certificate.gradient_reliable);
  EXPECT_EQ(a.outcome.certificate.worst_residual, b.outcome.certificate.worst_residual);
  EXPECT_EQ(a.outcome.certificate.subdivided_steps, b.outcome.certificate.subdivided_steps);
  EXPECT_EQ(a.outcome.certificate.contact_onsets, b.outcome.certificate.contact_onsets);
  EXPECT_EQ(a.outcome.certificate.penetration, b.outcome.certificate.penetration);
  EXPECT_EQ(a.outcome.certificate.largest_force, b.outcome.certificate.largest_force);
  EXPECT_EQ(a.outcome.certificate.distrust, b.outcome.certificate.distrust);
  EXPECT_EQ(a.outcome.steps, b.outcome.steps);
  EXPECT_EQ(a.outcome.forward_s, b.outcome.forward_s);
  EXPECT_EQ(a.outcome.gradient_s, b.outcome.gradient_s);
}

TEST(AnswerJournalTest, AnswersComeBackToTheLastBit) {
  std::vector<JournaledAnswer> answers = {MakeAnswer(0), MakeAnswer(1), MakeAnswer(2), MakeAnswer(3)};
  answers[1].outcome.loss = std::numeric_limits<double>::quiet_NaN();
  answers[2].outcome.loss = -std::numeric_limits<double>::infinity();
  answers[3].outcome.gradient[0] = -0.0;
  const std::vector<JournaledAnswer> read = DecodeAnswers(EncodeAnswers(answers));
  ASSERT_EQ(read.size(), answers.size());
  for (std::size_t i = 0; i < read.size(); ++i) ExpectSame(read[i], answers[i]);
  EXPECT_TRUE(DecodeAnswers("").empty());
}

TEST(AnswerJournalTest, CutRecordsAreRefused) {
  const std::string bytes = EncodeAnswers(std::vector<JournaledAnswer>{MakeAnswer(3)});
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    EXPECT_THROW(DecodeAnswers(bytes.substr(0, size)), std::runtime_error) << size;
  }
}

// More than the dispatcher's memory holds, and all of them known without a single worker.
TEST(AnswerJournalTest, NothingInAJournalIsAskedForAgain) {
  SimulatedCluster cluster(9);
  const std::size_t count = SimulatedCluster::MakeOptions().max_answers + 1000;
  std::vector<RolloutQuery> queries(count);
  std::vector<JournaledAnswer> answers(count);
  for (std::size_t i = 0; i < count; ++i) {
    queries[i].theta = {0.25 * static_cast<double>(i), 0.0, 0.0, 0.0};
    answers[i].id = cluster.dispatcher->CalcId(queries[i]);
    answers[i].outcome.loss = static_cast<double>(i);
  }
  const TemporaryFolder folder;
  Journal journal = Journal::Create(folder / "journal", {});
  JournaledService service(cluster.dispatcher.get(), &journal, {EncodeAnswers(answers)});
  EXPECT_EQ(service.from_journal(), static_cast<std::int64_t>(count));
  std::vector<RolloutOutcome> outcomes = service.Evaluate(queries);  // throws NoWorkers if it asks
  ASSERT_EQ(outcomes.size(), count);
  for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(outcomes[i].loss, static_cast<double>(i));
  EXPECT_EQ(service.answered(), static_cast<std::int64_t>(count));
}

// Known and unknown queries in one call: each answer at its place, and only the unknown ones go to the cluster.
TEST(AnswerJournalTest, KnownAndNewAnswersComeInTheOrderOfTheQueries) {
  SimulatedCluster cluster(10);
  cluster.StartWorker("a", 20'000);
  const std::vector<RolloutQuery> queries = SimulatedCluster::MakeQueries(6);
  JournaledAnswer known;
  known.id = cluster.dispatcher->CalcId(queries[3]);
  known.outcome.loss = 42.0;
  const TemporaryFolder folder;
  Journal journal = Journal::Create(folder / "journal", {});
  JournaledService service(cluster.dispatcher.get(), &journal, {EncodeAnswers({&known, 1})});
  const std::vector<RolloutOutcome> outcomes = service.Evaluate(queries);
  const std::vector<EngineAnswer> expected = cluster.CalcExpected(queries);
  for (std::size_t i = 0; i < queries.size(); ++i) EXPECT_EQ(outcomes[i].loss, i == 3 ? 42.0 : expected[i].loss) << i;
  EXPECT_EQ(cluster.dispatcher->counters().computed, 5);
  std::size_t journaled = 0;
  for (const std::string& payload : Journal::Read(folder / "journal")) journaled += DecodeAnswers(payload).size();
  EXPECT_EQ(journaled, 5u);
}

}  // namespace answer_journal_test
}  // namespace knap
