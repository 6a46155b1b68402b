#include "sim/rollout/scene_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/designed_mesh.h"
#include "sim/rollout/vertex_groups.h"

namespace knap {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

std::vector<VertexMove> MakeMoves(const Design& design, const DesignedBody& body, const TriangleMesh& cage) {
  std::vector<VertexMove> moves;
  for (const CageMove& move : body.moves) {
    const auto parameter = std::find_if(design.parameters.begin(), design.parameters.end(),
                                        [&](const DesignParameter& p) { return p.name == move.parameter; });
    const auto group = std::find_if(body.vertex_groups.begin(), body.vertex_groups.end(),
                                    [&](const VertexGroup& g) { return g.name == move.group; });
    for (const std::int64_t vertex : ListVertices(*group, cage)) {
      Vector3d direction = move.direction;
      if (parameter->kind == ParameterKind::kStretch) {
        direction.array() *= cage.vertices.at(static_cast<std::size_t>(vertex)).array();
      }
      moves.push_back({static_cast<int>(parameter - design.parameters.begin()), static_cast<int>(vertex), direction});
    }
  }
  return moves;
}

CageDesign MakeCageDesign(const Design& design, const DesignedBody& body, const VectorXd& initial,
                          const std::map<std::string, std::string>& files) try {
  TriangleMesh mesh = RefineDesignedMesh(body, ReadMesh(body.mesh, files.at(body.mesh), body.mesh_unit));
  TriangleMesh cage = ReadMesh(body.cage, files.at(body.cage), body.mesh_unit);
  const std::vector<VertexMove> moves = MakeMoves(design, body, cage);
  return CageDesign(std::move(mesh), std::move(cage), initial, moves);
} catch (const std::bad_alloc&) {
  throw;  // says nothing about the design
} catch (const std::exception& e) {
  throw std::runtime_error(fmt::format("design of '{}': {}", body.name, e.what()));
}

// Of a mesh that theta has moved.
std::string DescribeFault(const std::string& body, const TriangleMesh& mesh) {
  const MeshDefects defects = FindDefects(mesh);
  if (defects.empty()) return {};
  return fmt::format("theta folds the mesh of '{}' or turns it inside out: {}", body, defects.Describe());
}

std::string DescribeLostPiece(const std::string& body) {
  return fmt::format("theta folds a convex part of the mesh of '{}', which another designed mesh touches", body);
}

bool Touches(const World& world, const std::string& body) {
  return std::any_of(world.contacts.begin(), world.contacts.end(),
                     [&](const Contact& c) { return c.bodies[0] == body || c.bodies[1] == body; });
}

bool TouchesDesigned(const World& world, const std::string& body) {
  const auto is_designed = [&](const std::string& name) {
    return std::any_of(world.design->bodies.begin(), world.design->bodies.end(),
                       [&](const DesignedBody& b) { return b.name == name; });
  };
  return std::any_of(world.contacts.begin(), world.contacts.end(), [&](const Contact& c) {
    return (c.bodies[0] == body && is_designed(c.bodies[1])) || (c.bodies[1] == body && is_designed(c.bodies[0]));
  });
}

std::vector<PieceFaces> FindPieces(const std::string& body, const TriangleMesh& mesh) try {
  return FindPieceFaces(mesh);
} catch (const std::runtime_error& e) {
  throw std::runtime_error(fmt::format("design of '{}': it meets another designed mesh, and {}", body, e.what()));
}

}  // namespace

SceneDesign::SceneDesign(const World& world, const std::map<std::string, std::string>& files) {
  const Design& design = *world.design;
  const auto d = static_cast<Eigen::Index>(design.parameters.size());
  initial_theta_.resize(d);
  ranges_.resize(d);
  for (Eigen::Index i = 0; i < d; ++i) {
    const DesignParameter& parameter = design.parameters[static_cast<std::size_t>(i)];
    initial_theta_(i) = parameter.initial;
    ranges_(i) = parameter.upper - parameter.lower;
  }
  for (const DesignedBody& body : design.bodies) {
    names_.push_back(body.name);
    Part part{MakeCageDesign(design, body, initial_theta_, files), Touches(world, body.name), {}};
    if (TouchesDesigned(world, body.name)) part.pieces = FindPieces(body.name, part.cage.initial_mesh());
    parts_.emplace(body.name, std::move(part));
  }
}

const CageDesign* SceneDesign::Find(const std::string& body) const {
  const auto found = parts_.find(body);
  return found == parts_.end() ? nullptr : &found->second.cage;
}

std::vector<double> SceneDesign::CalcPieceVolumes(const std::string& body) const {
  const Part& part = parts_.at(body);
  std::vector<double> volumes;
  for (const PieceFaces& faces : part.pieces) {
    TriangleMesh piece{part.cage.initial_mesh().vertices, {}};
    for (const PieceFace& face : faces) piece.triangles.insert(piece.triangles.end(), face.begin(), face.end());
    volumes.push_back(CalcSignedVolume(piece));
  }
  return volumes;
}

