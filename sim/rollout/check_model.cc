#include "sim/rollout/check_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sim/contact/pair_rules.h"
#include "sim/geometry/mesh_io.h"
#include "sim/geometry/triangle_mesh.h"
#include "sim/math/overloaded.h"
#include "sim/morphology/cage_fit.h"
#include "sim/policy/weights_file.h"
#include "sim/rollout/build_body.h"
#include "sim/rollout/designed_mesh.h"
#include "sim/rollout/fixed_meshes.h"
#include "sim/rollout/vertex_groups.h"
#include "sim/scenarios/check_actuation.h"
#include "sim/scenarios/check_rules.h"

namespace knap {
namespace {

TouchingKind GetTouchingKind(const Shape& shape) {
  return std::visit(Overloaded{[](const HalfSpaceShape&) { return TouchingKind::kHalfSpace; },
                               [](const SphereShape&) { return TouchingKind::kSphere; },
                               [](const CapsuleShape&) { return TouchingKind::kCapsule; },
                               [](const CylinderShape&) { return TouchingKind::kCylinder; },
                               [](const BoxShape&) { return TouchingKind::kBox; },
                               [](const DesignedMeshShape&) { return TouchingKind::kDesignedMesh; },
                               [](const MeshShape&) { return TouchingKind::kConvexMesh; }},
                    shape.kind);
}

class ModelChecker {
 public:
  explicit ModelChecker(LoadedScenario& scenario)
      : scene_(scenario.parsed.scene), files_(scenario.files), log_(scenario.parsed.log) {}

  void Check() {
    for (const Body& body : scene_.bodies) {
      CheckBody(body);
      for (std::size_t i = 0; i < body.shapes.size(); ++i) CheckFixedMesh(body, i);
    }
    for (std::size_t i = 0; i < scene_.contacts.size(); ++i) CheckContact(i);
    for (std::size_t i = 0; i < scene_.grips.size(); ++i) CheckGrip(i);
    if (scene_.design) {
      for (const DesignedBody& body : scene_.design->bodies) CheckDesign(body);
    }
    if (scene_.policy) CheckWeights(*scene_.policy);
  }

 private:
  void Report(const std::vector<std::string>& paths, const std::string& message) { log_.Report(paths, message); }

  // The body itself or the nearest one above it that forces move; null when its motion is known.
  const Body* FindMover(const Body& body) const {
    const Body* mover = &body;
    for (std::size_t i = 0; i < scene_.bodies.size() && mover != nullptr; ++i) {
      if (!std::holds_alternative<FixedJoint>(mover->joint.kind) &&
          !std::holds_alternative<PrescribedJoint>(mover->joint.kind)) {
        return mover;
      }
      mover = FindBody(scene_, mover->parent);
    }
    return nullptr;
  }

  // Whether a signal looks at how deep these two meet.
  bool IsWatched(const std::array<std::string, 2>& bodies) const {
    return std::any_of(scene_.signals.begin(), scene_.signals.end(), [&](const Signal& signal) {
      const auto* depth = std::get_if<DepthSignal>(&signal.kind);
      return depth != nullptr && (depth->bodies == bodies || depth->bodies == std::array{bodies[1], bodies[0]});
    });
  }

  static std::string GetJointPath(const Body& body) { return "bodies." + body.name + ".joint.type"; }

  void CheckBody(const Body& body) {
    if (FindShape<DesignedMeshShape>(body) == nullptr || !body.inertia ||
        !std::holds_alternative<SolidInertia>(*body.inertia)) {
      return;
    }
    Report({"bodies." + body.name + ".inertia.type"},
           "the mass of a designed mesh follows from a density, or is given by an explicit inertia and stays");
  }

  void CheckFixedMesh(const Body& body, std::size_t index) {
    const auto* shape = std::get_if<MeshShape>(&body.shapes[index].kind);
    if (shape == nullptr) return;
    const std::string path = GetShapePath(body, index);
    const std::optional<TriangleMesh> mesh = CheckMesh(path + ".file", path + ".unit", shape->file, shape->unit);
    if (!mesh || !FindDefects(*mesh).empty()) return;
    try {
      MakeFixedMesh(*mesh, MakePose(body.shapes[index]));
    } catch (const std::runtime_error& error) {
      Report({path + ".file"}, error.what());
    }
  }

