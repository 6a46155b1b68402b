#include "coordinator/progress/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

namespace knap {
namespace progress_test {

using testing::HasSubstr;
using testing::Not;

ProgressState MakeState() {
  ProgressState state;
  state.title = "pushing ours";
  state.elapsed_s = 70.0;
  state.batch = 7;
  state.batches = 20;
  state.evaluation = 10;
  state.max_evaluations = 20;
  state.loss = 0.0123456;
  state.best_loss = 0.011;
  state.rollouts = 812;
  state.workers_alive = state.workers_wanted = 2;
  return state;
}

TEST(ProgressTest, DonePartCountsBatchesAndEvaluations) {
  ProgressState state = MakeState();
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 6.5 / 20.0);
  state.evaluation = 400;  // more than announced
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 7.0 / 20.0);
  // The tests behind it count as rollouts: 812 are a share of 7/20 of learning.
  state.tests = 400;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 812.0 / (812.0 * 20.0 / 7.0 + 400.0));
  // All of them learned, and then tested: one bar, which goes on where it was.
  state.batch = state.batches;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 812.0 / 1212.0);
  state.phase = ProgressPhase::kTesting;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 812.0 / 1212.0);
  state.tested = 100;
  state.rollouts += 100;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 912.0 / 1212.0);
  // The report follows: 48 rollouts that take as long as two of the others each.
  state.replays = 48;
  state.replay_cost = 2.0;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 912.0 / 1310.0);
  state.tested = 400;
  state.rollouts = 1212;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 1212.0 / 1310.0);
  state.phase = ProgressPhase::kReporting;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 1212.0 / 1310.0);
  state.replayed = 12;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 1236.0 / 1310.0);
  state.replayed = 48;  // what is left is to write them down
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 1308.0 / 1310.0);
  state.phase = ProgressPhase::kDone;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 1.0);
  // A known number of rollouts alone, and a report alone.
  state = ProgressState{};
  state.phase = ProgressPhase::kCounting;
  state.tests = 400;
  state.tested = state.rollouts = 100;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 0.25);
  state = ProgressState{};
  state.phase = ProgressPhase::kReporting;
  state.replays = 49;
  state.replayed = 25;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 0.5);
  EXPECT_EQ(CalcDonePart(ProgressState{}), 0.0);
}

TEST(ProgressTest, TimeLeftExtrapolates) {
  ProgressState state = MakeState();
  EXPECT_DOUBLE_EQ(*CalcTimeLeft(state), 70.0 * 13.5 / 6.5);
  state.tests = 400;  // they follow, at the pace of 812 rollouts in 70 s
  EXPECT_DOUBLE_EQ(*CalcTimeLeft(state), 70.0 * 13.5 / 6.5 + 70.0 / 812.0 * 400.0);
  state.phase = ProgressPhase::kTesting;
  state.tested = 100;
  state.rollouts = 912;
  EXPECT_DOUBLE_EQ(*CalcTimeLeft(state), 70.0 * 300.0 / 912.0);
  // Replays tell best themselves how long they take.
  state.phase = ProgressPhase::kReporting;
  state.replays = 48;
  state.replayed = 12;
  state.report_began_s = 70.0;
  state.elapsed_s = 74.0;
  EXPECT_DOUBLE_EQ(*CalcTimeLeft(state), 4.0 / 12.0 * 36.0);
  state = MakeState();
  state.elapsed_s = 1.0;
  EXPECT_FALSE(CalcTimeLeft(state).has_value());
  state = MakeState();
  state.batch = 0;
  EXPECT_FALSE(CalcTimeLeft(state).has_value());
}

TEST(ProgressTest, DurationsAreReadable) {
  EXPECT_EQ(FormatDuration(0.4), "0:00");
  EXPECT_EQ(FormatDuration(59.6), "1:00");
  EXPECT_EQ(FormatDuration(754), "12:34");
  EXPECT_EQ(FormatDuration(3723), "1:02:03");
  EXPECT_EQ(FormatDuration(-1), "0:00");
}

TEST(ProgressTest, LineShowsEverything) {
  EXPECT_EQ(FormatProgressLine(MakeState()),
            "1:10 pushing ours  32%  learning: batch 7 of 20  2:25 left  loss 0.01235  best 0.011  evaluation 10  "
            "workers 2/2  812 rollouts");
  ProgressState state = MakeState();
  state.retries = 3;
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("  812 rollouts  3 given again"));
  state.loss_unit = " mm²";
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("  loss 0.01235 mm²  best 0.011 mm²  "));
  state.loss.reset();
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("  rejected  best 0.011 mm²  "));
  state.evaluation = 0;
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("rejected")));
  state.phase = ProgressPhase::kTesting;
  state.tests = 200;
  state.tested = 50;
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("testing: rollout 50 of 200"));
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("batch")));
}

