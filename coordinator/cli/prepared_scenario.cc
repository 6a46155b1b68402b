#include "coordinator/cli/prepared_scenario.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/loaded_run.h"
#include "coordinator/cli/problem_from_scene.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/wire/scenario_bundle.h"
#include "sim/geometry/mesh_io.h"

namespace knap {

namespace fs = std::filesystem;

PreparedScenario PrepareScenario(const fs::path& config, std::span<const std::string> overrides) {
  PreparedScenario prepared;
  prepared.scenario = LoadValidScenario(config, overrides);
  try {
    prepared.problem = MakeProblem(prepared.scenario.parsed.scene);
    prepared.options = MakeLearningOptions(prepared.scenario.parsed.scene);
    prepared.model = std::make_unique<RolloutModel>(prepared.scenario.files);
  } catch (const std::exception& e) {
    throw UsageError(fmt::format("{}: {}", config.string(), e.what()));
  }
  prepared.config_hash = FormatHex(CalcScenarioId(EncodeBundle(prepared.scenario.files)));
  return prepared;
}

RunIdentity MakeRunIdentity(const RunInfo& info, const EngineIdentity& engine) {
  return {{"configuration", info.config_hash},
          {"engine", engine.name},
          {"build of knap-worker", engine.build},
          {"arithmetic (processor or mathematical library)", FormatHex(engine.fingerprint)}};
}

Journal::Opened OpenRunJournal(const RunDirectory& run, const RunIdentity& identity) try {
  if (!fs::exists(run.journal_path())) return {Journal::Create(run.journal_path(), identity), {}, 0};
  return Journal::Open(run.journal_path(), identity);
} catch (const std::system_error&) {
  throw;
} catch (const std::runtime_error& e) {
  throw UsageError(e.what());  // not the journal of this run
}

void WriteTools(const std::optional<SceneDesign>& design, const std::vector<double>& theta, const fs::path& folder,
                const std::string& name) {
  if (!design) return;
  fs::create_directories(folder);
  const Eigen::Map<const Eigen::VectorXd> values(theta.data(), design->num_parameters());
  for (const std::string& body : design->bodies()) {
    const std::string file = design->bodies().size() == 1 ? name + ".stl" : name + "_" + body + ".stl";
    WriteFileAtomically(folder / file, WriteStl(design->Find(body)->CalcMesh(values)));
  }
}

}  // namespace knap
