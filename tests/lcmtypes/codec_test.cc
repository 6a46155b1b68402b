#include "lcmtypes/wire/codec.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include "knap/preflight_t.hpp"
#include "lcmtypes/wire/content_id.h"

namespace knap {
namespace {

const RunKey kKey;

rollout_request_t MakeRequest(std::size_t assignments, std::size_t values, std::size_t acknowledged) {
  rollout_request_t request{};
  for (std::size_t k = 0; k < assignments; ++k) {
    assignment_t assignment{};
    assignment.theta_size = static_cast<std::int32_t>(values);
    for (std::size_t i = 0; i < values; ++i) assignment.values.push_back(0.1 * static_cast<double>(i));
    for (std::size_t i = 0; i < 32; ++i) assignment.id[i] = static_cast<std::uint8_t>(i + k);
    request.assignments.push_back(assignment);
  }
  request.acknowledged.assign(32 * acknowledged, 7);
  return request;
}

rollout_result_t MakeResult(std::size_t values, const std::string& error) {
  rollout_result_t result{};
  result.loss = -0.0;
  result.gradient_size = static_cast<std::int32_t>(values);
  result.values.assign(values, std::numeric_limits<double>::quiet_NaN());
  result.worker = "worker-1";
  result.error = error;
  return result;
}

template <typename T>
T MakeFull();
template <>
rollout_request_t MakeFull() {
  return MakeRequest(1, kValuesPerPart, kAcknowledgementsPerRequest);
}
template <>
rollout_result_t MakeFull() {
  rollout_result_t result = MakeResult(kValuesPerPart, "");
  result.worker = std::string(kMaxNameLength, 'w');
  result.distrust = std::string(kMaxReasonLength, 'd');
  return result;
}
template <>
worker_status_t MakeFull() {
  worker_status_t status{};
  status.queue.assign(32 * kMaxQueue, 1);
  status.name = status.engine = std::string(kMaxNameLength, 'n');
  status.build = std::string(kMaxBuildLength, 'b');
  status.host = std::string(kMaxHostLength, 'h');
  status.reason = std::string(kMaxReasonLength, 'r');
  return status;
}
template <>
run_status_t MakeFull() {
  run_status_t status{};
  status.theta.assign(kValuesPerPart, 1.0);
  status.scenario = std::string(kMaxHostLength, 's');
  status.method = std::string(kMaxNameLength, 'm');
  return status;
}
template <>
scenario_t MakeFull() {
  scenario_t piece{};
  piece.data.assign(kBundleChunkSize, 3);
  return piece;
}
template <>
control_t MakeFull() {
  control_t control{};
  control.ids.assign(32 * kIdsPerControl, 4);
  return control;
}

// Overwrites bytes and makes the digest right again: what a malicious holder of the key could send.
void Forge(std::vector<std::uint8_t>* bytes) {
  const RunKey::Digest digest = kKey.CalcDigest(bytes->data(), bytes->size());
  std::copy(digest.begin(), digest.end(), bytes->end() - static_cast<std::ptrdiff_t>(digest.size()));
}

template <typename T>
Refusal FindRefusal(const std::vector<std::uint8_t>& bytes, const RunKey& key = kKey) {
  Refusal refusal = Refusal::kNone;
  Open<T>(bytes.data(), bytes.size(), key, &refusal);
  return refusal;
}

template <typename T>
class CodecTest : public ::testing::Test {};
using AllMessages =
    ::testing::Types<rollout_request_t, rollout_result_t, worker_status_t, run_status_t, scenario_t, control_t>;
TYPED_TEST_SUITE(CodecTest, AllMessages);

TYPED_TEST(CodecTest, LargestMessageFitsAndComesBack) {
  const std::vector<std::uint8_t> bytes = Seal(MakeFull<TypeParam>(), kKey);
  EXPECT_LE(bytes.size(), kMaxMessageSize);
  Refusal refusal = Refusal::kCorrupt;
  const auto message = Open<TypeParam>(bytes.data(), bytes.size(), kKey, &refusal);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(refusal, Refusal::kNone);
  EXPECT_EQ(Seal(*message, kKey), bytes);
}

TYPED_TEST(CodecTest, EmptyMessageComesBack) {
  const std::vector<std::uint8_t> bytes = Seal(TypeParam{}, kKey);
  EXPECT_EQ(FindRefusal<TypeParam>(bytes), Refusal::kNone);
}

TYPED_TEST(CodecTest, EveryFlippedBitIsRefused) {
  const std::vector<std::uint8_t> bytes = Seal(MakeFull<TypeParam>(), kKey);
  for (std::size_t i = 0; i < 8 * bytes.size(); ++i) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[i / 8] ^= static_cast<std::uint8_t>(1 << (i % 8));
    ASSERT_EQ(FindRefusal<TypeParam>(damaged), i < 64 ? Refusal::kForeign : Refusal::kCorrupt) << "bit " << i;
  }
}

TYPED_TEST(CodecTest, EveryTruncationIsRefusedEvenWithARightDigest) {
  const std::vector<std::uint8_t> bytes = Seal(MakeFull<TypeParam>(), kKey);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_NE(FindRefusal<TypeParam>(cut), Refusal::kNone) << size;
    if (size < 24) continue;
    Forge(&cut);
    ASSERT_EQ(FindRefusal<TypeParam>(cut), Refusal::kMalformed) << size;
  }
}

