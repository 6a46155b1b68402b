// knap status and knap verify-log, beside a real run and with a real lcm-logger.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/tcpq_transport.h"
#include "tests/cluster/child_process.h"
#include "tests/cluster/run_files.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace watch_programs_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class WatchTest : public ::testing::Test {
 protected:
  struct Ended {
    int code;
    std::string out, err;
  };

  Ended Run(std::vector<std::string> arguments, const std::string& program = KNAP_PROGRAM) {
    ChildProcess process(program, std::move(arguments), folder_ / "", "command");
    const int code = process.Wait();
    return {code, process.ReadOut(), process.ReadErr()};
  }

  std::vector<std::string> MakeArguments(const std::string& out, int variations, const std::string& url) {
    return {"learn",
            KNAP_SOURCE_DIR "/configs/pushing.yaml",
            "rollout.horizon=2 s",
            fmt::format("learning.variations={}", variations),
            "learning.batch=2",
            "learning.max_evaluations=3",
            "evaluation.variations=6",
            "--workers",
            "2",
            "--lcm-url",
            url,
            "--out",
            out};
  }

  // What a relay with port 0 says about itself.
  std::string ReadRelayUrl(ChildProcess* relay) {
    std::smatch words;
    std::string said;
    EXPECT_TRUE(WaitFor([&] {
      said = relay->ReadErr();
      return std::regex_search(said, words, std::regex("(tcpq://[^ ]*)\n")) || relay->HasEnded();
    }));
    return words.empty() ? "" : words[1].str();
  }

  const std::string url_ = MakeOwnLcmUrl();
  TemporaryFolder folder_;
};

