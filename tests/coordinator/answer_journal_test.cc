#include "coordinator/cli/answer_journal.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace knap {
namespace {

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

}  // namespace
}  // namespace knap