DesignedShapes SceneDesign::CalcShapes(const VectorXd& theta) const {
  DesignedShapes shapes;
  for (const auto& [name, part] : parts_) {
    DesignedShape shape;
    shape.mesh = part.cage.CalcMesh(theta);
    shape.fault = DescribeFault(name, shape.mesh);
    if (shape.fault.empty() && !part.pieces.empty()) {
      if (std::optional<MovingPieces> pieces = MovePieces(part.pieces, shape.mesh.vertices)) {
        shape.contact.pieces = std::make_shared<MovingPieces>(*std::move(pieces));
      } else {
        shape.fault = DescribeLostPiece(name);
      }
    }
    if (shape.fault.empty()) {
      shape.of_unit_density = CalcMassProperties(shape.mesh, 1.0);
      if (part.touches) shape.contact.mesh = std::make_shared<ContactMesh>(shape.mesh);
    }
    shapes.emplace(name, std::move(shape));
  }
  return shapes;
}

std::string SceneDesign::FindFault(const VectorXd& theta) const {
  for (const auto& [name, part] : parts_) {
    const TriangleMesh mesh = part.cage.CalcMesh(theta);
    std::string fault = DescribeFault(name, mesh);
    if (!fault.empty()) return fault;
    if (!part.pieces.empty() && !MovePieces(part.pieces, mesh.vertices)) return DescribeLostPiece(name);
  }
  return {};
}

void SceneDesign::MoveAttachments(const VectorXd& theta, World* world) const {
  const VectorXd change = theta - initial_theta_;
  const auto move = [&](const std::string& body, const Vector3d& at, Vector3d* p_B) {
    if (const CageDesign* cage = Find(body)) *p_B += cage->CalcPointDerivative(at) * change;
  };
  for (Body& body : world->bodies) {
    const Vector3d at = body.joint.GetAttachmentPoint();
    move(body.parent, at, &body.joint.position);
  }
  for (Signal& signal : world->signals) {
    std::visit(
        [&](auto& kind) {
          if constexpr (requires { kind.point; }) move(kind.body, Vector3d(kind.point), &kind.point);
        },
        signal.kind);
  }
  for (Grip& grip : world->grips) {
    move(grip.body, Vector3d(grip.point), &grip.point);
    move(grip.held, Vector3d(grip.held_point), &grip.held_point);
  }
}

VectorXd SceneDesign::PullBack(const World& world, const DesignedShapes& shapes, const SceneModel& model,
                               const TrajectoryGradient& gradient, const std::vector<PointCotangent>& points) const {
  VectorXd out = VectorXd::Zero(num_parameters());
  const auto add_point = [&](const std::string& body, const Vector3d& p_B, const Vector3d& bar_B) {
    if (const CageDesign* cage = Find(body)) out += cage->CalcPointDerivative(p_B).transpose() * bar_B;
  };
  for (const PointCotangent& point : points) add_point(point.body, point.p_B, point.bar_B);
  for (const Body& body : world.bodies) {
    // An error of the joint's placement, in the joint's frame J.
    const int joint = model.joint_index.at(body.name);
    const Vector3d bar_J = gradient.bodies[static_cast<std::size_t>(joint)].placement.tail<3>();
    add_point(body.parent, body.joint.GetAttachmentPoint(),
              model.tree.bodies()[static_cast<std::size_t>(joint)].X_PF.R * bar_J);

    const DensityInertia* inertia = body.inertia ? std::get_if<DensityInertia>(&*body.inertia) : nullptr;
    if (inertia == nullptr || Find(body.name) == nullptr) continue;
    const BodyParameterCotangent& b = gradient.bodies[static_cast<std::size_t>(model.body_index.at(body.name))];
    out += Find(body.name)->PullBack(
        PullBackMassProperties(shapes.at(body.name).mesh, inertia->density, {b.mass, b.first_moment, b.inertia}));
  }
  for (std::size_t i = 0; i < world.grips.size(); ++i) {
    add_point(world.grips[i].body, world.grips[i].point, gradient.grips[i].p_SA);
    add_point(world.grips[i].held, world.grips[i].held_point, gradient.grips[i].p_BP);
  }
  std::map<std::string, Matrix3Xd> vertices;  // of a body, over its contacts
  for (std::size_t i = 0; i < gradient.vertices.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      const Matrix3Xd& of_shape = gradient.vertices[i][k];
      if (of_shape.cols() == 0) continue;
      const auto [sum, is_first] = vertices.try_emplace(model.contact_meshes[i][k], of_shape);
      if (!is_first) sum->second += of_shape;
    }
  }
  for (const auto& [body, sum] : vertices) out += Find(body)->PullBack(sum);
  return out;
}

}  // namespace knap
