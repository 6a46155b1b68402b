#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "coordinator/explain/explanation.h"
#include "coordinator/explain/explanation_text.h"
#include "coordinator/progress/progress.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {
namespace {

constexpr std::size_t kMostWorkers = 12;
constexpr std::size_t kMostSlow = 5;

std::string CountThings(std::size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

void AddLives(const RunRecord& record, Explanation* text) {
  for (const RecordedLife& life : record.lives) {
    std::string line = fmt::format("{} to {}, {}", FormatDuration(life.begin_s), FormatDuration(life.end_s),
                                   life.end.empty() ? "no end on record" : life.end);
    if (!life.error.empty()) line += ": " + life.error;
    if (life.answers_from_journal > 0) {
      line += fmt::format("; went on with {} answers of the journal", life.answers_from_journal);
    }
    text->Add(record.lives.size() > 1 ? "lives" : "life", line);
  }
}

void AddCounts(const RunRecord& record, Explanation* text) {
  std::map<std::string, std::size_t> kinds;
  std::set<std::string> ids;
  for (const RolloutRow& answer : record.answers) {
    ++kinds[answer.kind];
    ids.insert(answer.id);
  }
  std::string by_kind;
  const auto add = [&](const std::string& kind) {
    const auto found = kinds.find(kind);
    if (found == kinds.end()) return;
    by_kind += fmt::format("{}{} {}", by_kind.empty() ? ": " : ", ", found->second, kind);
    kinds.erase(found);
  };
  for (const char* kind : {"task", "distillation", "validation", "test"}) add(kind);
  while (!kinds.empty()) add(std::string(kinds.begin()->first));
  text->Add("requests", fmt::format("{} answered{}", record.answers.size(), by_kind));
  if (const std::size_t twice = record.answers.size() - ids.size(); twice > 0) {
    text->Add(
        "",
        fmt::format("{} of them a second time: the first answer was not yet in the journal when the run ended", twice));
  }
}

// Attempts between those on record: each was taken from a worker's queue for one that had nothing to do.
std::size_t CountMoves(const RunRecord& record) {
  std::map<std::pair<std::string, std::size_t>, std::set<int>> recorded;  // by id and life
  for (const RequestSetback& setback : record.setbacks) {
    std::set<int>& attempts = recorded[{setback.id.substr(0, kShortDigits), setback.life}];
    if (setback.why != "message_lost") attempts.insert(setback.attempt);
    if (setback.copy_attempt > 0) attempts.insert(setback.copy_attempt);
  }
  std::size_t moves = 0;
  for (const RolloutRow& answer : record.answers) {
    if (answer.attempt <= 1) continue;
    const auto found = recorded.find({answer.id.substr(0, kShortDigits), record.FindLife(answer.time_s)});
    for (int number = 1; number < answer.attempt; ++number) {
      moves += found == recorded.end() || found->second.count(number) == 0 ? 1 : 0;
    }
  }
  return moves;
}

void AddSentAgain(const RunRecord& record, Explanation* text) {
  if (!record.tells_why) {
    if (record.reissued + record.copied > 0) {
      text->Add("again",
                fmt::format("{} given to another worker, {} second copies of stragglers; an earlier version of "
                            "knap did not write down which, and why",
                            record.reissued, record.copied));
    } else {
      text->Add("again", "none");
    }
    return;
  }
  std::map<std::string, std::pair<std::size_t, std::string>> counts;  // by why: how many, and the first
  for (const RequestSetback& setback : record.setbacks) {
    const auto [entry, is_new] = counts.try_emplace(setback.why, 0, setback.id);
    ++entry->second.first;
  }
  // Lists in events end somewhere; of copies there is a count.
  if (const auto copies = counts.find("straggler"); copies != counts.end()) {
    copies->second.first = std::max(copies->second.first, static_cast<std::size_t>(record.copied));
  }
  std::vector<std::string> lines;
  for (const auto& [why, entry] : counts) {
    lines.push_back(fmt::format("{:>5}  {} ({}{})", entry.first, DescribeWhy(why),
                                entry.first == 1 ? "" : "the first: ", entry.second));
  }
  if (const std::size_t moves = CountMoves(record); moves > 0) {
    lines.push_back(fmt::format("{:>5}  moved from a worker's queue to a worker that had nothing to do", moves));
  }
  if (lines.empty()) lines.emplace_back("none");
  for (const std::string& line : lines) text->Add("again", line);
}

void AddWorkers(const RunRecord& record, Explanation* text) {
  std::size_t shown = 0;
  for (const GoneWorker& gone : record.gone) {
    if (++shown > kMostWorkers) continue;
    const std::string life = record.lives.size() > 1 ? fmt::format(" (life {})", 1 + record.FindLife(gone.time_s)) : "";
    text->Add("workers", fmt::format("{}{}  {} on {}: {}, with {}", FormatInstant(gone.time_s), life, gone.worker,
                                     gone.host, DescribeGone(gone.why),
                                     gone.held == 0 ? "nothing to do" : CountThings(gone.held, "request")));
  }
  if (shown > kMostWorkers) text->Add("workers", fmt::format("and {} more", shown - kMostWorkers));
  for (const auto& [time_s, line] : record.remarks) {
    if (++shown > 2 * kMostWorkers) break;
    text->Add("workers", fmt::format("{}  {}", FormatInstant(time_s), line));
  }
  if (shown > 0) return;
  text->Add("workers", record.workers_lost == 0
                           ? "none was lost"
                           : fmt::format("{} lost; which, and when, an earlier version of knap did "
                                         "not write down",
                                         record.workers_lost));
}

void AddSlowest(const RunRecord& record, Explanation* text) {
  std::vector<const RolloutRow*> rows;
  for (const RolloutRow& answer : record.answers) {
    if (CalcComputing(answer) >= 0.0) rows.push_back(&answer);
  }
  if (rows.empty()) return;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const RolloutRow* a, const RolloutRow* b) { return CalcComputing(*a) > CalcComputing(*b); });
  for (std::size_t i = 0; i < std::min(rows.size(), kMostSlow); ++i) {
    const RolloutRow& row = *rows[i];
    text->Add("slowest", fmt::format("{}  {:>8} on {} ({}), {}", row.id.substr(0, kShortDigits),
                                     FormatSpan(CalcComputing(row)), row.worker, DescribeComputing(row), row.kind));
  }
  text->Add("slowest", fmt::format("half of all take less than {}", FormatSpan(CalcComputing(*rows[rows.size() / 2]))));
}

