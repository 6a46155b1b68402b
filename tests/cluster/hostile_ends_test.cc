// Programs whose standard streams are closed or full, runs whose folders are in the way, and damaged journals: from
// outside, as whoever starts them sees it. What happens during a run is in hostile_ends.sh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"

namespace knap {
namespace hostile_ends_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kBin = KNAP_BIN "/";
const std::string kConfig = "'" KNAP_SOURCE_DIR "/configs/pushing.yaml'";
// Coarse and short: a run takes a second.
const std::string kShort = kConfig +
                           " 'rollout.horizon=2 s' 'rollout.step=4 ms' learning.variations=4 learning.batch=2"
                           " learning.max_evaluations=3 evaluation.variations=4 --workers 2";

class HostileEndsTest : public ::testing::Test {
 protected:
  // A line of a shell, in a folder of its own, whose programs are ours.
  Ended Shell(const std::string& line) {
    return RunToEnd("/bin/sh", {"-c", "PATH='" + kBin + "':$PATH; " + line}, folder_ / "", "shell");
  }

  std::size_t CountEntries(const std::string& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_ / folder), {}));
  }

  TemporaryFolder folder_;
};

TEST_F(HostileEndsTest, WhatStdoutDoesNotTakeIsAFailure) {
  for (const std::string& command :
       {"knap rollout " + kConfig + " 'rollout.horizon=0.1 s' --json", "knap learn --dry-run " + kShort,
        "knap validate " + kConfig, std::string("knap validate --describe"), std::string("knap --help"),
        std::string("knap --version"), std::string("knap-worker --help"), std::string("knap-relay --help")}) {
    EXPECT_EQ(Shell(command).code, 0) << command;
    for (const std::string end : {">/dev/full", ">&-"}) {
      const Ended ended = Shell(command + " " + end);
      EXPECT_EQ(ended.code, 1) << command << end;
      EXPECT_THAT(ended.err, HasSubstr("cannot write to stdout")) << command << end;
    }
  }
}

TEST_F(HostileEndsTest, WhatStderrDoesNotTakeChangesNoExitCode) {
  for (const std::string end : {"2>/dev/full", "2>&-", "<&- >&- 2>&-"}) {
    EXPECT_EQ(Shell("knap learn nowhere.yaml " + end).code, 2) << end;
    EXPECT_EQ(Shell("knap no-such-command " + end).code, 2) << end;
    EXPECT_EQ(Shell("knap status --wait 0.1 --lcm-url no-url " + end).code, 2) << end;
    EXPECT_EQ(Shell("knap-worker --key nowhere " + end).code, 2) << end;
    EXPECT_EQ(Shell("knap-relay --host 192.0.2.1 --port 1 " + end).code, 1) << end;
  }
}

TEST_F(HostileEndsTest, ARunIsDoneWhetherOrNotAnybodyHearsOfIt) {
  ASSERT_EQ(Shell("knap learn --out reference --quiet " + kShort).code, 0);
  for (const auto& [name, end] : std::vector<std::pair<std::string, std::string>>{
           {"full", "2>/dev/full"}, {"closed", "2>&-"}, {"all-closed", "<&- >&- 2>&-"}}) {
    EXPECT_EQ(Shell("knap learn --out " + name + " " + kShort + " " + end).code, 0) << name;
    ExpectSameRun(folder_ / name, folder_ / "reference");
    const std::string events = ReadText(folder_ / name / "events.jsonl");
    const std::size_t told = events.find("progress_dropped");
    EXPECT_NE(told, std::string::npos) << name;
    EXPECT_EQ(events.find("progress_dropped", told + 1), std::string::npos) << name;  // once is enough
    // Nobody but the journal has written into it.
    EXPECT_EQ(Shell("knap learn --quiet --workers 1 --resume " + name).code, 0) << name;
    ExpectSameRun(folder_ / name, folder_ / "reference");
  }
  // A reader that goes away ends no run either.
  EXPECT_EQ(Shell("{ knap learn --out gone " + kShort + " 2>&1 >/dev/null; echo $? >code; } | true").code, 0);
  EXPECT_EQ(ReadText(folder_ / "code"), "0\n");
  ExpectSameRun(folder_ / "gone", folder_ / "reference");
}