  void CheckContact(std::size_t i) {
    const std::string path = fmt::format("contacts[{}].bodies", i);
    const Body* a = FindBody(scene_, scene_.contacts[i].bodies[0]);  // null for a rope, which touches all shapes
    const Body* b = FindBody(scene_, scene_.contacts[i].bodies[1]);
    if (a == nullptr || b == nullptr || a == b) return;
    for (std::size_t k = 0; k < a->shapes.size(); ++k) {
      for (std::size_t l = 0; l < b->shapes.size(); ++l) {
        const TouchingKind first = GetTouchingKind(a->shapes[k]);
        const TouchingKind second = GetTouchingKind(b->shapes[l]);
        if (FindPairRule(first, second) != PairRule::kNone) continue;
        Report({path, GetShapePath(*a, k) + ".type", GetShapePath(*b, l) + ".type"}, DescribeNoTouch(first, second));
        return;
      }
    }
    if (FindMover(*a) == nullptr && FindMover(*b) == nullptr && !IsWatched(scene_.contacts[i].bodies)) {
      Report({path, GetJointPath(*a), GetJointPath(*b)},
             fmt::format("forces move neither {} nor {}, so their contact does nothing; a signal "
                         "could watch its depth",
                         a->name, b->name));
    }
  }

  void CheckGrip(std::size_t i) {
    const Body* a = FindBody(scene_, scene_.grips[i].body);
    const Body* b = FindBody(scene_, scene_.grips[i].held);  // null for a rope
    if (a == nullptr || b == nullptr || a == b || FindMover(*a) != nullptr || FindMover(*b) != nullptr) return;
    Report({fmt::format("grips[{}].held", i), GetJointPath(*a), GetJointPath(*b)},
           fmt::format("forces move neither {} nor {}, so this grip does nothing", a->name, b->name));
  }

  void CheckDesign(const DesignedBody& body) {
    const std::string path = "design.bodies." + body.name;
    const std::string unit = path + ".mesh_unit";
    const std::optional<TriangleMesh> mesh = CheckMesh(path + ".mesh", unit, body.mesh, body.mesh_unit);
    const std::optional<TriangleMesh> cage = CheckMesh(path + ".cage", unit, body.cage, body.mesh_unit);
    if (!cage) return;
    if (mesh && FindDefects(*mesh).empty() && FindDefects(*cage).empty()) CheckFit(path, body, *mesh, *cage);
    const std::size_t count = cage->vertices.size();
    for (const VertexGroup& group : body.vertex_groups) {
      for (std::size_t k = 0; k < group.vertices.size(); ++k) {
        if (static_cast<std::size_t>(group.vertices[k]) < count) continue;
        Report({fmt::format("{}.vertex_groups.{}.vertices[{}]", path, group.name, k), path + ".cage"},
               fmt::format("the cage has {} vertices, 0 to {}", count, count - 1));
      }
      if ((group.box || group.plane) && ListVertices(group, *cage).empty()) {
        Report({fmt::format("{}.vertex_groups.{}.{}", path, group.name, group.box ? "box" : "plane"), path + ".cage"},
               "has none of the cage's vertices");
      }
    }
  }

  void CheckFit(const std::string& path, const DesignedBody& body, const TriangleMesh& mesh, const TriangleMesh& cage) {
    const std::string misfit = DescribeMisfit(mesh, cage);
    if (!misfit.empty()) return Report({path + ".mesh", path + ".cage", path + ".mesh_unit"}, misfit);
    if (body.refine == 0.0 || log_.HasFailedNear(path + ".refine")) return;
    try {
      // Between vertices the mesh may reach out of a cage that is not convex.
      const std::string refined_misfit = DescribeMisfit(RefineDesignedMesh(body, mesh), cage);
      if (!refined_misfit.empty()) Report({path + ".refine", path + ".mesh", path + ".cage"}, refined_misfit);
    } catch (const std::runtime_error& error) {
      Report({path + ".refine"}, error.what());
    }
  }

  void CheckWeights(const Policy& policy) {
    const auto* initial = std::get_if<WeightsFile>(&policy.initial);
    if (initial == nullptr || files_.count(initial->file) == 0 || log_.HasFailedNear("policy")) return;
    try {
      ParseWeights(files_.at(initial->file), initial->file, CountPolicyWeights(policy), policy.lower, policy.upper);
    } catch (const std::runtime_error& error) {
      Report({"policy.initial.file"}, error.what());
    }
  }

  // Empty when the file is missing or no mesh.
  std::optional<TriangleMesh> CheckMesh(const std::string& field, const std::string& unit_field,
                                        const std::string& file, double unit) {
    const auto bytes = files_.find(file);
    if (bytes == files_.end() || log_.HasFailedNear(field) || log_.HasFailedNear(unit_field)) return {};
    try {
      TriangleMesh mesh = ReadMesh(file, bytes->second, unit);
      const MeshDefects defects = FindDefects(mesh);
      if (!defects.empty()) {
        Report({field}, fmt::format("must be closed and face outwards; it has {}", defects.Describe()));
      }
      return mesh;
    } catch (const std::exception& error) {
      Report({field}, error.what());
      return {};
    }
  }

  const Scene& scene_;
  const std::map<std::string, std::string>& files_;
  FieldLog& log_;
};

}  // namespace

void CheckModel(LoadedScenario& scenario) { ModelChecker(scenario).Check(); }

}  // namespace knap
