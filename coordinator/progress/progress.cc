#include "coordinator/progress/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

namespace knap {
namespace {

constexpr const char* kEraseLine = "\r\x1b[K";
constexpr const char* kCyan = "\x1b[36m";
constexpr const char* kYellow = "\x1b[33m";
constexpr const char* kPlain = "\x1b[0m";
constexpr double kBarInterval_s = 0.1;
constexpr double kLineInterval_s = 5.0;
constexpr double kLeastLineInterval_s = 1.0;

struct Figure {
  std::string text;
  bool warning = false;
};

// What goes on now, in words: the longest first. The last one has at most six letters, for the narrowest bar.
struct Activity {
  std::vector<std::string> words;
  bool warning = false;
};

Activity MakeActivity(const ProgressState& state) {
  const bool asks_workers = state.phase == ProgressPhase::kLearning || state.phase == ProgressPhase::kTesting ||
                            state.phase == ProgressPhase::kCounting;
  if (asks_workers && state.workers_alive == 0) return {{"waiting for workers", "no workers", "waits"}, true};
  switch (state.phase) {
    case ProgressPhase::kLearning:
      if (state.validating) {
        return {{state.batch == 0 ? "validating the initial design"
                                  : fmt::format("validating batch {} of {}", state.batch, state.batches),
                 "validating", "checks"}};
      }
      if (state.batch == 0) return {{"starting", "starts"}};
      return {{fmt::format("learning: batch {} of {}", state.batch, state.batches),
               fmt::format("batch {}/{}", state.batch, state.batches), "learns"}};
    case ProgressPhase::kTesting:
      return {{fmt::format("testing: rollout {} of {}", state.tested, state.tests),
               fmt::format("test {}/{}", state.tested, state.tests), "tests"}};
    case ProgressPhase::kReporting:
      return {{fmt::format("report: replay {} of {}", state.replayed, state.replays),
               fmt::format("replay {}/{}", state.replayed, state.replays), "report"}};
    case ProgressPhase::kCounting:
      return {{fmt::format("rollout {} of {}", state.tested, state.tests),
               fmt::format("{}/{}", state.tested, state.tests), ""}};
    case ProgressPhase::kStudying:
      return {{fmt::format("{} of {} runs done", state.runs_done, state.runs),
               fmt::format("{}/{} done", state.runs_done, state.runs), "learns"}};
    case ProgressPhase::kDone:
      break;
  }
  return {{"done"}};
}

// "2:25 left"; empty while nobody can tell, and at the end.
std::string FormatTimeLeft(const ProgressState& state) {
  const std::optional<double> left = CalcTimeLeft(state);
  return left && state.phase != ProgressPhase::kDone ? FormatDuration(*left) + " left" : "";
}

// Behind these, the most important first.
std::vector<Figure> MakeFigures(const ProgressState& state) {
  std::vector<Figure> figures;
  if (state.phase == ProgressPhase::kLearning && state.evaluation > 0 && !state.validating) {
    figures.push_back({state.loss ? "loss " + FormatLoss(state.loss, state.loss_unit) : "rejected"});
    if (state.best_loss) figures.push_back({"best " + FormatLoss(state.best_loss, state.loss_unit)});
    figures.push_back({fmt::format("evaluation {}", state.evaluation)});
  }
  if (state.phase != ProgressPhase::kReporting && state.phase != ProgressPhase::kDone) {
    const bool missing = state.workers_alive < std::max(1, state.workers_wanted);
    figures.push_back({state.workers_wanted > 0
                           ? fmt::format("workers {}/{}", state.workers_alive, state.workers_wanted)
                           : fmt::format("workers {}", state.workers_alive),
                       missing});
  }
  if (state.rollouts > 0) figures.push_back({fmt::format("{} rollouts", state.rollouts)});
  if (state.retries > 0) figures.push_back({fmt::format("{} given again", state.retries), true});
  return figures;
}

std::string FormatPercent(const ProgressState& state) {
  return fmt::format("{:3.0f}%", std::floor(100.0 * CalcDonePart(state)));
}

// Columns on a terminal: characters of UTF-8, of which units have some that are longer than a byte.
int CountColumns(const std::string& text) {
  return static_cast<int>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

std::string MakePaint(const std::string& text, const char* colour, bool enabled) {
  return enabled ? colour + text + kPlain : text;
}

}  // namespace

double CalcDonePart(const ProgressState& state) {
  const auto rollouts = static_cast<double>(state.rollouts);
  const auto tests = static_cast<double>(state.tests);
  // Then the page is put together, which counts as one more.
  const double report = state.replays > 0 ? state.replay_cost * (state.replays + 1) : 0.0;
  double done = 0.0;
  switch (state.phase) {
    case ProgressPhase::kLearning:
      if (state.batches > 0 && state.batch > 0) {
        const double within = state.max_evaluations > 0
                                  ? std::min(1.0, static_cast<double>(state.evaluation) / state.max_evaluations)
                                  : 0.0;
        done = (state.batch - 1 + within) / state.batches;
        // Of rollouts/done + tests + report.
        if (state.rollouts > 0) done *= rollouts / (rollouts + (tests + report) * done);
      }
      break;
    case ProgressPhase::kTesting:
      if (state.tests > 0) {
        const double learned = std::max(0.0, rollouts - static_cast<double>(state.tested));
        done = (learned + static_cast<double>(state.tested)) / (learned + tests + report);
      }
      break;
    case ProgressPhase::kReporting:
      if (state.replays > 0) done = (rollouts + state.replay_cost * state.replayed) / (rollouts + report);
      break;
    case ProgressPhase::kCounting:
      if (state.tests > 0) done = static_cast<double>(state.tested) / tests;
      break;
    case ProgressPhase::kStudying:
      done = state.study_part;
      break;
    case ProgressPhase::kDone:
      done = 1.0;
      break;
  }
  return std::clamp(done, 0.0, 1.0);
}

std::optional<double> CalcTimeLeft(const ProgressState& state) {
  // What a replay takes is known best once there are some.
  if (state.phase == ProgressPhase::kReporting && state.replayed > 0) {
    return (state.elapsed_s - state.report_began_s) / state.replayed * (state.replays - state.replayed);
  }
  const double done = CalcDonePart(state);
  if (state.elapsed_s < 2.0 || done < 0.01) return std::nullopt;
  return state.elapsed_s * (1.0 - done) / done;
}

std::string FormatDuration(double seconds) {
  const auto total = static_cast<std::int64_t>(std::llround(std::clamp(seconds, 0.0, 1e9)));
  const std::int64_t hours = total / 3600, minutes = total / 60 % 60;
  return hours > 0 ? fmt::format("{}:{:02}:{:02}", hours, minutes, total % 60)
                   : fmt::format("{}:{:02}", minutes, total % 60);
}

std::string FormatLoss(std::optional<double> loss, const std::string& unit) {
  return loss && std::isfinite(*loss) ? fmt::format("{:.4g}{}", *loss, unit) : "-";
}

std::string FormatProgressBar(const ProgressState& state, int width, bool colour) {
  constexpr int kFewestCells = 5, kMostCells = 40, kTitled = 100;
  const std::string percent = FormatPercent(state);
  // As wide in every state, so that it does not jump.
  const int cells = std::clamp(width / 4, kFewestCells, kMostCells);
  const bool titled = width >= kTitled && !state.title.empty();
  int left = width - cells - 2 - 1 - CountColumns(percent) - (titled ? CountColumns(state.title) + 1 : 0);
  const auto take = [&left](const std::string& text) {
    const int columns = text.empty() ? 0 : CountColumns(text) + 1;
    if (columns > left) return false;
    left -= columns;
    return true;
  };
  const Activity activity = MakeActivity(state);
  const std::string& shortest = activity.words.back();
  if (!take(shortest)) return width < CountColumns(percent) ? "" : percent;
  std::string time_left = FormatTimeLeft(state);
  if (!take(time_left)) time_left.clear();
  // Longer words where there is room for them.
  left += shortest.empty() ? 0 : CountColumns(shortest) + 1;
  const auto words = std::find_if(activity.words.begin(), activity.words.end(), take);

  const auto full = static_cast<std::size_t>(CalcDonePart(state) * cells);
  std::string line = titled ? state.title + " [" : "[";
  line += MakePaint(std::string(full, '#'), kCyan, colour && full > 0);
  line += std::string(static_cast<std::size_t>(cells) - full, '.') + "] " + percent;
  const auto add = [&line, colour](const std::string& text, bool warning) {
    if (!text.empty()) line.append(1, ' ').append(MakePaint(text, kYellow, colour && warning));
  };
  add(*words, activity.warning);
  add(time_left, false);
  for (const Figure& figure : MakeFigures(state)) {
    if (!take(figure.text)) break;
    add(figure.text, figure.warning);
  }
  return line;
}

std::string FormatProgressLine(const ProgressState& state) {
  std::string line = fmt::format("{} {}  {:.0f}%  {}", FormatDuration(state.elapsed_s), state.title,
                                 std::floor(100.0 * CalcDonePart(state)), MakeActivity(state).words.front());
  if (const std::string left = FormatTimeLeft(state); !left.empty()) line += "  " + left;
  for (const Figure& figure : MakeFigures(state)) line += "  " + figure.text;
  return line;
}

TerminalTraits DetectTerminal(int file_descriptor) {
  TerminalTraits traits;
  traits.is_terminal = isatty(file_descriptor) == 1;
  if (!traits.is_terminal) return traits;
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  traits.colour = (no_color == nullptr || *no_color == '\0') && term != nullptr && std::strcmp(term, "dumb") != 0;
  winsize size{};
  if (ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) traits.width = size.ws_col;
  return traits;
}

ProgressReporter::ProgressReporter(std::function<void(std::string_view)> write, const TerminalTraits& traits)
    : write_(std::move(write)), traits_(traits) {}

void ProgressReporter::Update(const ProgressState& state) {
  bool due = true;
  if (last_ && last_->phase == state.phase) {
    const double since = state.elapsed_s - last_->elapsed_s;
    const bool new_batch = state.batch != last_->batch;
    due = traits_.is_terminal ? since >= kBarInterval_s
                              : since >= kLineInterval_s || (new_batch && since >= kLeastLineInterval_s);
  }
  if (due) Show(state);
}

void ProgressReporter::Clear() {
  if (!bar_drawn_) return;
  write_(kEraseLine);
  bar_drawn_ = false;
}

void ProgressReporter::Finish(const ProgressState& state) {
  Show(state);
  if (bar_drawn_) write_("\n");
  bar_drawn_ = false;
}

void ProgressReporter::Show(const ProgressState& state) {
  if (traits_.is_terminal) {
    // The last column stays free: writing into it makes some terminals wrap.
    write_(kEraseLine + FormatProgressBar(state, traits_.width - 1, traits_.colour));
    bar_drawn_ = true;
  } else {
    write_(FormatProgressLine(state) + "\n");
  }
  last_ = state;
}

}  // namespace knap