// Every command with progress: the result is whole, and says once that somebody missed the progress.
TEST_F(HostileEndsTest, CommandsSayOnceThatProgressWasDropped) {
  const std::string coarse = kConfig + " 'rollout.horizon=2 s' 'rollout.step=4 ms' --workers 2 ";
  const std::string said = "progress is not all on stderr: No space left on device\n";
  for (const std::string& command :
       {"knap evaluate " + coarse + "--variations 4", "knap gradcheck " + coarse + "--rollouts 1 --tolerance 1000",
        "rm -rf map; knap landscape " + coarse + "--x left_depth --y right_depth --grid 2 --variations 1 --out map"}) {
    const Ended shown = Shell(command);
    EXPECT_EQ(shown.code, 0) << command << shown.err;
    EXPECT_THAT(shown.out, Not(HasSubstr("stderr"))) << command;
    const Ended dropped = Shell(command + " 2>/dev/full");
    EXPECT_EQ(dropped.code, 0) << command;
    EXPECT_EQ(dropped.out, shown.out + said) << command;
  }
  for (const std::string& command : {"knap evaluate " + coarse + "--json --variations 4",
                                     "knap gradcheck " + coarse + "--json --rollouts 1 --tolerance 1000"}) {
    nlohmann::json shown = nlohmann::json::parse(Shell(command).out);
    EXPECT_FALSE(shown.contains("progress_dropped")) << command;
    shown["progress_dropped"] = "No space left on device";
    EXPECT_EQ(nlohmann::json::parse(Shell(command + " 2>/dev/full").out), shown) << command;
  }
  EXPECT_EQ(Shell("knap study --methods ours --seeds 1 --out study " + kShort + " 2>/dev/full").code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "study/study.json"));
  const std::string events = ReadText(folder_ / "study/events.jsonl");
  const std::size_t told = events.find("progress_dropped");
  EXPECT_NE(told, std::string::npos);
  EXPECT_EQ(events.find("progress_dropped", told + 1), std::string::npos);
}

// Whatever a command line holds: a terminal does not obey it, a log stays UTF-8, and a message one line.
TEST_F(HostileEndsTest, WhatMessagesQuoteIsClean) {
  const std::string odd = R"(odd=$(printf 'a\377b\033[31mc\nd\302\233e'); )";
  const std::string quoted = "a?b [31mc d e";
  const auto expect_clean = [](const std::string& text, const std::string& command) {
    EXPECT_NO_THROW(static_cast<void>(nlohmann::json(text).dump())) << command;  // UTF-8
    EXPECT_TRUE(std::none_of(text.begin(), text.end(), [](char c) {
      return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7f;
    })) << command;
    EXPECT_THAT(text, Not(HasSubstr("\xc2\x9b"))) << command;  // a control character of two bytes
  };
  for (const std::string& command : {
           std::string(R"(knap status run "$odd")"),
           std::string(R"(knap learn "$odd")"),
           "knap learn " + kConfig + R"( "learning.$odd=1")",
           "knap learn " + kConfig + R"( "learning.alpha=$odd")",
           "knap learn " + kConfig + R"( "$odd")",
           "knap learn " + kConfig + R"( "--$odd")",
           "knap learn " + kConfig + R"( --workers "$odd")",
           "knap learn " + kConfig + R"( --method "$odd")",
           "knap learn " + kConfig + R"( --key "$odd")",
           "knap learn " + kConfig + R"( --lcm-url "$odd")",
           std::string(R"(knap learn --resume "$odd")"),
           "knap study " + kConfig + R"( --methods "$odd")",
           std::string(R"(knap study --resume "$odd")"),
           "knap evaluate " + kConfig + R"( --theta "$odd")",
           "knap evaluate " + kConfig + R"( --theta "$odd=1")",
           "knap evaluate " + kConfig + R"( --theta "left_depth=$odd")",
           "knap landscape " + kConfig + R"( --x "$odd" --y left_depth)",
           "knap rollout " + kConfig + R"( --theta "$odd")",
           "knap gradcheck " + kConfig + R"( "$odd")",
           std::string(R"(knap validate "$odd")"),
           std::string(R"(knap repair "$odd")"),
           std::string(R"(knap status "$odd")"),
           std::string(R"(knap status --lcm-url "$odd")"),
           std::string(R"(knap verify-log "$odd" "$odd")"),
           std::string(R"(knap-worker "$odd")"),
           std::string(R"(knap-worker --name "$odd")"),
           std::string(R"(knap-worker --key "$odd")"),
           std::string(R"(LCM_DEFAULT_URL="$odd" knap-worker)"),
           std::string(R"(knap-relay "$odd")"),
           std::string(R"(knap-relay --host "$odd")"),
           std::string(R"(knap-relay --port "$odd")"),
           std::string(R"(knap-lossy-bridge "$odd" "$odd" 1)"),
           std::string(R"(knap-datagram-storm "$odd" 1 1 1)"),
       }) {
    const Ended ended = Shell(odd + command);
    EXPECT_THAT(ended.code, AnyOf(1, 2)) << command;
    EXPECT_EQ(ended.out, "") << command;
    EXPECT_THAT(ended.err, HasSubstr(quoted)) << command;
    expect_clean(ended.err, command);
  }
  // Files may have such names, and everything works.
  fs::copy(KNAP_SOURCE_DIR "/configs", folder_ / "configs", fs::copy_options::recursive);
  const Ended validated = Shell(odd + R"(mv configs "$odd"; knap validate "$odd/pushing.yaml")");
  EXPECT_EQ(validated.code, 0) << validated.err;
  EXPECT_THAT(validated.out, HasSubstr(quoted + "/pushing.yaml: valid"));
  expect_clean(validated.out, "validate");
  const std::string rest = kShort.substr(kConfig.size());
  const Ended learned = Shell(odd + R"(knap learn "$odd/pushing.yaml" --out "$odd-run")" + rest);
  EXPECT_EQ(learned.code, 0) << learned.err;
  EXPECT_THAT(learned.err, HasSubstr(quoted + "-run/result.json"));
  expect_clean(learned.err, "learn");
  const Ended evaluated = Shell(odd + R"(knap evaluate "$odd-run" --json --workers 1)");
  EXPECT_EQ(evaluated.code, 0) << evaluated.err;
  expect_clean(evaluated.out, "evaluate");
}

