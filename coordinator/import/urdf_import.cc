#include "coordinator/import/urdf_import.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <utility>

#include "sim/geometry/mesh_io.h"
#include "sim/scenarios/dump_scene.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// What the parser says in place of throwing.
class Complaints final : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  ~Complaints() override { console_bridge::noOutputHandler(); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

Vector3d ToVector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Matrix3d ToMatrix(const urdf::Rotation& r) {
  return Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
}

Vector3d ToRpy(const urdf::Rotation& r) {
  Vector3d rpy;
  r.getRPY(rpy.x(), rpy.y(), rpy.z());
  return rpy;
}

// Letters, digits and underscores.
std::string MakeName(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool keeps = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += keeps ? c : '_';
  }
  if (name.empty() || (name.front() >= '0' && name.front() <= '9')) name.insert(name.begin(), '_');
  return name;
}

class Importer {
 public:
  Importer(const urdf::ModelInterface& model, const UrdfOptions& options) : model_(model), options_(options) {}

  ImportedRobot Import() {
    robot_.name = MakeName(model_.getName());
    if (!options_.path_file.empty()) {
      Remark("joints follow the columns of {} that have their names", options_.path_file);
    }
    AddLink(*model_.getRoot());
    return std::move(robot_);
  }

 private:
  template <typename... Args>
  void Remark(fmt::format_string<Args...> format, Args&&... args) {
    robot_.remarks.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  [[noreturn]] static void Refuse(fmt::format_string<Args...> format, Args&&... args) {
    throw std::runtime_error(fmt::format(format, std::forward<Args>(args)...));
  }

  // Parents first.
  void AddLink(const urdf::Link& link) {
    Body body;
    body.name = MakeName(link.name);
    if (!names_.insert(body.name).second || body.name == kWorldName) {
      Refuse("link '{}': its name would be '{}', which is taken; give it another one", link.name, body.name);
    }
    if (link.parent_joint != nullptr) {
      const urdf::Joint& joint = *link.parent_joint;
      body.parent = MakeName(joint.parent_link_name);
      body.joint.position = ToVector(joint.parent_to_joint_origin_transform.position);
      body.joint.orientation_rpy = ToRpy(joint.parent_to_joint_origin_transform.rotation);
      body.joint.kind = MakeJoint(joint);
      robot_.body_of_joint[joint.name] = body.name;
    }
    const bool is_free = !std::holds_alternative<FixedJoint>(body.joint.kind) &&
                         !std::holds_alternative<PrescribedJoint>(body.joint.kind);
    // What follows a path needs no inertia, and many files have moments that no body has.
    const bool needs_inertia = is_free || options_.path_file.empty();
    if (needs_inertia && link.inertial != nullptr) body.inertia = MakeInertia(*link.inertial);
    if (is_free && (link.inertial == nullptr || !(link.inertial->mass > 0.0))) {
      Refuse("link '{}': moves by joint '{}' and has no mass", link.name, link.parent_joint->name);
    }
    AddShapes(link, &body);
    robot_.bodies.push_back(std::move(body));
    for (const auto& child : link.child_links) AddLink(*child);
  }

  JointKind MakeJoint(const urdf::Joint& joint) {
    const bool turns = joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
    const bool slides = joint.type == urdf::Joint::PRISMATIC;
    if ((turns || slides) && !options_.path_file.empty()) {
      JointPathMotion motion{options_.path_file, joint.name, turns ? JointPathKind::kTurn : JointPathKind::kShift,
                             ToVector(joint.axis)};
      return PrescribedJoint{std::move(motion)};
    }
    if (joint.mimic != nullptr) {
      Refuse("joint '{}': mimics '{}', which knap cannot; import with --follow, or without the mimic", joint.name,
             joint.mimic->joint_name);
    }
    if (turns) {
      RevoluteJoint out;
      FillJoint(joint, &out);
      out.initial.angle = CalcStart(joint);
      return out;
    }
    if (slides) {
      PrismaticJoint out;
      FillJoint(joint, &out);
      out.initial.displacement = CalcStart(joint);
      return out;
    }
    if (joint.type == urdf::Joint::FLOATING) return FreeJoint{};
    if (joint.type == urdf::Joint::PLANAR) {
      if (ToVector(joint.axis).cross(Vector3d::UnitZ()).norm() > 1e-9) {
        Refuse("joint '{}': planar with another normal than z of its own frame", joint.name);
      }
      return PlanarJoint{};
    }
    if (joint.type != urdf::Joint::FIXED) Refuse("joint '{}': of a type that is not known", joint.name);
    return FixedJoint{};
  }

  // The range's nearest value to 0.
  static double CalcStart(const urdf::Joint& joint) {
    if (joint.limits == nullptr || joint.type == urdf::Joint::CONTINUOUS) return 0.0;
    return std::clamp(0.0, joint.limits->lower, std::max(joint.limits->lower, joint.limits->upper));
  }

  template <typename OneDofJoint>
  void FillJoint(const urdf::Joint& joint, OneDofJoint* out) {
    out->axis = ToVector(joint.axis);
    if (joint.dynamics != nullptr) {
      out->damping = std::max(0.0, joint.dynamics->damping);
      if (joint.dynamics->friction > 0.0) {
        Remark("joint {}: dry friction of {:g} left out", joint.name, joint.dynamics->friction);
      }
    }
    if (joint.limits == nullptr) return;
    const double effort = joint.limits->effort;
    if (effort > 0.0) out->actuator = ForceActuator{effort};
    if (joint.type == urdf::Joint::CONTINUOUS || !(joint.limits->upper > joint.limits->lower)) return;
    JointLimits limits;
    limits.lower = joint.limits->lower;
    limits.upper = joint.limits->upper;
    limits.stiffness = (effort > 0.0 ? effort : kEffortWithoutLimit) / kStopTravel;
    limits.width = 0.5 * kStopTravel;
    out->limits = limits;
  }

  static Inertia MakeInertia(const urdf::Inertial& inertial) {
    Matrix3d I;
    I << inertial.ixx, inertial.ixy, inertial.ixz,  //
        inertial.ixy, inertial.iyy, inertial.iyz,   //
        inertial.ixz, inertial.iyz, inertial.izz;
    const Matrix3d R = ToMatrix(inertial.origin.rotation);
    const Matrix3d I_B = R * I * R.transpose();
    ExplicitInertia out;
    out.mass = inertial.mass;
    out.center = ToVector(inertial.origin.position);
    out.moments = I_B.diagonal();
    out.products = {I_B(0, 1), I_B(0, 2), I_B(1, 2)};
    return out;
  }

  void AddShapes(const urdf::Link& link, Body* body) {
    for (const auto& collision : link.collision_array) {
      if (collision == nullptr || collision->geometry == nullptr) continue;
      Shape shape;
      shape.position = ToVector(collision->origin.position);
      shape.orientation_rpy = ToRpy(collision->origin.rotation);
      if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(collision->geometry.get())) {
        shape.kind = SphereShape{sphere->radius};
      } else if (const auto* box = dynamic_cast<const urdf::Box*>(collision->geometry.get())) {
        BoxShape out;
        out.size = ToVector(box->dim);
        shape.kind = out;
      } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(collision->geometry.get())) {
        CylinderShape out;
        out.radius = cylinder->radius;
        out.length = cylinder->length;
        shape.kind = out;
      } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(collision->geometry.get())) {
        std::optional<MeshShape> out = MakeMesh(link.name, *mesh);
        if (!out) continue;
        shape.kind = *std::move(out);
      }
      body->shapes.push_back(std::move(shape));
    }
  }

  // None, with a remark, where it cannot be taken.
  std::optional<MeshShape> MakeMesh(const std::string& link, const urdf::Mesh& mesh) {
    const auto leave_out = [&](const std::string& why) {
      Remark("link {}: mesh {} left out: {}", link, mesh.filename, why);
      return std::nullopt;
    };
    if (mesh.scale.x != mesh.scale.y || mesh.scale.y != mesh.scale.z || !(mesh.scale.x > 0.0)) {
      return leave_out("its scale is not one positive number for all directions");
    }
    const std::optional<std::string> bytes = options_.read_mesh ? options_.read_mesh(mesh.filename) : std::nullopt;
    if (!bytes) return leave_out("the file cannot be found");
    const std::string file = fmt::format("meshes/{}", std::filesystem::path(mesh.filename).filename().string());
    const auto known = robot_.meshes.find(file);
    if (known != robot_.meshes.end() && known->second != *bytes) {
      return leave_out("another mesh has a file of this name");
    }
    try {
      const MeshDefects defects = FindDefects(ReadMesh(file, *bytes, mesh.scale.x));
      if (!defects.empty()) return leave_out("it is not closed or does not face outwards: " + defects.Describe());
    } catch (const std::runtime_error& error) {
      return leave_out(error.what());
    }
    robot_.meshes[file] = *bytes;
    return MeshShape{file, mesh.scale.x};
  }

  const urdf::ModelInterface& model_;
  const UrdfOptions& options_;
  ImportedRobot robot_;
  std::set<std::string> names_;
};

}  // namespace

ImportedRobot ImportUrdf(const std::string& text, const UrdfOptions& options) {
  const Complaints complaints;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (model == nullptr || model->getRoot() == nullptr) {
    throw std::runtime_error(complaints.first().empty() ? "no robot in URDF" : complaints.first());
  }
  return Importer(*model, options).Import();
}

std::string FormatImport(const ImportedRobot& robot, std::string_view source, std::string_view file) {
  std::string text = fmt::format("# Robot {}, made by `knap import` from {}. To be included:\n", robot.name, source);
  text += fmt::format("#   include: [{{file: {}, name: {}}}]\n", file, robot.name);
  for (const auto& [joint, body] : robot.body_of_joint) {
    if (joint != body) text += fmt::format("# joint {} leads to body {}\n", joint, body);
  }
  for (const std::string& remark : robot.remarks) text += fmt::format("# {}\n", remark);
  return text + fmt::format("schema: {}\n", kSceneSchema) + DumpBodies(robot.bodies);
}

}  // namespace knap