TEST_F(WatchTest, StatusShowsARunWhileItLearnsAndItsEnd) {
  // More variations than the fastest machine gets through before this test has looked at everything; Ctrl-C ends it.
  ChildProcess knap(KNAP_PROGRAM, MakeArguments("run", 100'000, url_), folder_ / "", "learn");
  ASSERT_TRUE(WaitFor([&] { return ReadCsv(folder_ / "run/rollouts.csv")["id"].size() > 10; })) << knap.ReadErr();
  Json status;
  // The rate is that of the last quarter second, in which a slow machine may have finished nothing, and a worker speaks
  // when it gets a processor.
  ASSERT_TRUE(WaitFor([&] {
    const Ended ended = Run({"status", "run", "--json", "--wait", "600"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    status = ended.code == 0 ? Json::parse(ended.out) : Json();
    return ended.code != 0 ||
           (status["runs"].size() == 1 && status["workers"].size() == 2 && status["runs"][0]["workers"] == 2 &&
            status["runs"][0]["rollouts_per_s"] > 0.0 && status["runs"][0]["loss"].is_number());
  })) << status;
  ASSERT_EQ(status["runs"].size(), 1u);
  const Json& run = status["runs"][0];
  EXPECT_EQ(run["scenario"], "pushing");
  EXPECT_EQ(run["state"], "learning");
  EXPECT_EQ(run["theta"].size(), 7u);
  EXPECT_EQ(run["loss_unit"], "m²");  // as in configs/pushing.yaml, of which the run's folder has a copy
  EXPECT_EQ(run["success_test"], true);
  EXPECT_GT(run["rollouts"], 10);
  EXPECT_GT(run["progress"], 0.0);
  ASSERT_EQ(status["workers"].size(), 2u);
  for (const Json& worker : status["workers"]) {
    EXPECT_THAT(worker["name"], HasSubstr("local-"));
    EXPECT_EQ(worker["run_id"], run["run_id"]);
    EXPECT_GT(worker["finished"], 0);
    EXPECT_GE(worker["age_s"], 0.0);
  }

  EXPECT_TRUE(WaitFor([&] {
    const Ended text = Run({"status", "--lcm-url", url_, "--key", folder_ / "run/key", "--wait", "600"});
    EXPECT_EQ(text.code, 0) << text.err;
    return ::testing::Matches(AllOf(HasSubstr("pushing ours  learning"), HasSubstr("(unit not known)"),
                                    HasSubstr("local-1"), HasSubstr("local-2")))(text.out);
  }));
  const Ended stranger = Run({"status", "--lcm-url", url_, "--wait", "5"});
  EXPECT_EQ(stranger.code, 1);
  EXPECT_THAT(stranger.err, HasSubstr("another key"));

  // On a terminal the table is drawn again and again, until Ctrl-C.
  ChildProcess live("/usr/bin/script", {"-qefc", "exec '" KNAP_PROGRAM "' status run --wait 600", "/dev/null"},
                    folder_ / "", "live");
  const auto count_escapes = [&] {
    const std::string drawn = live.ReadOut();
    return std::count(drawn.begin(), drawn.end(), '\x1b');
  };
  EXPECT_TRUE(WaitFor([&] { return count_escapes() >= 4; })) << live.ReadOut();
  EXPECT_TRUE(WaitFor([&] { return live.ReadOut().find("local-1") != std::string::npos; })) << live.ReadOut();
  EXPECT_FALSE(live.HasEnded());
  ASSERT_EQ(live.ListChildren().size(), 1u);
  kill(live.ListChildren().front(), SIGINT);
  live.Wait();

  knap.Signal(SIGINT);
  EXPECT_EQ(knap.Wait(), 130);
  const Ended over = Run({"status", "run", "--wait", "1"});
  EXPECT_EQ(over.code, 1);
  EXPECT_THAT(over.err, HasSubstr("nobody is heard"));
  EXPECT_EQ(Run({"status", "nowhere"}).code, 2);
}

TEST_F(WatchTest, RecordingTellsTheJournalOfItsRunAlone) {
  // Through a relay: of datagrams lcm-logger may miss one where it gets no processor, of a stream it misses nothing.
  ChildProcess relay(KNAP_RELAY, {"--port", "0"}, folder_ / "", "relay");
  const std::string url = ReadRelayUrl(&relay);
  {
    ChildProcess logger("/usr/bin/lcm-logger", {"--force", "--lcm-url", url, folder_ / "run.log"}, folder_ / "",
                        "logger");
    const SteadyClock clock;
    TcpqTransport marker(url, {}, &clock);
    const auto is_recorded = [&](const std::string& channel) {
      marker.Publish(channel, {1});
      return ReadText(folder_ / "run.log").find(channel) != std::string::npos;
    };
    ASSERT_TRUE(WaitFor([&] { return is_recorded("BEGIN"); })) << logger.ReadErr();
    const Ended learned = Run(MakeArguments("run", 4, url));
    ASSERT_EQ(learned.code, 0) << learned.err;
    ASSERT_TRUE(WaitFor([&] { return is_recorded("END"); })) << logger.ReadErr();
    logger.Signal(SIGINT);
    logger.Wait();
  }
  const Ended good = Run({"verify-log", "run.log", "run"});
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_THAT(good.out, AllOf(HasSubstr("run.log tells run"), HasSubstr("0 messages damaged")));

  // The same recording without one result, wherever it was repeated.
  const std::string lost_id = ReadCsv(folder_ / "run/rollouts.csv")["id"].at(5);
  std::string lost_bytes;
  for (std::size_t i = 0; i < lost_id.size(); i += 2) {
    lost_bytes.push_back(static_cast<char>(std::stoi(lost_id.substr(i, 2), nullptr, 16)));
  }
  {
    lcm::LogFile whole(folder_ / "run.log", "r");
    lcm::LogFile cut(folder_ / "cut.log", "w");
    while (const lcm::LogEvent* event = whole.readNextEvent()) {
      const std::string data(static_cast<const char*>(event->data), static_cast<std::size_t>(event->datalen));
      if (event->channel == "KNAP_RESULT" && data.find(lost_bytes) != std::string::npos) continue;
      lcm::LogEvent copy = *event;
      cut.writeEvent(&copy);
    }
  }
  const Ended cut = Run({"verify-log", "cut.log", "run"});
  EXPECT_EQ(cut.code, 1);
  EXPECT_THAT(cut.err, AllOf(HasSubstr("no result"), HasSubstr(lost_id)));

  // Another run of the same scenario, and files that are none.
  ASSERT_EQ(Run(MakeArguments("other", 4, url)).code, 0);
  const Ended other = Run({"verify-log", "run.log", "other"});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err, HasSubstr("answer 1 of the journal"));
  EXPECT_EQ(Run({"verify-log", "nowhere.log", "run"}).code, 2);
  EXPECT_EQ(Run({"verify-log", "run/config.yaml", "run"}).code, 2);
  EXPECT_EQ(Run({"verify-log", "run.log", "nowhere"}).code, 2);
}

}  // namespace watch_programs_test
}  // namespace knap
