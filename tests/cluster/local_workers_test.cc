// Worker processes of one machine: those that cannot live, and those whose coordinator dies.
#include "coordinator/local_workers.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "coordinator/run_directory/temporary_folder.h"
#include "lcmtypes/wire/clock.h"
#include "tests/support/own_lcm_url.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace local_workers_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LocalWorkersTest, MissingProgramIsNamed) {
  SteadyClock clock;
  LocalWorkerOptions options;
  options.program = "/nowhere/knap-worker";
  EXPECT_THROW(LocalWorkers(options, &clock, [](const std::string&, pid_t, DeathCause) {}), std::runtime_error);
}

// Stands still until it is set on, so that no start takes long.
class HeldClock : public Clock {
 public:
  std::int64_t now_us() const override { return now_us_; }
  std::int64_t wall_us() const override { return now_us_; }
  void Advance(std::int64_t us) { now_us_ += us; }

 private:
  std::int64_t now_us_ = 0;
};

TEST(LocalWorkersTest, WorkerThatCannotLiveEndsWithItsLastLine) {
  HeldClock clock;
  const TemporaryFolder folder;
  LocalWorkerOptions options;
  options.program = FindWorkerProgram("knap-test-worker");
  options.lcm_url = "udpm://1.2.3.4:5";
  options.log_directory = folder.path();
  int deaths = 0;
  LocalWorkers workers(options, &clock, [&](const std::string&, pid_t, DeathCause cause) {
    ++deaths;
    EXPECT_EQ(cause, DeathCause::kOutside);
  });
  std::string line;
  ASSERT_TRUE(WaitFor([&] {
    try {
      const int before = deaths;
      workers.Poll();
      if (deaths > before) clock.Advance(60'000'000);  // past the pause before it is started again
    } catch (const std::runtime_error& e) {
      line = e.what();
    }
    return !line.empty();
  }));
  EXPECT_THAT(line, AllOf(HasSubstr("local-1"), HasSubstr("exit code 2"), HasSubstr("no multicast address"),
                          HasSubstr(".log")));
  EXPECT_EQ(deaths, 5);
}

TEST(LocalWorkersTest, OneThatCannotLiveIsGivenUpWhileAnotherLives) {
  const TemporaryFolder folder;
  const std::filesystem::path program = folder / "program";
  std::ofstream(program) << "#!/bin/sh\ncase \"$*\" in *local-1*) exit 1 ;; esac\nexec sleep 1000000\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  HeldClock clock;
  LocalWorkerOptions options;
  options.count = 2;
  options.program = program;
  int deaths = 0;
  LocalWorkers workers(options, &clock, [&](const std::string& name, pid_t, DeathCause) {
    EXPECT_EQ(name, "local-1");
    ++deaths;
  });
  ASSERT_TRUE(WaitFor([&] {
    const int before = deaths;
    workers.Poll();
    if (deaths > before) clock.Advance(60'000'000);  // past the pause before it is started again
    return deaths == 5;
  }));
  clock.Advance(60'000'000);
  workers.Poll();
  EXPECT_EQ(workers.restarts(), 4);
  EXPECT_EQ(workers.ListProcesses().size(), 1u);
}

bool IsGone(pid_t pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string number, name, state;
  return !(file >> number >> name >> state) || state == "Z";
}

TEST(LocalWorkersTest, WorkersDieWithTheirParent) {
  int line[2];
  ASSERT_EQ(pipe(line), 0);
  const std::string url = MakeOwnLcmUrl();
  const pid_t parent = fork();
  if (parent == 0) {
    SteadyClock clock;
    LocalWorkerOptions options;
    options.program = FindWorkerProgram("knap-test-worker");
    options.lcm_url = url;
    LocalWorkers workers(options, &clock, [](const std::string&, pid_t, DeathCause) {});
    const pid_t worker = workers.ListProcesses()[0];
    if (write(line[1], &worker, sizeof(worker)) != sizeof(worker)) _exit(1);
    pause();
    _exit(0);
  }
  pid_t worker = 0;
  ASSERT_EQ(read(line[0], &worker, sizeof(worker)), static_cast<ssize_t>(sizeof(worker)));
  const std::string program = fmt::format("/proc/{}/exe", worker);
  EXPECT_TRUE(WaitFor([&] {
    std::error_code none;
    return std::filesystem::read_symlink(program, none) == FindWorkerProgram("knap-test-worker");
  })) << "it does not become the worker program";
  EXPECT_FALSE(IsGone(worker));
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  EXPECT_TRUE(WaitFor([&] { return IsGone(worker); }));
  close(line[0]);
  close(line[1]);
}

}  // namespace local_workers_test
}  // namespace knap
