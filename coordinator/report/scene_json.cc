#include "coordinator/report/scene_json.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/report/packed_numbers.h"
#include "sim/contact/contact_mesh.h"
#include "sim/math/overloaded.h"
#include "sim/rollout/build_body.h"
#include "sim/rollout/built_scene.h"
#include "sim/rollout/scene_design.h"

namespace knap {
namespace {

using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

Json MakeJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void Append(const Eigen::Vector3d& v, std::vector<float>* out) {
  for (const double x : v) out->push_back(static_cast<float>(x));
}

std::string Pack(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<float> numbers;
  for (const Eigen::Vector3d& vertex : vertices) Append(vertex, &numbers);
  return PackSingles(numbers);
}

Json MakeMeshJson(const CageDesign& cage, const SceneDesign& design, const VectorXd& learned) {
  const VectorXd& initial = design.initial_theta();
  const TriangleMesh mesh = cage.CalcMesh(initial);
  std::vector<std::uint32_t> corners;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (const int corner : triangle) corners.push_back(static_cast<std::uint32_t>(corner));
  }
  std::vector<float> basis;
  for (Eigen::Index k = 0; k < initial.size(); ++k) {
    // Linear: a difference over any length is the derivative, over the whole range with the least rounding.
    const double length = design.ranges()(k);
    const TriangleMesh moved = cage.CalcMesh(initial + length * VectorXd::Unit(initial.size(), k));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      Append((moved.vertices[i] - mesh.vertices[i]) / length, &basis);
    }
  }
  return {{"type", "mesh"},
          {"designed", true},
          {"triangles", PackIntegers(corners)},
          {"vertices", {{"initial", Pack(mesh.vertices)}, {"learned", Pack(cage.CalcMesh(learned).vertices)}}},
          {"basis", PackSingles(basis)}};
}

// A mesh that no design shapes is the same under both.
Json MakeMeshJson(const ContactMesh& mesh) {
  std::vector<Eigen::Vector3d> vertices(static_cast<std::size_t>(mesh.vertex_count()), Eigen::Vector3d::Zero());
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 0; i < mesh.triangles().size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.triangles()[i][k];
      corners.push_back(static_cast<std::uint32_t>(vertex));
      vertices[static_cast<std::size_t>(vertex)] = mesh.facets()[i].Place(k);
    }
  }
  return {{"type", "mesh"}, {"triangles", PackIntegers(corners)}, {"vertices", {{"initial", Pack(vertices)}}}};
}

Json MakeJson(const Pose& X) {
  const Eigen::Quaterniond q(X.R);
  return {X.p.x(), X.p.y(), X.p.z(), q.w(), q.x(), q.y(), q.z()};
}

// Of one that is no mesh.
Json MakeShapeJson(const Shape& shape) {
  Json out = std::visit(Overloaded{[](const HalfSpaceShape&) -> Json {
                                     return {{"type", "half_space"}};
                                   },
                                   [](const SphereShape& s) -> Json {
                                     return {{"type", "sphere"}, {"radius", s.radius}};
                                   },
                                   [](const CapsuleShape& s) -> Json {
                                     return {{"type", "capsule"}, {"radius", s.radius}, {"length", s.length}};
                                   },
                                   [](const CylinderShape& s) -> Json {
                                     return {{"type", "cylinder"}, {"radius", s.radius}, {"length", s.length}};
                                   },
                                   [](const BoxShape& s) -> Json {
                                     return {{"type", "box"}, {"size", MakeJson(s.size)}};
                                   },
                                   [](const DesignedMeshShape&) -> Json { return nullptr; },
                                   [](const MeshShape&) -> Json { return nullptr; }},
                        shape.kind);
  if (!shape.position.isZero(0.0) || !shape.orientation_rpy.isZero(0.0)) out["pose"] = MakeJson(MakePose(shape));
  return out;
}

// What a body touches with: of a mesh that is not designed, its pieces.
Json MakeShapesJson(const RolloutModel& model, const Body& body, const VectorXd& learned) {
  Json list = Json::array();
  for (std::size_t i = 0; i < body.shapes.size(); ++i) {
    if (std::holds_alternative<DesignedMeshShape>(body.shapes[i].kind)) {
      list.push_back(MakeMeshJson(*model.design()->Find(body.name), *model.design(), learned));
    } else if (const auto mesh = model.source().meshes().find({body.name, i}); mesh != model.source().meshes().end()) {
      for (const MeshGeometry& piece : mesh->second.pieces) list.push_back(MakeMeshJson(*piece.mesh));
    } else {
      list.push_back(MakeShapeJson(body.shapes[i]));
    }
  }
  return list;
}

Json MakeLinkJson(const Rope& rope) {
  return {{"type", "box"},
          {"size", {rope.pitch - rope.gap, rope.thickness, rope.thickness}},
          {"pose", {0.5 * rope.pitch, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0}}};
}

}  // namespace

Json MakeBodiesJson(const RolloutModel& model, const Recording& recording, const VectorXd& learned) {
  const Scene& scene = model.scene();
  std::vector<Json> shapes;  // in the recording's order
  for (const Body& body : scene.bodies) shapes.push_back(MakeShapesJson(model, body, learned));
  for (const Rope& rope : scene.ropes) {
    for (std::int64_t i = 0; i < rope.links; ++i) shapes.push_back(Json::array({MakeLinkJson(rope)}));
  }
  Json bodies = Json::array();
  for (std::size_t i = 0; i < recording.bodies.size(); ++i) {
    const Recording::Body& body = recording.bodies[i];
    bodies.push_back({{"name", body.name}, {"moves", body.moves}, {"shapes", std::move(shapes[i])}});
  }
  return bodies;
}

Json MakeFixedPosesJson(const Recording& recording) {
  Json poses = Json::object();
  for (const Recording::Body& body : recording.bodies) {
    if (body.moves) continue;
    poses[body.name] = MakeJson(body.X_WB.front());
  }
  return poses;
}

}  // namespace knap
