#include "coordinator/run_directory/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "coordinator/run_directory/crc32c.h"
#include "coordinator/run_directory/durable_file.h"
#include "coordinator/run_directory/journal_repair.h"
#include "coordinator/run_directory/temporary_folder.h"

namespace knap {
namespace journal_test {

using testing::HasSubstr;

const RunIdentity kIdentity = {{"configuration", "0123456789abcdef0123456789abcdef"}, {"build", "17"}};

// Payloads with every awkward byte: zeros, line ends, an empty one, one that looks like the start of a record.
const std::vector<std::string> kPayloads = {
    std::string("first"),
    std::string(),
    std::string("\0\0\0\0\xff\n\r", 7),
    std::string(60, 'x'),
    std::string("\x05\0\0\0\x01\x02\x03\x04\x05\0\0\0\0\0\0\0", 16),
    std::string("last one"),
};

void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

// The journal of all payloads, and where each record ends (the header's end first).
std::string MakeJournalBytes(const std::filesystem::path& path, std::vector<std::size_t>* ends = nullptr) {
  {
    Journal journal = Journal::Create(path, kIdentity);
    if (ends != nullptr) ends->push_back(std::filesystem::file_size(path));
    for (const std::string& payload : kPayloads) {
      journal.Append(payload);
      if (ends != nullptr) ends->push_back(std::filesystem::file_size(path));
    }
  }
  return ReadFile(path);
}

std::string GetError(const std::filesystem::path& path, const RunIdentity& identity = kIdentity) {
  try {
    Journal::Open(path, identity);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// RFC 3720 §B.4, and the check value of the CRC catalogue.
TEST(Crc32cTest, GivesThePublishedValues) {
  EXPECT_EQ(CalcCrc32c("123456789"), 0xE3069283u);
  EXPECT_EQ(CalcCrc32c(std::string(32, '\0')), 0x8A9136AAu);
  EXPECT_EQ(CalcCrc32c(std::string(32, '\xff')), 0x62A8AB43u);
  std::string rising;
  for (int i = 0; i < 32; ++i) rising.push_back(static_cast<char>(i));
  EXPECT_EQ(CalcCrc32c(rising), 0x46DD794Eu);
  EXPECT_EQ(CalcCrc32c("6789", CalcCrc32c("12345")), 0xE3069283u);
}

TEST(JournalTest, GivesBackWhatWasAppended) {
  const TemporaryFolder folder;
  MakeJournalBytes(folder / "journal");
  for (int round = 0; round < 3; ++round) {
    Journal::Opened opened = Journal::Open(folder / "journal", kIdentity);
    std::vector<std::string> expected = kPayloads;
    for (int i = 0; i < round; ++i) expected.push_back("more " + std::to_string(i));
    EXPECT_EQ(opened.payloads, expected);
    EXPECT_EQ(opened.torn_bytes, 0u);
    opened.journal.Append("more " + std::to_string(round));
  }
}

TEST(JournalTest, TornAtEveryByteKeepsTheWholeRecordsAndGoesOn) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  for (std::size_t size = ends[0]; size <= bytes.size(); ++size) {
    SCOPED_TRACE(size);
    const std::filesystem::path path = folder / "torn";
    WriteBytes(path, bytes.substr(0, size));
    std::size_t whole = 0;
    while (whole < kPayloads.size() && ends[whole + 1] <= size) ++whole;
    std::vector<std::string> expected(kPayloads.begin(), kPayloads.begin() + static_cast<std::ptrdiff_t>(whole));
    {
      Journal::Opened opened = Journal::Open(path, kIdentity);
      ASSERT_EQ(opened.payloads, expected);
      ASSERT_EQ(opened.torn_bytes, size - ends[whole]);
      ASSERT_EQ(Journal::Read(path), expected);  // also while it is in use
      opened.journal.Append("after the crash");
    }
    expected.push_back("after the crash");
    const Journal::Opened again = Journal::Open(path, kIdentity);
    ASSERT_EQ(again.payloads, expected);
    ASSERT_EQ(again.torn_bytes, 0u);
  }
}

TEST(JournalTest, ATornHeaderIsNoJournal) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  for (std::size_t size = 0; size < ends[0]; ++size) {
    WriteBytes(folder / "torn", bytes.substr(0, size));
    EXPECT_THAT(GetError(folder / "torn"), HasSubstr("not a knap journal"));
    EXPECT_EQ(ReadFile(folder / "torn").size(), size);  // and nobody's file is cut
  }
}

// Some file systems leave the new length with zeros behind it.
TEST(JournalTest, ATailOfZerosIsTorn) {
  const TemporaryFolder folder;
  const std::string bytes = MakeJournalBytes(folder / "journal");
  for (const std::size_t zeros : {1u, 16u, 4096u}) {
    WriteBytes(folder / "journal", bytes + std::string(zeros, '\0'));
    const Journal::Opened opened = Journal::Open(folder / "journal", kIdentity);
    EXPECT_EQ(opened.payloads, kPayloads);
    EXPECT_EQ(opened.torn_bytes, zeros);
  }
}

// Whatever bit flips: an error, or, in the last record alone, its loss. Never a wrong payload.
TEST(JournalTest, FlippedAtEveryByteIsNoticed) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  const std::vector<std::string> all_but_last(kPayloads.begin(), kPayloads.end() - 1);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int mask : {0x01, 0x80, 0xff}) {
      SCOPED_TRACE(testing::Message() << "byte " << at << " mask " << mask);
      std::string flipped = bytes;
      flipped[at] = static_cast<char>(flipped[at] ^ mask);
      WriteBytes(folder / "flipped", flipped);
      if (at >= ends[ends.size() - 2]) {
        ASSERT_EQ(Journal::Open(folder / "flipped", kIdentity).payloads, all_but_last);
      } else {
        const std::string error = GetError(folder / "flipped");
        ASSERT_THAT(error, HasSubstr(at < ends[0] ? "not a knap journal" : "corrupted: record "));
        ASSERT_THAT(error, HasSubstr((folder / "flipped").string()));
        ASSERT_EQ(ReadFile(folder / "flipped"), flipped);  // evidence is not touched
      }
    }
  }
}