void AddPresent(const ExplainedRun& run, Explanation* text) {
  if (!run.live) {
    text->Add("now", run.silence);
    return;
  }
  text->Add("now", fmt::format("goes on: {} open, {}", CountThings(static_cast<std::size_t>(run.live->open), "request"),
                               CountThings(static_cast<std::size_t>(run.live->workers), "worker")));
  std::int64_t held = 0;
  std::size_t shown = 0;
  for (const LiveWorker& worker : run.live->heard) {
    held += static_cast<std::int64_t>(worker.held.size());
    if (worker.held.empty() || ++shown > kMostWorkers) continue;
    const std::string first = FormatShort(worker.held.front());
    text->Add("now", fmt::format("{} {} {}{}", worker.name, worker.computes ? "computes" : "has", first,
                                 worker.computes ? fmt::format(" ({:.0f}%)", 100.0 * worker.step_fraction) : "") +
                         (worker.held.size() > 1 ? fmt::format(", {} behind it", worker.held.size() - 1) : ""));
  }
  if (shown > kMostWorkers) text->Add("now", fmt::format("and {} more workers", shown - kMostWorkers));
  // Two statuses at two instants: a difference below 0 is one of time.
  if (run.live->open > held) {
    text->Add("now", fmt::format("{} with no worker, or on the way to one", run.live->open - held));
  }
}

}  // namespace

std::string ExplainRun(const ExplainedRun& run) {
  const RunRecord& record = run.record;
  Explanation text;
  text.Add("run", fmt::format("{}: {}, {}, seed {}, begun {} on {}", run.path, record.scenario, record.method,
                              record.seed, record.started, record.host));
  AddLives(record, &text);
  AddCounts(record, &text);
  AddSentAgain(record, &text);
  AddWorkers(record, &text);
  AddSlowest(record, &text);
  AddPresent(run, &text);
  text.Add("one alone", fmt::format("knap explain {} ID", run.path));
  return text.Take();
}

}  // namespace knap
