// Content ids, scenario bundles, run keys and value parts.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/content_id.h"
#include "lcmtypes/wire/run_key.h"
#include "lcmtypes/wire/scenario_bundle.h"
#include "lcmtypes/wire/value_parts.h"

namespace knap {
namespace {

TEST(ContentIdTest, Sha256OfAbc) {
  // FIPS 180-4, example 1
  EXPECT_EQ(FormatHex(CalcSha256("abc")), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(ContentIdTest, RequestIdIsTheDocumentedHash) {
  // Made independently, with Python's struct and hashlib, from the description in docs/protocol.md
  const std::vector<double> theta = {1.0, -2.5};
  const std::vector<double> controls = {0.5, -1.0, 2.0};
  const std::vector<double> variation = {0.125};
  EXPECT_EQ(FormatHex(CalcRequestId({"knap", CalcSha256("abc"), theta, {}, {}, variation, true})),
            "ffe7ca1c4dbe6b69d661cdbaaa8886a3244df28df3001cc949c591d3b390b295");
  EXPECT_EQ(FormatHex(CalcRequestId({"knap", CalcSha256("abc"), theta, controls, {}, variation, true})),
            "88cdd15bdf34e253160fd00e269bea5d1d1da77f21f335f7a6b16aedb56842b0");
  const std::vector<double> nodes = {1.0, -2.0};
  EXPECT_EQ(FormatHex(CalcRequestId({"knap", CalcSha256("abc"), theta, {}, {}, variation, false, nodes})),
            "2da683256c53696c976e11cd1213fd499735eb7a7a984c233f7d53efb472f474");
}

TEST(ContentIdTest, EveryIngredientCounts) {
  const std::vector<double> a = {1.0, 2.0};
  const std::vector<double> b = {1.0, 3.0};
  const std::vector<double> zero = {0.0, 2.0};
  const std::vector<double> minus_zero = {-0.0, 2.0};
  const ContentId scenario{};
  const std::vector<ContentId> ids = {
      CalcRequestId({"knap", scenario, a, {}, {}, a, true}),
      CalcRequestId({"knaq", scenario, a, {}, {}, a, true}),
      CalcRequestId({"knap", CalcSha256(""), a, {}, {}, a, true}),
      CalcRequestId({"knap", scenario, b, {}, {}, a, true}),
      CalcRequestId({"knap", scenario, a, {}, a, a, true}),
      CalcRequestId({"knap", scenario, a, {}, {}, b, true}),
      CalcRequestId({"knap", scenario, a, {}, {}, a, false}),
      CalcRequestId({"knap", scenario, a, {}, a, {}, true}),
      CalcRequestId({"knap", scenario, zero, {}, {}, a, true}),
      CalcRequestId({"knap", scenario, minus_zero, {}, {}, a, true}),
      CalcRequestId({"knap", scenario, a, a, {}, a, true}),
      CalcRequestId({"knap", scenario, a, b, {}, a, true}),
      CalcRequestId({"knap", scenario, a, a, {}, {}, true}),
      CalcRequestId({"knap", scenario, {}, a, {}, a, true}),
      CalcRequestId({"knap", scenario, a, {}, {}, a, true, a}),
      CalcRequestId({"knap", scenario, a, {}, {}, a, true, b}),
  };
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(ids[i], ids[j]) << i << " " << j;
  }
}

TEST(ScenarioBundleTest, ComesBack) {
  const std::map<std::string, std::string> files = {
      {"scenario.yaml", "a: 1\n"}, {"mesh.stl", std::string("\0\1\2", 3)}, {"empty", ""}};
  EXPECT_EQ(DecodeBundle(EncodeBundle(files)), files);
}

TEST(ScenarioBundleTest, DamageIsRefused) {
  const std::string bundle = EncodeBundle({{"a", "xyz"}, {"b", "uvw"}});
  for (std::size_t size = 0; size < bundle.size(); ++size) {
    // A cut at the boundary between two files is a bundle of its own; the hash tells that it is another one.
    if (size == 16 || size == 16 + 8 + 1 + 8 + 3) continue;
    EXPECT_THROW(DecodeBundle(bundle.substr(0, size)), std::runtime_error) << size;
  }
  std::string huge = bundle;
  huge[16 + 7] = '\x7f';
  EXPECT_THROW(DecodeBundle(huge), std::runtime_error);
  std::string unordered = bundle;
  unordered[16 + 8] = 'c';
  EXPECT_THROW(DecodeBundle(unordered), std::runtime_error);
}

TEST(ScenarioBundleTest, TooLargeIsRefused) {
  EXPECT_THROW(EncodeBundle({{"mesh", std::string(static_cast<std::size_t>(kMaxBundleSize), 'x')}}),
               std::runtime_error);
}

class RunKeyFileTest : public ::testing::Test {
 protected:
  RunKeyFileTest() { std::filesystem::create_directories(directory_); }
  ~RunKeyFileTest() override { std::filesystem::remove_all(directory_); }
  std::filesystem::path directory_ = std::filesystem::temp_directory_path() / ("knap-key-" + std::to_string(getpid()));
  std::string path_ = directory_ / "key";
};

TEST_F(RunKeyFileTest, WritesPrivatelyAndReadsBack) {
  const RunKey key = RunKey::MakeRandom();
  key.WriteFile(path_);
  struct stat info {};
  ASSERT_EQ(stat(path_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  const std::string message(40, 'm');
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(message.data());
  EXPECT_EQ(RunKey::ReadFile(path_).CalcDigest(bytes, message.size()), key.CalcDigest(bytes, message.size()));
  EXPECT_NE(RunKey().CalcDigest(bytes, message.size()), key.CalcDigest(bytes, message.size()));
  EXPECT_THROW(key.WriteFile(path_), std::runtime_error);  // never overwrites
}

TEST_F(RunKeyFileTest, RefusesWhatOthersCanReadAndWrongLengths) {
  RunKey::MakeRandom().WriteFile(path_);
  std::filesystem::permissions(path_, std::filesystem::perms(0640));
  EXPECT_THROW(RunKey::ReadFile(path_), std::runtime_error);
  std::filesystem::permissions(path_, std::filesystem::perms(0600));
  EXPECT_NO_THROW(RunKey::ReadFile(path_));
  std::ofstream(path_, std::ios::app) << "x";
  EXPECT_THROW(RunKey::ReadFile(path_), std::runtime_error);
  EXPECT_THROW(RunKey::ReadFile(path_ + "-missing"), std::runtime_error);
}

TEST(RunKeyTest, DigestIsTruncatedHmacSha256) {
  // Made independently: Python's hmac.new(bytes(range(32)), b"knap" + bytes(16), hashlib.sha256)
  std::array<std::uint8_t, 32> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  const std::string message = std::string("knap") + std::string(16, '\xff');  // the digest's own bytes count as zeros
  const RunKey::Digest digest =
      RunKey(bytes).CalcDigest(reinterpret_cast<const std::uint8_t*>(message.data()), message.size());
  std::string hex;
  for (const std::uint8_t byte : digest) {
    hex.push_back("0123456789abcdef"[byte >> 4]);
    hex.push_back("0123456789abcdef"[byte & 15]);
  }
  EXPECT_EQ(hex, "b9f6096e4d0fa90ad7f7b145bcfe016a");
}

RC_GTEST_PROP(ValuePartsTest, PartsInAnyOrderMakeTheWhole, ()) {
  const auto size = static_cast<std::size_t>(*rc::gen::inRange(0, 500));
  std::vector<double> values(size);
  for (std::size_t i = 0; i < size; ++i) values[i] = static_cast<double>(i) + 0.5;
  struct Part {
    std::int32_t first;
    std::vector<double> values;
  };
  std::vector<Part> parts;
  ForEachPart(values, [&](std::int32_t first, std::span<const double> part) {
    RC_ASSERT(part.size() <= static_cast<std::size_t>(kValuesPerPart));
    parts.push_back({first, {part.begin(), part.end()}});
  });
  const std::int32_t total = static_cast<std::int32_t>(size);
  ValueAssembly assembly(total);
  const auto order = *rc::gen::container<std::vector<std::size_t>>(60, rc::gen::inRange<std::size_t>(0, parts.size()));
  std::set<std::size_t> seen;
  for (const std::size_t i : order) {
    RC_ASSERT(assembly.Add(total, parts[i].first, parts[i].values));
    seen.insert(i);
    RC_ASSERT(assembly.IsComplete() == (seen.size() == parts.size()));
  }
  for (const Part& part : parts) RC_ASSERT(assembly.Add(total, part.first, part.values));
  RC_ASSERT(assembly.IsComplete());
  RC_ASSERT(assembly.values() == values);
}

TEST(ValuePartsTest, ImpossiblePartsAreRefused) {
  ValueAssembly assembly(200);
  const std::vector<double> part(kValuesPerPart, 1.0);
  EXPECT_FALSE(assembly.Add(201, 0, part));
  EXPECT_FALSE(assembly.Add(-1, 0, part));
  EXPECT_FALSE(assembly.Add(200, 1, part));
  EXPECT_FALSE(assembly.Add(200, -kValuesPerPart, part));
  EXPECT_FALSE(assembly.Add(200, 2 * kValuesPerPart, part));  // the last part has 8 values
  EXPECT_FALSE(assembly.Add(200, 3 * kValuesPerPart, part));
  EXPECT_FALSE(assembly.Add(200, 0, {1.0}));
  EXPECT_FALSE(assembly.IsComplete());
}

TEST(NameTest, NamesAreSafeInChannels) {
  EXPECT_TRUE(IsName("local-1_B"));
  for (const char* bad : {"", "a.b", "a b", "a/b", "ä", ".*"}) EXPECT_FALSE(IsName(bad)) << bad;
  EXPECT_FALSE(IsName(std::string(41, 'a')));
}

}  // namespace
}  // namespace knap