TEST(JournalTest, RecordsLostOrSwappedInTheMiddleAreNoticed) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  WriteBytes(folder / "lost", bytes.substr(0, ends[1]) + bytes.substr(ends[2]));
  EXPECT_THAT(GetError(folder / "lost"), HasSubstr("corrupted: record 2"));
  WriteBytes(folder / "swapped", bytes.substr(0, ends[0]) + bytes.substr(ends[1], ends[2] - ends[1]) +
                                     bytes.substr(ends[0], ends[1] - ends[0]) + bytes.substr(ends[2]));
  EXPECT_THAT(GetError(folder / "swapped"), HasSubstr("corrupted: record 1"));
}

TEST(JournalTest, BelongsToOneIdentityAndOneProcess) {
  const TemporaryFolder folder;
  MakeJournalBytes(folder / "journal");
  RunIdentity other = kIdentity;
  other[0].second = "another hash";
  EXPECT_THAT(GetError(folder / "journal", other), HasSubstr("another configuration"));
  other = kIdentity;
  other[1].second = "1";
  EXPECT_THAT(GetError(folder / "journal", other), HasSubstr("another build"));
  other = kIdentity;
  other.pop_back();
  EXPECT_THAT(GetError(folder / "journal", other), HasSubstr("another identity"));
  const Journal::Opened holder = Journal::Open(folder / "journal", kIdentity);
  EXPECT_THAT(GetError(folder / "journal"), HasSubstr("another process"));
  EXPECT_THROW(Journal::Create(folder / "journal", kIdentity), std::runtime_error);
}

TEST(JournalTest, OtherFilesAreRefusedUntouched) {
  const TemporaryFolder folder;
  WriteBytes(folder / "notes", "my only copy of something long enough to hold a record's prefix");
  EXPECT_THAT(GetError(folder / "notes"), HasSubstr("not a knap journal"));
  EXPECT_THAT(ReadFile(folder / "notes"), HasSubstr("my only copy"));
  EXPECT_THROW(Journal::Open(folder / "absent", kIdentity), std::system_error);
}

// A file size limit stands in for a full disk: the write fails in the middle of a record.
TEST(JournalTest, AFailedWriteStopsTheJournalAndLeavesATornTail) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  MakeJournalBytes(folder / "journal", &ends);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    Journal::Opened opened = Journal::Open(folder / "journal", kIdentity);
    const rlimit limit{ends.back() + 20, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    EXPECT_THROW(opened.journal.Append(std::string(100, 'y')), std::system_error);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_THROW(opened.journal.Append("z"), std::runtime_error);  // it would hide the damage
  }
  std::signal(SIGXFSZ, handler);
  const Journal::Opened opened = Journal::Open(folder / "journal", kIdentity);
  EXPECT_EQ(opened.payloads, kPayloads);
  EXPECT_EQ(opened.torn_bytes, 20u);
}

