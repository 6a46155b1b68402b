#include "coordinator/cli/verify_log_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/run/answer_journal.h"
#include "coordinator/run/loaded_run.h"
#include "coordinator/run/run_lives.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/watch/run_recording.h"
#include "lcmtypes/program/standard_streams.h"
#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

struct VerifyArguments {
  std::string log, run, key_file;
};

int RunVerifyLog(const VerifyArguments& arguments) {
  const RunDirectory run = OpenRun(arguments.run);
  const std::vector<RunLife> lives = ReadLives(run);
  const std::string key_file = arguments.key_file.empty() ? lives.back().key_file : arguments.key_file;
  std::set<std::int64_t> run_ids;
  for (const RunLife& life : lives) run_ids.insert(life.run_id);
  std::vector<RunRecording::Answer> answers;
  for (const std::string& payload : Journal::Read(run.journal_path())) {
    for (JournaledAnswer& answer : DecodeAnswers(payload)) answers.emplace_back(answer.id, std::move(answer.outcome));
  }
  const std::size_t journaled = answers.size();
  RunRecording recording(key_file.empty() ? RunKey() : RunKey::ReadFile(key_file), std::move(run_ids),
                         std::move(answers), std::filesystem::exists(run.result_path()));

  if (!std::filesystem::is_regular_file(arguments.log)) throw UsageError(arguments.log + ": no such file");
  lcm::LogFile log(arguments.log, "r");
  if (!log.good()) throw std::runtime_error(arguments.log + ": cannot be read");
  std::int64_t events = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++events;
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    recording.Add(event->eventnum, event->channel, {data, data + event->datalen});
  }
  if (events == 0) throw UsageError(arguments.log + ": holds no event; is it a recording of lcm-logger?");

  const RecordingCounters& counters = recording.counters();
  WriteOutput(fmt::format(
      "{} answers in the journal; recorded: {} events, {} requests, {} results, {} not in the journal, {} messages "
      "damaged or of another key\n",
      journaled, events, counters.requests, counters.results, counters.unjournaled, counters.refused.total()));
  if (const std::optional<std::string> difference = recording.FindDifference()) {
    throw std::runtime_error(fmt::format("{} does not tell {}: {}", arguments.log, arguments.run, *difference));
  }
  WriteOutput(fmt::format("{} tells {}\n", CleanText(arguments.log), CleanText(arguments.run)));
  return kExitDone;
}

}  // namespace

void AddVerifyLogCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* verify = app->add_subcommand(
      "verify-log", "Checks, without computing anything, that a recording by lcm-logger tells a run's journal");
  verify->add_option("log", arguments->log, "file written by lcm-logger")->required();
  verify->add_option("run", arguments->run, "run directory")->required();
  verify->add_option("--key", arguments->key_file, "file with the run's key (default: the run's own)");
  verify->callback([arguments, command] { *command = [arguments] { return RunVerifyLog(*arguments); }; });
}

}  // namespace knap
