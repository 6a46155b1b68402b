#include "coordinator/run/perturbed_scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "coordinator/run/usage_error.h"
#include "sim/scenarios/dump_scene.h"

namespace knap {
namespace {

constexpr double kFactor = 0.25;
constexpr double kShift = 2e-3;                           // [m]
constexpr double kTurn = 2.0 * std::numbers::pi / 180.0;  // [rad]

void Vary(Scene* scene, const std::string& key, double middle, double half_width) {
  Variation variation;
  variation.keys = {fmt::format("perturbation.{}", key)};
  variation.distribution = UniformDistribution{middle - half_width, middle + half_width};
  scene->variation.push_back(std::move(variation));
}

}  // namespace

void AddPerturbation(LoadedScenario* scenario) {
  Scene& scene = scenario->parsed.scene;
  if (scene.perturbation) {
    throw UsageError(fmt::format("--perturb: {} has a section `perturbation` of its own", scenario->parsed.file_name));
  }
  Perturbation perturbation;
  bool is_led = false;
  std::vector<std::string> helices;
  for (const Body& body : scene.bodies) {
    is_led = is_led || std::holds_alternative<PrescribedJoint>(body.joint.kind);
    if (body.parent == kWorldName && std::holds_alternative<FreeJoint>(body.joint.kind)) {
      perturbation.starts.push_back({.name = body.name});
    }
  }
  const bool moves = std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& body) {
    return !std::holds_alternative<PrescribedJoint>(body.joint.kind) &&
           !std::holds_alternative<FixedJoint>(body.joint.kind);
  });
  for (const Rope& rope : scene.ropes) {
    if (std::holds_alternative<HelixState>(rope.initial)) helices.push_back(rope.name);
    perturbation.starts.push_back({.name = rope.name});
  }
  if (!scene.contacts.empty()) Vary(&scene, "friction", 1.0, kFactor);
  if (moves || !scene.ropes.empty()) Vary(&scene, "mass", 1.0, kFactor);
  if (is_led) Vary(&scene, "speed", 1.0, kFactor);
  for (const StartPerturbation& start : perturbation.starts) {
    const std::string key = fmt::format("starts.{}", start.name);
    Vary(&scene, key + ".along", 0.0, kShift);
    if (std::find(helices.begin(), helices.end(), start.name) == helices.end())
      Vary(&scene, key + ".across", 0.0, kShift);
    Vary(&scene, key + ".turn", 0.0, kTurn);
  }
  scene.perturbation = std::move(perturbation);
  scenario->files[kScenarioFileName] = DumpScene(scene);
}

}  // namespace knap
