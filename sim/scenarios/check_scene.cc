#include "sim/scenarios/check_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "sim/scenarios/check_actuation.h"
#include "sim/scenarios/check_objective.h"
#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/check_values.h"
#include "sim/scenarios/check_variation.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr double kMostEvaluations = 1e9;  // of a whole learning

class SceneChecker {
 public:
  SceneChecker(Scene& scene, FieldLog& log) : scene_(scene), log_(log) {}

  void Check() {
    for (const Body& body : scene_.bodies) CheckBody(body);
    for (std::size_t i = 0; i < scene_.contacts.size(); ++i) CheckContact(i);
    for (std::size_t i = 0; i < scene_.grips.size(); ++i) CheckGrip(i);
    CheckDesign();
    CheckRollout();
    CheckPerturbation();
    CheckObjective(scene_, log_);
    for (const ValueFault& fault : FindValueFaults(scene_)) Report(fault.paths, fault.message);
    CheckActuation(scene_, log_);
    CheckVariation(scene_, log_);
    CheckLearning();
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  void CheckPerturbation() {
    if (!scene_.perturbation) return;
    std::vector<std::string> names;
    for (const StartPerturbation& start : scene_.perturbation->starts) {
      names.push_back(start.name);
      const std::string path = "perturbation.starts." + start.name;
      if (const Rope* rope = FindRope(scene_, start.name)) {
        if (std::holds_alternative<HelixState>(rope->initial) && start.across != 0.0) {
          Report({path + ".across"}, "a helix moves along its axis alone: expected 0");
        }
      } else if (const Body* body = FindBody(scene_, start.name)) {
        if (body->parent == kWorldName && std::holds_alternative<FreeJoint>(body->joint.kind)) continue;
        Report({path + ".name"}, "must be a body with a free joint to the world, or a rope");
      }
    }
    if (HasRepeats(names)) Report({"perturbation.starts"}, "each start at most once");
  }

  // Bodies without a valid name have been reported, and nothing can refer to them.
  void CheckBody(const Body& body) {
    if (body.name.empty()) return;
    const std::string path = "bodies." + body.name;
    CheckAncestors(body, path);
    const bool moves_by_force = !std::holds_alternative<FixedJoint>(body.joint.kind) &&
                                !std::holds_alternative<PrescribedJoint>(body.joint.kind);
    if (moves_by_force && !body.inertia) {
      Report({path + ".inertia", path + ".joint.type"},
             "a body that forces move needs an inertia; only fixed and prescribed ones do without");
    }
    if (body.inertia) CheckInertia(body, path + ".inertia");
    bool is_designed = false;
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      if (!std::holds_alternative<DesignedMeshShape>(body.shapes[i].kind)) continue;
      if (is_designed) Report({GetShapePath(body, i) + ".type"}, "a body has at most one designed_mesh");
      is_designed = true;
    }
  }

