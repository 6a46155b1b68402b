#include "coordinator/run/prepared_scenario.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>

#include "coordinator/run/loaded_run.h"
#include "coordinator/run/problem_from_scene.h"
#include "coordinator/run/request_volume.h"
#include "coordinator/run/tool_files.h"
#include "coordinator/run/usage_error.h"
#include "coordinator/run_directory/durable_file.h"
#include "lcmtypes/wire/scenario_bundle.h"
#include "sim/policy/weights_file.h"
#include "sim/rollout/build_policy.h"
#include "sim/rollout/scene_design.h"

namespace knap {

namespace fs = std::filesystem;

PreparedScenario PrepareScenario(const fs::path& config, std::span<const std::string> overrides) {
  PreparedScenario prepared;
  prepared.scenario = LoadValidScenario(config, overrides);
  try {
    prepared.problem = MakeProblem(prepared.scenario.parsed.scene, prepared.scenario.files);
    prepared.options = MakeLearningOptions(prepared.scenario.parsed.scene);
    prepared.model = std::make_unique<RolloutModel>(prepared.scenario.files);
  } catch (const std::exception& e) {
    throw UsageError(fmt::format("{}: {}", config.string(), e.what()));
  }
  const std::size_t values = prepared.problem.parameters.names.size() + prepared.problem.variations.size();
  const Scene& scene = prepared.scenario.parsed.scene;
  CheckRequestVolume(config.string() + ": evaluation.variations", {static_cast<double>(scene.evaluation.variations)},
                     values);
  // A batch and its distillation set, each query with the reference beside theta.
  CheckRequestVolume(config.string() + ": learning.batch", {2.0, static_cast<double>(scene.learning.batch)},
                     2 * values);
  prepared.config_hash = FormatHex(CalcScenarioId(EncodeBundle(prepared.scenario.files)));
  return prepared;
}

Journal::Opened OpenRunJournal(const RunDirectory& run, const RunIdentity& identity) try {
  if (!fs::exists(run.journal_path())) return {Journal::Create(run.journal_path(), identity), {}, 0};
  return Journal::Open(run.journal_path(), identity);
} catch (const std::system_error&) {
  throw;
} catch (const std::runtime_error& e) {
  throw UsageError(e.what());  // not the journal of this run
}

void WriteTools(const RolloutModel& model, const std::vector<double>& theta, const RunDirectory& run,
                const std::string& name) {
  const Eigen::Map<const Eigen::VectorXd> values(theta.data(), static_cast<Eigen::Index>(theta.size()));
  if (const std::optional<SceneDesign>& design = model.design()) {
    fs::create_directories(run.tool_path());
    for (const std::string& body : design->bodies()) {
      const TriangleMesh mesh = design->Find(body)->CalcMesh(values.head(design->num_parameters()));
      for (const PrintFormat format : {PrintFormat::kStl, PrintFormat::k3mf}) {
        WriteFileAtomically(run.tool_path() / NameToolFile(*design, body, name, format),
                            WritePrintFile(mesh, format, body));
      }
    }
  }
  if (model.scene().policy) {
    fs::create_directories(run.policy_path());
    const std::string remark = fmt::format("{} weights of scenario {}", name, model.scene().name);
    WriteFileAtomically(run.policy_path() / (name + ".txt"),
                        FormatWeights(values.tail(CountWeights(model.scene())), remark));
  }
}

}  // namespace knap
