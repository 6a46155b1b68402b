// The program knap.
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "coordinator/cli/cage_command.h"
#include "coordinator/cli/evaluate_command.h"
#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/explain_command.h"
#include "coordinator/cli/export_command.h"
#include "coordinator/cli/gradcheck_command.h"
#include "coordinator/cli/import_command.h"
#include "coordinator/cli/landscape_command.h"
#include "coordinator/cli/learn_command.h"
#include "coordinator/cli/repair_command.h"
#include "coordinator/cli/report_command.h"
#include "coordinator/cli/rollout_command.h"
#include "coordinator/cli/status_command.h"
#include "coordinator/cli/study_command.h"
#include "coordinator/cli/trace_command.h"
#include "coordinator/cli/train_policy_command.h"
#include "coordinator/cli/validate_command.h"
#include "coordinator/cli/verify_log_command.h"
#include "coordinator/cli/watch_command.h"
#include "coordinator/run/loaded_run.h"
#include "lcmtypes/program/command_line.h"
#include "lcmtypes/program/standard_streams.h"

int main(int argc, char** argv) {
  knap::SecureStandardStreams();
  CLI::App app("Learns the shape of a robot's tool on a cluster of differentiable simulators.", "knap");
  app.set_version_flag(
      "--version", [] { return "knap " KNAP_VERSION ", build " + knap::FindBuild() + "\nwith " KNAP_LIBRARIES; },
      "version, build and libraries");
  app.require_subcommand(1);
  std::function<int()> command;
  knap::AddLearnCommand(&app, &command);
  knap::AddStudyCommand(&app, &command);
  knap::AddTrainPolicyCommand(&app, &command);
  knap::AddEvaluateCommand(&app, &command);
  knap::AddGradcheckCommand(&app, &command);
  knap::AddLandscapeCommand(&app, &command);
  knap::AddImportCommand(&app, &command);
  knap::AddCageCommand(&app, &command);
  knap::AddExplainCommand(&app, &command);
  knap::AddExportCommand(&app, &command);
  knap::AddRepairCommand(&app, &command);
  knap::AddReportCommand(&app, &command);
  knap::AddRolloutCommand(&app, &command);
  knap::AddTraceCommand(&app, &command);
  knap::AddValidateCommand(&app, &command);
  knap::AddStatusCommand(&app, &command);
  knap::AddWatchCommand(&app, &command);
  knap::AddVerifyLogCommand(&app, &command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return knap::EndParsing(app, e);
  }
  return knap::RunCommand(command);
}