TEST(ProgressTest, LineSaysInWordsWhatGoesOn) {
  ProgressState state = MakeState();
  const auto expect = [&state](const std::string& words) {
    EXPECT_THAT(FormatProgressLine(state), HasSubstr("%  " + words + "  "));
  };
  state.workers_alive = 0;
  expect("waiting for workers");
  state.workers_alive = 2;
  state.validating = true;
  expect("validating batch 7 of 20");
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("loss")));  // which is the batch's
  state.batch = 0;
  expect("validating the initial design");
  state.validating = false;
  expect("starting");
  state.phase = ProgressPhase::kReporting;
  state.workers_alive = 0;  // they have left, and are not missed
  state.replays = 48;
  state.replayed = 12;
  expect("report: replay 12 of 48");
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("workers")));
  state.phase = ProgressPhase::kDone;
  expect("done");
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("left")));
  state = MakeState();
  state.phase = ProgressPhase::kCounting;
  state.tests = 200;
  state.tested = 50;
  expect("rollout 50 of 200");
  state.phase = ProgressPhase::kStudying;
  state.runs = 15;
  state.runs_done = 3;
  expect("3 of 15 runs done");
}

// Every state that a run goes through, from its first rollout to its end.
std::vector<ProgressState> MakeWholeRun() {
  std::vector<ProgressState> run;
  ProgressState state = MakeState();
  state.loss_unit = " mm²";
  state.tests = 60;
  state.replays = 48;
  state.replay_cost = 2.0;
  state.elapsed_s = 0.0;
  state.rollouts = 0;
  const auto add = [&](int rollouts) {
    state.elapsed_s += 1.0;
    state.rollouts += rollouts;
    run.push_back(state);
  };
  state.workers_alive = 0;
  state.batch = 0;
  add(0);
  state.workers_alive = 2;
  for (state.batch = 0; state.batch <= state.batches; ++state.batch) {
    state.evaluation = 0;
    for (const int last = 4 * state.batch; state.batch > 0 && state.evaluation < std::min(last, 20);) {
      add(5);
      ++state.evaluation;
      add(5);  // before the next batch, or after it has ended early
    }
    state.validating = true;
    for (int i = 0; i < 4; ++i) add(10);
    state.validating = false;
  }
  --state.batch;
  state.phase = ProgressPhase::kTesting;
  for (state.tested = 0; state.tested < state.tests; ++state.tested) add(state.tested > 0 ? 1 : 0);
  add(1);
  state.phase = ProgressPhase::kReporting;
  state.workers_alive = 0;
  for (state.replayed = 0; state.replayed <= state.replays; ++state.replayed) add(0);
  --state.replayed;
  state.phase = ProgressPhase::kDone;
  add(0);
  return run;
}

int CountCharacters(const std::string& text) {
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

TEST(ProgressTest, AWholeRunIsOneBarThatNeverGoesBack) {
  const std::vector<ProgressState> run = MakeWholeRun();
  double before = 0.0;
  for (const ProgressState& state : run) {
    EXPECT_GE(CalcDonePart(state), before) << FormatProgressLine(state);
    before = CalcDonePart(state);
  }
  EXPECT_EQ(before, 1.0);
  EXPECT_LT(CalcDonePart(run[run.size() - 2]), 1.0);
  std::string text;
  ProgressReporter reporter([&text](std::string_view more) { text += more; },
                            {.is_terminal = true, .colour = false, .width = 80});
  for (std::size_t i = 0; i + 1 < run.size(); ++i) reporter.Update(run[i]);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 0);
  reporter.Finish(run.back());
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_THAT(text.substr(text.rfind('\r')), HasSubstr("] 100% done "));
}

TEST(ProgressTest, BarFitsEveryWidthAndSaysWhatGoesOn) {
  for (const ProgressState& state : MakeWholeRun()) {
    for (const int width : {0, 3, 4, 18, 19, 20, 21, 25, 30, 39, 40, 60, 79, 80, 120, 200}) {
      const std::string bar = FormatProgressBar(state, width, false);
      ASSERT_LE(CountCharacters(bar), width) << bar;
      const std::size_t percent = bar.find('%');
      if (width >= 4) {
        ASSERT_NE(percent, std::string::npos);
      }
      if (width < 19) continue;
      ASSERT_THAT(bar, HasSubstr("["));
      ASSERT_TRUE(percent + 2 < bar.size() && std::islower(bar[percent + 2])) << bar;
    }
  }
}

TEST(ProgressTest, BarDropsTheLeastImportant) {
  ProgressState state = MakeState();
  state.loss_unit = " mm²";
  state.retries = 3;
  EXPECT_EQ(FormatProgressBar(state, 200, false),
            "pushing ours [#############...........................]  32% learning: batch 7 of 20 2:25 left "
            "loss 0.01235 mm² best 0.011 mm² evaluation 10 workers 2/2 812 rollouts 3 given again");
  EXPECT_EQ(FormatProgressBar(state, 79, false),
            "[######.............]  32% learning: batch 7 of 20 2:25 left loss 0.01235 mm²");
  EXPECT_EQ(FormatProgressBar(state, 39, false), "[##.......]  32% batch 7/20 2:25 left");
  EXPECT_EQ(FormatProgressBar(state, 19, false), "[#....]  32% learns");
}

