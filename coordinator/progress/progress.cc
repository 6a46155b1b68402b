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

// The most important first.
std::vector<Figure> MakeFigures(const ProgressState& state) {
  std::vector<Figure> figures;
  const std::optional<double> left = CalcTimeLeft(state);
  figures.push_back({fmt::format("{:3.0f}%", std::floor(100.0 * CalcDonePart(state)))});
  figures.push_back({fmt::format("ETA {}", left ? FormatDuration(*left) : "-:--")});
  if (state.phase == ProgressPhase::kLearning) {
    figures.push_back({fmt::format("batch {}/{}", state.batch, state.batches)});
    figures.push_back({fmt::format("evaluation {}", state.evaluation)});
    figures.push_back({"loss " + FormatLoss(state.loss, state.loss_unit)});
    figures.push_back({"best " + FormatLoss(state.best_loss, state.loss_unit)});
  } else if (state.phase == ProgressPhase::kTesting) {
    figures.push_back({fmt::format("tested {}/{}", state.tested, state.tests)});
  } else {
    figures.push_back({fmt::format("runs {}/{}", state.runs_done, state.runs)});
  }
  const bool missing = state.workers_alive < std::max(1, state.workers_wanted);
  figures.push_back({state.workers_wanted > 0 ? fmt::format("workers {}/{}", state.workers_alive, state.workers_wanted)
                                              : fmt::format("workers {}", state.workers_alive),
                     missing});
  figures.push_back({fmt::format("rollouts {}", state.rollouts)});
  figures.push_back({fmt::format("retries {}", state.retries), state.retries > 0});
  return figures;
}

std::string MakePaint(const std::string& text, const char* colour, bool enabled) {
  return enabled ? colour + text + kPlain : text;
}

}  // namespace

double CalcDonePart(const ProgressState& state) {
  const auto rollouts = static_cast<double>(state.rollouts);
  const auto tests = static_cast<double>(state.tests);
  double done = 0.0;
  if (state.phase == ProgressPhase::kTesting) {
    const double learned = std::max(0.0, rollouts - static_cast<double>(state.tested));
    if (state.tests > 0) done = (learned + static_cast<double>(state.tested)) / (learned + tests);
  } else if (state.phase == ProgressPhase::kStudying) {
    done = state.study_part;
  } else if (state.batches > 0 && state.batch > 0) {
    const double within =
        state.max_evaluations > 0 ? std::min(1.0, static_cast<double>(state.evaluation) / state.max_evaluations) : 0.0;
    done = (state.batch - 1 + within) / state.batches;
    // Of rollouts/done + tests.
    if (state.rollouts > 0) done *= rollouts / (rollouts + tests * done);
  }
  return std::clamp(done, 0.0, 1.0);
}

std::optional<double> CalcTimeLeft(const ProgressState& state) {
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
  constexpr int kLeastBar = 10, kLargestBar = 40;
  const std::vector<Figure> figures = MakeFigures(state);
  // Space for "[", "]" and the least bar first; then figures while they fit; what remains widens the bar.
  int left = std::max(20, width) - kLeastBar - 2;
  std::size_t count = 0;
  while (count < figures.size() && static_cast<int>(figures[count].text.size()) + 1 <= left) {
    left -= static_cast<int>(figures[count].text.size()) + 1;
    ++count;
  }
  const bool titled = static_cast<int>(state.title.size()) + 1 <= left;
  if (titled) left -= static_cast<int>(state.title.size()) + 1;
  const int cells = std::min(kLargestBar, kLeastBar + left);
  const auto full = static_cast<std::size_t>(CalcDonePart(state) * cells);

  std::string line = titled ? state.title + " [" : "[";
  line += MakePaint(std::string(full, '#'), kCyan, colour && full > 0);
  line += std::string(static_cast<std::size_t>(cells) - full, '.') + "]";
  for (std::size_t i = 0; i < count; ++i) {
    line.append(1, ' ').append(MakePaint(figures[i].text, kYellow, colour && figures[i].warning));
  }
  return line;
}

std::string FormatProgressLine(const ProgressState& state) {
  std::string line = fmt::format("{} {}", FormatDuration(state.elapsed_s), state.title);
  for (const Figure& figure : MakeFigures(state)) {
    line += "  " + figure.text.substr(figure.text.find_first_not_of(' '));
  }
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