TYPED_TEST(CodecTest, TrailingBytesAreRefused) {
  std::vector<std::uint8_t> bytes = Seal(TypeParam{}, kKey);
  bytes.push_back(0);
  Forge(&bytes);
  EXPECT_EQ(FindRefusal<TypeParam>(bytes), Refusal::kMalformed);
}

TYPED_TEST(CodecTest, AnotherKeyIsRefused) {
  const std::vector<std::uint8_t> bytes = Seal(MakeFull<TypeParam>(), RunKey::MakeRandom());
  EXPECT_EQ(FindRefusal<TypeParam>(bytes), Refusal::kCorrupt);
}

// Every aligned group of four bytes becomes a huge or negative number in turn. Whatever the field is, Open must neither
// crash nor allocate by it: lengths are refused, other fields are read as they are.
TYPED_TEST(CodecTest, HostileNumbersAnywhereAreSurvived) {
  const std::vector<std::uint8_t> bytes = Seal(MakeFull<TypeParam>(), kKey);
  int refused = 0;
  for (std::size_t i = 8; i + 20 <= bytes.size(); ++i) {
    for (const std::uint8_t top : {0x7f, 0xff}) {
      std::vector<std::uint8_t> hostile = bytes;
      hostile[i] = top;
      hostile[i + 1] = hostile[i + 2] = hostile[i + 3] = 0xff;
      Forge(&hostile);
      Refusal refusal = Refusal::kNone;
      const auto message = Open<TypeParam>(hostile.data(), hostile.size(), kKey, &refusal);
      ASSERT_TRUE(message.has_value() || refusal == Refusal::kMalformed);
      refused += message.has_value() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 0);
}

TYPED_TEST(CodecTest, RandomBytesAreRefused) {
  rc::check([](const std::vector<std::uint8_t>& bytes) { RC_ASSERT(FindRefusal<TypeParam>(bytes) != Refusal::kNone); });
}

TEST(CodecTest, TypesAreNotTakenForEachOther) {
  EXPECT_EQ(FindRefusal<rollout_result_t>(Seal(MakeFull<rollout_request_t>(), kKey)), Refusal::kForeign);
}

TEST(CodecTest, DoublesKeepTheirBits) {
  const std::vector<std::uint8_t> bytes = Seal(MakeResult(1, ""), kKey);
  const auto result = Open<rollout_result_t>(bytes.data(), bytes.size(), kKey, nullptr);
  ASSERT_TRUE(result.has_value());
  EXPECT_TRUE(std::signbit(result->loss));
  EXPECT_TRUE(std::isnan(result->values[0]));
}

TEST(CodecTest, CountsComeFromTheVectors) {
  rollout_request_t request = MakeRequest(2, 3, 1);
  request.assignment_count = 9;
  request.assignments[1].value_count = 90;
  request.acknowledged_size = -5;
  const std::vector<std::uint8_t> bytes = Seal(request, kKey);
  const auto opened = Open<rollout_request_t>(bytes.data(), bytes.size(), kKey, nullptr);
  ASSERT_TRUE(opened.has_value());
  ASSERT_EQ(opened->assignments.size(), 2u);
  EXPECT_EQ(opened->assignments[1].values.size(), 3u);
  EXPECT_EQ(opened->acknowledged.size(), 32u);
}

TEST(CodecTest, OwnMessagesBeyondTheLimitsAreDefects) {
  EXPECT_THROW(Seal(MakeRequest(1, 200, 0), kKey), std::logic_error);
}

// Puts `hostile` where a message has `innocent`, of the same length, and makes the digest right: a worker of another
// make, whose host has an odd name.
template <typename T>
T OpenWith(const T& message, const std::string& innocent, const std::string& hostile) {
  std::vector<std::uint8_t> bytes = Seal(message, kKey);
  const auto found = std::search(bytes.begin(), bytes.end(), innocent.begin(), innocent.end());
  EXPECT_NE(found, bytes.end());
  std::copy(hostile.begin(), hostile.end(), found);
  Forge(&bytes);
  const auto opened = Open<T>(bytes.data(), bytes.size(), kKey, nullptr);
  EXPECT_TRUE(opened.has_value());
  return opened.value_or(T{});
}

TEST(CodecTest, TextsOfOthersAreMadeClean) {
  const std::string innocent = "12345678", hostile = "\x1b[2J\xff\xc3\n\xe6", clean = " [2J?? ?";
  worker_status_t status{};
  status.host = innocent;
  EXPECT_EQ(OpenWith(status, innocent, hostile).host, clean);
  status = worker_status_t{};
  status.build = innocent;
  EXPECT_EQ(OpenWith(status, innocent, hostile).build, clean);
  status = worker_status_t{};
  status.reason = innocent;
  EXPECT_EQ(OpenWith(status, innocent, hostile).reason, clean);
  EXPECT_EQ(OpenWith(MakeResult(0, innocent), innocent, hostile).error, clean);
  rollout_result_t result = MakeResult(0, "");
  result.distrust = innocent;
  EXPECT_EQ(OpenWith(result, innocent, hostile).distrust, clean);
  run_status_t run{};
  run.scenario = innocent;
  EXPECT_EQ(OpenWith(run, innocent, hostile).scenario, clean);
  control_t control{};
  control.worker = innocent;
  EXPECT_EQ(OpenWith(control, innocent, hostile).worker, clean);
}

TEST(CodecTest, OurOwnTextsAreMadeCleanAndCutAtWholeCharacters) {
  std::string error(kMaxErrorLength - 1, 'e');
  error += "\xc3\xa4";  // one byte too many
  const std::vector<std::uint8_t> bytes = Seal(MakeResult(0, "\x1b" + error), kKey);
  const auto opened = Open<rollout_result_t>(bytes.data(), bytes.size(), kKey, nullptr);
  ASSERT_TRUE(opened.has_value());
  EXPECT_EQ(opened->error, " " + std::string(kMaxErrorLength - 1, 'e'));
}

TEST(MessageTypesTest, FingerprintsDiffer) {
  const std::set<std::int64_t> fingerprints = {
      rollout_request_t::getHash(), rollout_result_t::getHash(), worker_status_t::getHash(), run_status_t::getHash(),
      scenario_t::getHash(),        control_t::getHash(),        assignment_t::getHash(),    preflight_t::getHash()};
  EXPECT_EQ(fingerprints.size(), 8u);
}

// lcm-gen takes any unknown word for a message type and includes a header for it, with exit code 0.
TEST(MessageTypesTest, NoUnknownTypeSlippedIn) {
  for (const std::string name : {"assignment_t", "control_t", "preflight_t", "rollout_request_t", "rollout_result_t",
                                 "run_status_t", "scenario_t", "worker_status_t"}) {
    std::ifstream file(std::string(KNAP_GENERATED_MESSAGES) + "/knap/" + name + ".hpp");
    ASSERT_TRUE(file) << name;
    std::stringstream text;
    text << file.rdbuf();
    std::string includes = text.str();
    const std::string known = "#include \"knap/assignment_t.hpp\"";
    if (name == "rollout_request_t") includes.erase(includes.find(known), known.size());
    EXPECT_EQ(includes.find("#include \"knap/"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace knap
