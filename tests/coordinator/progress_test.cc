#include "coordinator/progress/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace knap {
namespace {

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
  // A test alone.
  state.rollouts = state.tested;
  EXPECT_DOUBLE_EQ(CalcDonePart(state), 0.25);
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
            "1:10 pushing ours  32%  ETA 2:25  batch 7/20  evaluation 10  loss 0.01235  best 0.011  workers 2/2  "
            "rollouts 812  retries 0");
  ProgressState state = MakeState();
  state.loss_unit = " mm²";
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("  loss 0.01235 mm²  best 0.011 mm²  "));
  state.loss.reset();
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("  loss -  "));
  state.phase = ProgressPhase::kTesting;
  state.tests = 200;
  state.tested = 50;
  EXPECT_THAT(FormatProgressLine(state), HasSubstr("tested 50/200"));
  EXPECT_THAT(FormatProgressLine(state), Not(HasSubstr("batch")));
}

TEST(ProgressTest, BarFitsEveryWidthAndDropsTheLeastImportant) {
  const ProgressState state = MakeState();
  for (int width = 20; width <= 200; ++width) {
    const std::string bar = FormatProgressBar(state, width, false);
    EXPECT_LE(static_cast<int>(bar.size()), width);
    EXPECT_THAT(bar, HasSubstr("32%"));
  }
  EXPECT_EQ(FormatProgressBar(state, 200, false),
            "pushing ours [#############...........................]  32% ETA 2:25 batch 7/20 evaluation 10 "
            "loss 0.01235 best 0.011 workers 2/2 rollouts 812 retries 0");
  EXPECT_THAT(FormatProgressBar(state, 60, false), HasSubstr("ETA 2:25 batch 7/20"));
  EXPECT_THAT(FormatProgressBar(state, 60, false), Not(HasSubstr("retries")));
}

TEST(ProgressTest, ColourChangesNothingButEscapes) {
  ProgressState state = MakeState();
  state.workers_alive = 1;
  state.retries = 3;
  const std::string plain = FormatProgressBar(state, 200, false);
  std::string coloured = FormatProgressBar(state, 200, true);
  EXPECT_THAT(plain, Not(HasSubstr("\x1b")));
  EXPECT_THAT(coloured, HasSubstr("\x1b[33mworkers 1/2\x1b[0m"));
  EXPECT_THAT(coloured, HasSubstr("\x1b[33mretries 3\x1b[0m"));
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
  for (int batch = 1; batch <= 9; ++batch) EXPECT_THAT(text, HasSubstr("batch " + std::to_string(batch) + "/20"));
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
  EXPECT_THAT(text, HasSubstr("tested 0/400"));
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

}  // namespace
}  // namespace knap
