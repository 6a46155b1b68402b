#include "coordinator/cli/repair_command.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/journal_repair.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

// "3, 5 to 8".
std::string FormatNumbers(const std::vector<std::uint64_t>& numbers) {
  std::string text;
  for (std::size_t first = 0, end = 0; first < numbers.size(); first = end) {
    for (end = first + 1; end < numbers.size() && numbers[end] == numbers[end - 1] + 1;) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", numbers[first]);
    if (end > first + 1) text += fmt::format(" to {}", numbers[end - 1]);
  }
  return text;
}

std::string FormatRepair(const JournalRepair& repair, const RunDirectory& run) {
  std::size_t answers = 0;
  for (const std::string& payload : repair.payloads) answers += DecodeAnswers(payload).size();
  std::string text = fmt::format("{}: {} records with {} answers are whole\n", CleanText(run.journal_path().string()),
                                 repair.payloads.size(), answers);
  if (!repair.changed) return text + "nothing is damaged, and nothing was changed\n";
  if (repair.header_lost) text += "lost: the header, written again from run.json\n";
  if (!repair.missing.empty()) text += fmt::format("lost: record {}\n", FormatNumbers(repair.missing));
  for (const JournalRepair::Stretch& stretch : repair.damaged) {
    text += fmt::format("damaged: {} bytes at byte {}\n", stretch.bytes, stretch.offset);
  }
  if (!repair.set_aside.empty()) text += fmt::format("set aside: {}\n", CleanText(repair.set_aside.string()));
  const bool is_study = std::filesystem::exists(run.path() / "study.json");
  return text + fmt::format("what is lost is computed again, to the same bits, by: knap {} --resume {}\n",
                            is_study ? "study" : "learn", CleanText(run.path().string()));
}

int RunRepair(const std::string& path) {
  const RunDirectory run = OpenRun(path);
  if (!std::filesystem::exists(run.journal_path())) {
    throw UsageError(fmt::format("{}: the run has no journal: nothing was answered yet", run.journal_path().string()));
  }
  WriteOutput(FormatRepair(RepairJournal(run.journal_path(), run.ReadIdentity()), run));
  return kExitDone;
}

}  // namespace

void AddRepairCommand(CLI::App* app, std::function<int()>* command) {
  const auto path = std::make_shared<std::string>();
  CLI::App* repair =
      app->add_subcommand("repair", "Keeps what is whole in a run's damaged journal, so that it resumes");
  repair->add_option("run", *path, "run or study directory")->required();
  repair->callback([path, command] { *command = [path] { return RunRepair(*path); }; });
}

}  // namespace knap