TEST(ProgressTest, ColourChangesNothingButEscapes) {
  ProgressState state = MakeState();
  state.workers_alive = 1;
  state.retries = 3;
  const std::string plain = FormatProgressBar(state, 200, false);
  std::string coloured = FormatProgressBar(state, 200, true);
  EXPECT_THAT(plain, Not(HasSubstr("\x1b")));
  EXPECT_THAT(coloured, HasSubstr("\x1b[33mworkers 1/2\x1b[0m"));
  EXPECT_THAT(coloured, HasSubstr("\x1b[33m3 given again\x1b[0m"));
  for (std::size_t at = coloured.find('\x1b'); at != std::string::npos; at = coloured.find('\x1b')) {
    coloured.erase(at, coloured.find('m', at) + 1 - at);
  }
  EXPECT_EQ(coloured, plain);
}

TEST(ProgressTest, PlainLinesAreRareButMarkBatches) {
  std::string text;
  ProgressReporter reporter([&text](std::string_view more) { text += more; }, {});
  ProgressState state = MakeState();
  int calls = 0;
  // 60 s at 20 calls a second, a new batch every 7 s.
  for (state.elapsed_s = 0.0; state.elapsed_s < 60.0; state.elapsed_s += 0.05, ++calls) {
    state.batch = 1 + static_cast<int>(state.elapsed_s / 7.0);
    reporter.Update(state);
  }
  reporter.Clear();
  reporter.Finish(state);
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 60 / 5);
  EXPECT_LE(lines, 60 / 5 + 9 + 2);
  EXPECT_GT(calls, 1000);
  for (int batch = 1; batch <= 9; ++batch) EXPECT_THAT(text, HasSubstr("batch " + std::to_string(batch) + " of 20"));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  EXPECT_THAT(text, Not(HasSubstr("\r")));
}

TEST(ProgressTest, QuickBatchesDoNotFloodALog) {
  std::string text;
  ProgressReporter reporter([&text](std::string_view more) { text += more; }, {});
  ProgressState state = MakeState();
  for (int i = 0; i < 100; ++i) {  // a hundred batches in one second
    state.elapsed_s = 0.01 * i;
    state.batch = i;
    reporter.Update(state);
  }
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 2);
}

TEST(ProgressTest, TerminalBarIsRedrawnInPlaceAndEndedOnce) {
  std::string text;
  ProgressReporter reporter([&text](std::string_view more) { text += more; },
                            {.is_terminal = true, .colour = false, .width = 80});
  ProgressState state = MakeState();
  for (state.elapsed_s = 0.0; state.elapsed_s < 1.0; state.elapsed_s += 0.01) reporter.Update(state);
  const std::string running = text;
  EXPECT_EQ(std::count(running.begin(), running.end(), '\n'), 0);
  EXPECT_LE(std::count(running.begin(), running.end(), '\r'), 11);
  EXPECT_GE(std::count(running.begin(), running.end(), '\r'), 9);
  reporter.Clear();
  EXPECT_EQ(text.substr(running.size()), "\r\x1b[K");
  reporter.Finish(state);
  EXPECT_EQ(text.back(), '\n');
}

TEST(ProgressTest, ANewPhaseIsShownAtOnce) {
  std::string text;
  ProgressReporter reporter([&text](std::string_view more) { text += more; }, {});
  ProgressState state = MakeState();
  reporter.Update(state);
  state.phase = ProgressPhase::kTesting;
  state.tests = 400;
  reporter.Update(state);
  EXPECT_THAT(text, HasSubstr("testing: rollout 0 of 400"));
}

// On a real pseudo-terminal: what isatty and the environment say decides.
TEST(ProgressTest, ColourRespectsTheEnvironment) {
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  EXPECT_FALSE(DetectTerminal(pipe_ends[1]).is_terminal);
  EXPECT_FALSE(DetectTerminal(pipe_ends[1]).colour);
  close(pipe_ends[0]);
  close(pipe_ends[1]);

  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0) GTEST_SKIP() << "no pseudo-terminals here";
  setenv("TERM", "xterm", 1);
  unsetenv("NO_COLOR");
  EXPECT_TRUE(DetectTerminal(terminal).is_terminal);
  EXPECT_TRUE(DetectTerminal(terminal).colour);
  EXPECT_EQ(DetectTerminal(terminal).width, 80);  // a new one has no size
  setenv("NO_COLOR", "1", 1);
  EXPECT_FALSE(DetectTerminal(terminal).colour);
  setenv("NO_COLOR", "", 1);
  EXPECT_TRUE(DetectTerminal(terminal).colour);
  setenv("TERM", "dumb", 1);
  EXPECT_FALSE(DetectTerminal(terminal).colour);
  close(terminal);
}

}  // namespace progress_test
}  // namespace knap