  void CheckAncestors(const Body& body, const std::string& path) {
    const Body* ancestor = &body;
    std::string chain = body.name;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      ancestor = FindBody(scene_, ancestor->parent);
      if (ancestor == nullptr) return;
      chain += " → " + ancestor->name;
      if (ancestor != &body) continue;
      Report({path + ".parent"}, fmt::format("the bodies must form a tree, but here is a cycle: {}", chain));
      return;
    }
  }

  void CheckInertia(const Body& body, const std::string& path) {
    if (std::holds_alternative<ExplicitInertia>(*body.inertia)) return;
    if (body.shapes.empty() || FindShape<HalfSpaceShape>(body) != nullptr) {
      Report({path + ".type", path, "bodies." + body.name + ".shapes"},
             "needs shapes with a volume (sphere, capsule, cylinder, box, designed_mesh or mesh) and no other; else "
             "give an explicit inertia");
    }
  }

  void CheckContact(std::size_t i) {
    const std::string path = fmt::format("contacts[{}].bodies", i);
    const auto& [first, second] = scene_.contacts[i].bodies;
    const Body* a = FindBody(scene_, first);
    const Body* b = FindBody(scene_, second);
    const bool has_rope = FindRope(scene_, first) != nullptr || FindRope(scene_, second) != nullptr;
    if (!has_rope && (a == nullptr || b == nullptr)) return;  // reported where the name is read
    if (!has_rope && a == b) {
      Report({path}, "a contact needs two different bodies");
      return;
    }
    for (std::size_t earlier = 0; earlier < i; ++earlier) {
      const auto& [c, d] = scene_.contacts[earlier].bodies;
      if ((c == first && d == second) || (c == second && d == first)) {
        Report({path}, fmt::format("{} and {} already have a contact, contacts[{}]", first, second, earlier));
        return;
      }
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const Body* body = side == 0 ? a : b;
      if (body == nullptr || !body->shapes.empty()) continue;
      Report({fmt::format("{}[{}]", path, side), fmt::format("bodies.{}.shapes", scene_.contacts[i].bodies[side])},
             "this body has no shape to touch with");
    }
  }

  void CheckGrip(std::size_t i) {
    const Grip& grip = scene_.grips[i];
    const std::string path = fmt::format("grips[{}]", i);
    if (grip.body == grip.held && !grip.body.empty()) Report({path + ".held"}, "a body cannot hold itself");
  }

  void CheckDesign() {
    if (scene_.design) {
      for (const DesignedBody& body : scene_.design->bodies) CheckDesignedBody(body);
      for (const DesignParameter& parameter : scene_.design->parameters) CheckParameter(parameter);
    }
    // An entry that is wrong or of the wrong body may be what the following misses.
    if (log_.HasFailedNear("design.bodies") || HasMisplacedDesign()) return;
    for (const Body& body : scene_.bodies) {
      const std::string path = "bodies." + body.name;
      if (IsDesigned(body) && CountDesigns(body.name) == 0) {
        const std::size_t index = static_cast<std::size_t>(FindShape<DesignedMeshShape>(body) - body.shapes.data());
        Report({GetShapePath(body, index) + ".type", path}, scene_.design
                                                                ? "needs an entry of design.bodies that gives the mesh"
                                                                : "needs a section 'design' that gives the mesh");
      }
      if (body.joint.attachment && CountDesigns(body.parent) == 0) {
        Report({path + ".joint.attachment", path + ".parent"},
               "only a designed parent has a mesh that joints move with");
      }
    }
  }

  static bool IsDesigned(const Body& body) { return FindShape<DesignedMeshShape>(body) != nullptr; }

  bool HasMisplacedDesign() const {
    if (!scene_.design) return false;
    const std::vector<DesignedBody>& bodies = scene_.design->bodies;
    return std::any_of(bodies.begin(), bodies.end(), [&](const DesignedBody& designed) {
      const Body* body = FindBody(scene_, designed.name);
      return body != nullptr && !IsDesigned(*body);
    });
  }

  std::ptrdiff_t CountDesigns(const std::string& name) const {
    if (!scene_.design) return 0;
    const std::vector<DesignedBody>& bodies = scene_.design->bodies;
    return std::count_if(bodies.begin(), bodies.end(), [&](const DesignedBody& b) { return b.name == name; });
  }

  void CheckDesignedBody(const DesignedBody& designed) {
    const Body* body = FindBody(scene_, designed.name);
    if (body == nullptr) return;
    const std::string path = "design.bodies." + designed.name;
    if (!IsDesigned(*body)) {
      Report({path + ".name", "bodies." + designed.name + ".shapes"},
             "one of the shapes of this body must be of type designed_mesh");
    }
    if (CountDesigns(designed.name) > 1) Report({path + ".name"}, "is given twice");
    for (const VertexGroup& group : designed.vertex_groups) {
      if (HasRepeats(group.vertices)) {
        Report({path + ".vertex_groups." + group.name + ".vertices"}, "names a vertex twice");
      }
      CheckGroup(group, path + ".vertex_groups." + group.name);
    }
    for (std::size_t i = 0; i < designed.moves.size(); ++i) {
      const std::string& name = designed.moves[i].group;
      const bool own = std::any_of(designed.vertex_groups.begin(), designed.vertex_groups.end(),
                                   [&](const VertexGroup& group) { return group.name == name; });
      const std::string move = fmt::format("{}.moves[{}].group", path, i);
      if (!own && !log_.HasFailedNear(move)) Report({move}, "is a vertex group of another body");
    }
  }

  void CheckGroup(const VertexGroup& group, const std::string& path) {
    const int ways = (group.vertices.empty() ? 0 : 1) + (group.box ? 1 : 0) + (group.plane ? 1 : 0);
    if (ways != 1 && !log_.HasFailedNear(path)) {
      Report({path + ".name"}, "needs one of vertices, box and plane to say which vertices of the cage it has");
    }
    for (int k = 0; group.box && k < 3; ++k) {
      if (group.box->lower[k] <= group.box->upper[k]) continue;
      Report({fmt::format("{}.box.lower[{}]", path, k)},
             fmt::format("must not be more than upper, {}", FormatQuantity(group.box->upper[k], kLength)));
    }
    if (group.plane && !(group.plane->normal.norm() > 0.0)) {
      Report({path + ".plane.normal"}, "must not be zero");
    }
  }

  void CheckParameter(const DesignParameter& parameter) {
    if (parameter.name.empty()) return;
    const std::string path = "design.parameters." + parameter.name;
    const Dimension dimension = parameter.kind == ParameterKind::kStretch ? kDimensionless : kLength;
    if (parameter.lower >= parameter.upper) {
      Report({path + ".lower", path + ".upper"},
             fmt::format("must be less than upper, {}", FormatQuantity(parameter.upper, dimension)));
    } else if (parameter.initial < parameter.lower || parameter.initial > parameter.upper) {
      Report({path + ".initial", path + ".lower", path + ".upper"},
             fmt::format("must lie from lower, {}, to upper, {}", FormatQuantity(parameter.lower, dimension),
                         FormatQuantity(parameter.upper, dimension)));
    }
    for (const DesignedBody& body : scene_.design->bodies) {
      for (const CageMove& move : body.moves) {
        if (move.parameter == parameter.name && move.direction.norm() > 0.0) return;
      }
    }
    Report({path + ".name", "design.bodies"}, "moves no vertex of a cage; see design.bodies");
  }

  void CheckRollout() {
    const Rollout& rollout = scene_.rollout;
    if (!IsWholeMultiple(rollout.horizon, rollout.step)) {
      Report({"rollout.horizon", "rollout.step"},
             fmt::format("must be a whole number of steps of {}", FormatQuantity(rollout.step, kTime)));
    } else if (rollout.horizon / rollout.step > kMostSteps) {
      Report({"rollout.horizon", "rollout.step"},
             fmt::format("these are {:.0f} steps of {}, at most {:.0f} are allowed", rollout.horizon / rollout.step,
                         FormatQuantity(rollout.step, kTime), kMostSteps));
    }
  }

  // Where nothing varies there is one rollout to learn from and one to test; what the file says must not differ.
  void SettleWithoutVariation() {
    const std::pair<std::string, std::int64_t*> counts[] = {
        {"learning.variations", &scene_.learning.variations},
        {"learning.batch", &scene_.learning.batch},
        {"evaluation.variations", &scene_.evaluation.variations},
    };
    for (const auto& [path, count] : counts) {
      if (log_.IsGiven(path) && *count != 1) {
        Report({path}, "the scenario has no section variation, so all rollouts are alike: must be 1");
      }
      *count = 1;
    }
    // Every batch then sees all that there is.
    scene_.learning.validation = 0;
  }

  // Where the file does not say how many parameters move in a batch, it is no more than there are.
  void SettleDimensions() {
    if (!scene_.design || log_.IsGiven("learning.dimensions_per_batch")) return;
    const auto d = static_cast<std::int64_t>(scene_.design->parameters.size());
    std::int64_t& moving = scene_.learning.dimensions_per_batch;
    moving = std::min(moving, std::max<std::int64_t>(d, 1));
  }

  void CheckLearning() {
    if (scene_.variation.empty() && !log_.HasFailedNear("variation")) SettleWithoutVariation();
    SettleDimensions();
    const Learning& learning = scene_.learning;
    if (learning.batch > learning.variations) {
      Report({"learning.batch", "learning.variations"},
             fmt::format("a batch has at most all {} variations", learning.variations));
    }
    const double batches = std::ceil(static_cast<double>(learning.variations) / static_cast<double>(learning.batch));
    const double evaluations = static_cast<double>(learning.max_evaluations) * batches;
    if (evaluations > kMostEvaluations) {
      Report({"learning.max_evaluations", "learning.variations", "learning.batch"},
             fmt::format("{:.0f} evaluations in all {:.0f} batches, at most {:.0f} are allowed", evaluations, batches,
                         kMostEvaluations));
    }
    if (!scene_.design) return;
    const auto d = static_cast<std::int64_t>(scene_.design->parameters.size());
    if (learning.dimensions_per_batch > d) {
      Report({"learning.dimensions_per_batch", "design.parameters"},
             fmt::format("must be at most the number of design parameters, {}", d));
    }
  }

  Scene& scene_;
  FieldLog& log_;
};

}  // namespace

void CheckScene(Scene& scene, FieldLog& log) { SceneChecker(scene, log).Check(); }

}  // namespace knap
