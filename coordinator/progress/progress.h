// How far the run is, on stderr: one bar redrawn in place on a terminal, plain lines now and then elsewhere. A run has
// one bar from its first rollout to its report: it says in words what goes on now, never goes back, and ends at 100%.
//
// The text is a pure function of a ProgressState; the reporter only decides when to write. Time comes with the state,
// so nothing here reads a clock.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace knap {

enum class ProgressPhase {
  kLearning,   // batches, and validation between them
  kTesting,    // what was learned, on unseen variations
  kReporting,  // rollouts are simulated again for the report
  kCounting,   // a known number of rollouts, and nothing else
  kStudying,   // many runs at a time
  kDone,
};

struct ProgressState {
  std::string title;  // "pushing ours"
  ProgressPhase phase = ProgressPhase::kLearning;
  double elapsed_s = 0.0;                     // of work on the run; never decreases
  int batch = 0, batches = 0;                 // t of T; 0 before the first
  int evaluation = 0, max_evaluations = 0;    // of this batch
  std::optional<double> loss, best_loss;      // of this batch; unset: none yet, or rejected
  std::string loss_unit;                      // what follows a loss, such as " mm²"
  bool validating = false;                    // between two batches, in phase kLearning
  std::int64_t tested = 0, tests = 0;         // rollouts of the tests, tested in phases kTesting and kCounting
  int replayed = 0, replays = 0;              // rollouts of the report, replayed in phase kReporting
  double replay_cost = 1.0;                   // how many rollouts' time one of them takes, of workers and tests
  double report_began_s = 0.0;                // on the clock of elapsed_s
  int runs_done = 0, runs = 0;                // of a study, in phase kStudying
  double study_part = 0.0;                    // done of all its runs' learning, in [0, 1]
  std::int64_t rollouts = 0;                  // answered so far
  int workers_alive = 0, workers_wanted = 0;  // wanted 0: whoever comes
  std::int64_t retries = 0;                   // requests sent again
};

// Done part of the run in [0, 1], learning and the tests and the report behind it together, by rollouts: of learning as
// many as there will be if the rest of its batches, and within one its evaluations, go like those so far. A batch may
// end early, so this jumps forward but never back, as long as tests, replays and replay_cost stay what they are.
double CalcDonePart(const ProgressState& state);

// Seconds left to the end of the run if it goes like what is done. Unset before 2 s and 1% of it.
std::optional<double> CalcTimeLeft(const ProgressState& state);

// "0:07", "12:34", "1:02:03"; seconds are rounded.
std::string FormatDuration(double seconds);

// "12.3 mm²" with a unit such as " mm²" (ProgressState::loss_unit); "-" where there is none yet or it is not finite.
std::string FormatLoss(std::optional<double> loss, const std::string& unit);

// One line without a line end, at most `width` columns: a bar, its percentage, what goes on, in as many words as there
// is room for, the time left, and then as many of the figures as fit, the most important first. Below 19 columns there
// is room for the percentage alone, below 4 for nothing. Escape sequences for colour take no column; without `colour`
// there are none.
std::string FormatProgressBar(const ProgressState& state, int width, bool colour);

// One complete line for logs, without a line end, colour or control character.
std::string FormatProgressLine(const ProgressState& state);

// What the stream of a file descriptor can do. Colour needs a terminal that is not "dumb" and NO_COLOR unset or empty
// (no-color.org).
struct TerminalTraits {
  bool is_terminal = false;
  bool colour = false;
  int width = 80;
};
TerminalTraits DetectTerminal(int file_descriptor);

// Writes at most ten bars a second; elsewhere a line when a batch or the phase begins, but no two within a second, and
// one at least every five seconds (of Update calls: it has no timer).
class ProgressReporter {
 public:
  // `write` gets each text as it is to appear, and decides what becomes of one that cannot be written.
  ProgressReporter(std::function<void(std::string_view)> write, const TerminalTraits& traits);

  void Update(const ProgressState& state);
  void Clear();                             // wipes the bar, so that another line can be written; no effect elsewhere
  void Finish(const ProgressState& state);  // writes the last state whatever the rate, and ends the line

 private:
  void Show(const ProgressState& state);

  const std::function<void(std::string_view)> write_;
  TerminalTraits traits_;
  bool bar_drawn_ = false;
  std::optional<ProgressState> last_;  // as written
};

}  // namespace knap
