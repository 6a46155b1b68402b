#include "sim/transfer/check_transfer.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <string_view>
#include <variant>

#include "sim/scenarios/check_rules.h"

namespace knap {
namespace {

constexpr std::array<std::string_view, 7> kJointNames = {"fixed", "prescribed", "revolute", "prismatic",
                                                         "ball",  "planar",     "free"};
static_assert(kJointNames.size() == std::variant_size_v<JointKind>);

bool IsFree(const Scene& scene, const std::string& name) {
  const Body* body = FindBody(scene, name);
  return body != nullptr && std::holds_alternative<FreeJoint>(body->joint.kind);
}

}  // namespace

std::vector<std::string> FindTransferFaults(const Scene& scene) {
  std::vector<std::string> faults;
  const auto add = [&](const std::string& field, const std::string& what) {
    faults.push_back(fmt::format("{}: the engine bullet has {}", field, what));
  };
  for (const Body& body : scene.bodies) {
    const std::string path = "bodies." + body.name;
    const bool is_free = std::holds_alternative<FreeJoint>(body.joint.kind);
    const bool is_led =
        std::holds_alternative<FixedJoint>(body.joint.kind) || std::holds_alternative<PrescribedJoint>(body.joint.kind);
    if (!is_free && !is_led) {
      add(path + ".joint.type",
          fmt::format("no {} joints: only fixed, prescribed and free ones", kJointNames[body.joint.kind.index()]));
    }
    if (IsFree(scene, body.parent)) {
      add(path + ".parent", fmt::format("no bodies that hang on a free one, '{}'", body.parent));
    }
    if (is_free && FindShape<HalfSpaceShape>(body) != nullptr) add(path + ".shapes", "no half-spaces of free bodies");
  }
  for (std::size_t i = 0; i < scene.grips.size(); ++i) {
    if (IsFree(scene, scene.grips[i].body)) {
      add(fmt::format("grips[{}].body", i), fmt::format("no grips of a free body, '{}'", scene.grips[i].body));
    }
  }
  if (scene.controls) add("controls", "no actuators");
  if (scene.policy) add("policy", "no actuators");
  for (const Signal& signal : scene.signals) {
    const std::string path = "signals." + signal.name;
    if (std::holds_alternative<ForceSignal>(signal.kind)) add(path, "rigid contacts, whose forces are no signals");
    if (std::holds_alternative<CommandSignal>(signal.kind)) add(path, "no actuators");
  }
  return faults;
}

}  // namespace knap