std::vector<std::string> OpenPayloads(const std::filesystem::path& path) {
  return Journal::Open(path, kIdentity).payloads;
}

// Whatever is damaged: all records that are whole are kept, what is no record is found beside the journal, and the
// journal can be opened again.
TEST(JournalRepairTest, KeepsEveryWholeRecordWhereverAByteIsFlipped) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    SCOPED_TRACE(at);
    const std::filesystem::path path = folder / std::to_string(at);
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    WriteBytes(path, flipped);
    const auto hit = static_cast<std::size_t>(std::distance(
        ends.begin(), std::find_if(ends.begin(), ends.end(), [at](std::size_t end) { return at < end; })));
    std::vector<std::string> kept = kPayloads;
    if (hit > 0) kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(hit) - 1);
    const std::size_t begin = hit == 0 ? 0 : ends[hit - 1];

    const JournalRepair repair = RepairJournal(path, kIdentity);
    ASSERT_TRUE(repair.changed);
    ASSERT_EQ(repair.header_lost, hit == 0);
    ASSERT_EQ(repair.payloads, kept);
    ASSERT_EQ(repair.damaged.size(), 1u);
    ASSERT_EQ(repair.damaged[0].offset, begin);
    ASSERT_EQ(repair.damaged[0].bytes, ends[hit] - begin);
    ASSERT_EQ(ReadFile(repair.set_aside), flipped.substr(begin, ends[hit] - begin));
    const bool seen = hit > 0 && hit < kPayloads.size();  // that the last one is missing, nobody can know
    ASSERT_EQ(repair.missing, seen ? std::vector<std::uint64_t>{hit} : std::vector<std::uint64_t>{});
    ASSERT_EQ(OpenPayloads(path), kept);
  }
}

TEST(JournalRepairTest, RecordsLostSwappedOrCutOffAreNoObstacle) {
  const TemporaryFolder folder;
  std::vector<std::size_t> ends;
  const std::string bytes = MakeJournalBytes(folder / "whole", &ends);
  const auto record = [&](std::size_t k) { return bytes.substr(ends[k - 1], ends[k] - ends[k - 1]); };
  const std::string header = bytes.substr(0, ends[0]);

  WriteBytes(folder / "lost", header + record(1) + record(4));
  const JournalRepair lost = RepairJournal(folder / "lost", kIdentity);
  EXPECT_EQ(lost.missing, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_TRUE(lost.set_aside.empty());
  EXPECT_EQ(OpenPayloads(folder / "lost"), (std::vector<std::string>{kPayloads[0], kPayloads[3]}));

  WriteBytes(folder / "swapped", header + record(2) + record(1));
  EXPECT_TRUE(RepairJournal(folder / "swapped", kIdentity).missing.empty());
  EXPECT_EQ(OpenPayloads(folder / "swapped"), (std::vector<std::string>{kPayloads[1], kPayloads[0]}));

  WriteBytes(folder / "torn", header + record(1) + record(4).substr(0, 20));
  EXPECT_EQ(ReadFile(RepairJournal(folder / "torn", kIdentity).set_aside), record(4).substr(0, 20));
  EXPECT_EQ(OpenPayloads(folder / "torn"), std::vector<std::string>{kPayloads[0]});
}

TEST(JournalRepairTest, AWholeJournalStaysAsItIsAndADamagedOneIsSetAsideEachTime) {
  const TemporaryFolder folder;
  const std::string bytes = MakeJournalBytes(folder / "journal");
  EXPECT_FALSE(RepairJournal(folder / "journal", kIdentity).changed);
  EXPECT_EQ(ReadFile(folder / "journal"), bytes);
  for (const std::string name : {"journal.damaged", "journal.damaged-2"}) {
    WriteBytes(folder / "journal", bytes + name);
    EXPECT_EQ(RepairJournal(folder / "journal", kIdentity).set_aside, folder / name);
    EXPECT_EQ(ReadFile(folder / name), name);
  }
  const Journal::Opened holder = Journal::Open(folder / "journal", kIdentity);
  EXPECT_THROW(RepairJournal(folder / "journal", kIdentity), std::runtime_error);
}

TEST(JournalTest, ARefusalNamesTheWayOn) {
  const TemporaryFolder folder;
  std::string bytes = MakeJournalBytes(folder / "journal");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  WriteBytes(folder / "journal", bytes);
  EXPECT_THAT(GetError(folder / "journal"), HasSubstr("knap repair " + folder.path().string()));
}

}  // namespace journal_test
}  // namespace knap