TEST_F(HostileEndsTest, AFolderCalledLatestStopsNobody) {
  fs::create_directories(folder_ / "runs/latest/mine");
  const Ended ended = Shell("knap learn " + kShort);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("runs/latest"));
  EXPECT_TRUE(fs::exists(folder_ / "runs/latest/mine"));
  EXPECT_EQ(CountEntries("runs"), 2u);
}

TEST_F(HostileEndsTest, WhatIsRefusedLeavesNoFolder) {
  std::ofstream(folder_ / "open-key") << "0123456789abcdef0123456789abcdef";
  fs::permissions(folder_ / "open-key", fs::perms::owner_read | fs::perms::group_read);
  for (const std::string& command : {std::string("knap learn"), std::string("knap study --seeds 1")}) {
    for (const std::string flag : {"--key nowhere", "--key open-key", "--lcm-url no-url"}) {
      EXPECT_EQ(Shell(command + " --out run " + kShort + " " + flag).code, 2) << command << flag;
      EXPECT_EQ(Shell(command + " " + kShort + " " + flag).code, 2) << command << flag;
    }
  }
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  EXPECT_FALSE(fs::exists(folder_ / "runs"));
  EXPECT_FALSE(fs::exists(folder_ / "studies"));
}

// Any damage: refused with the way on, repaired, and resumed to the same bits without asking for what was kept.
TEST_F(HostileEndsTest, ADamagedJournalIsRepairedAndResumed) {
  ASSERT_EQ(Shell("knap learn --out reference --quiet " + kShort).code, 0);
  const std::string journal = ReadText(folder_ / "reference/journal");
  const std::string whole = Shell("knap repair reference").out;
  EXPECT_THAT(whole, HasSubstr("nothing is damaged"));
  EXPECT_EQ(ReadText(folder_ / "reference/journal"), journal);
  for (const std::size_t at : {std::size_t{3}, journal.size() / 2}) {
    const std::string run = "run-" + std::to_string(at);
    fs::copy(folder_ / "reference", folder_ / run, fs::copy_options::recursive);
    fs::remove(folder_ / run / "result.json");
    std::string damaged = journal;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    std::ofstream(folder_ / run / "journal", std::ios::binary | std::ios::trunc) << damaged;
    const Ended refused = Shell("knap learn --resume " + run);
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr("knap repair " + run));
    const Ended repaired = Shell("knap repair " + run);
    EXPECT_EQ(repaired.code, 0) << repaired.err;
    EXPECT_THAT(repaired.out, AllOf(HasSubstr("lost: "), HasSubstr("journal.damaged"), HasSubstr("--resume " + run)));
    EXPECT_THAT(repaired.out, Not(HasSubstr(" 0 answers")));
    EXPECT_TRUE(fs::exists(folder_ / run / "journal.damaged"));
    const std::size_t rows = ReadCsv(folder_ / run / "rollouts.csv")["id"].size();
    EXPECT_EQ(Shell("knap learn --quiet --workers 2 --resume " + run).code, 0);
    ExpectSameRun(folder_ / run, folder_ / "reference");
    const std::size_t again = ReadCsv(folder_ / run / "rollouts.csv")["id"].size() - rows;
    EXPECT_EQ(again > 0, at != 3) << again;  // the header answers nothing
    EXPECT_LT(again, rows);
  }
  const Ended none = Shell("knap repair '" KNAP_SOURCE_DIR "'");
  EXPECT_EQ(none.code, 2);
}

}  // namespace hostile_ends_test
}  // namespace knap
