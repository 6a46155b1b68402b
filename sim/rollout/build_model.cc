#include "sim/rollout/build_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "sim/math/overloaded.h"
#include "sim/multibody/motions.h"
#include "sim/rollout/build_body.h"
#include "sim/scenarios/check_rules.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d CalcGravity(const World& world) {
  if (!world.gravity_direction) return world.gravity;
  const double z = world.gravity_direction->rise;
  const double level = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double azimuth = world.gravity_direction->azimuth;
  return world.gravity.norm() * Vector3d(level * std::cos(azimuth), level * std::sin(azimuth), z);
}

Matrix3d MakeLinkAxes(const Vector3d& direction_W) {
  Matrix3d R_WL;
  R_WL.col(0) = direction_W.normalized();
  const bool upright = std::abs(R_WL(2, 0)) > 0.9;
  R_WL.col(1) = (upright ? Vector3d::UnitX() : Vector3d::UnitZ()).cross(R_WL.col(0)).normalized();
  R_WL.col(2) = R_WL.col(0).cross(R_WL.col(1));
  return R_WL;
}

namespace {

// The level axis across a direction; any one where the direction is plumb. Of its two senses the one nearer to a fixed
// direction, so that it hangs on where down is whether a turn dips this end first or the other.
Vector3d CalcLevelAxis(const Vector3d& direction, const Vector3d& gravity) {
  const Vector3d d = direction.normalized();
  const Vector3d axis = d.cross(gravity.normalized());
  const Vector3d across = d.unitOrthogonal();
  if (!(axis.norm() > 1e-9)) return across;
  return (axis.dot(across) < 0.0 ? -1.0 : 1.0) * axis.normalized();
}

// `gravity` in J.
MotionPiece MakePiece(const MotionSegment& segment, const Vector3d& gravity) {
  MotionPiece piece{segment.duration, segment.ramp, segment.shift, Vector3d::Zero()};
  if (segment.angle == 0.0) return piece;
  const bool tips = segment.tips.norm() > 0.0;
  piece.turn = segment.angle * (tips ? CalcLevelAxis(segment.tips, gravity) : segment.axis.normalized());
  return piece;
}

// Six shifts and turns, one in the other: roll, pitch and yaw as RotationFromRpy has them.
PrescribedMotion MakePath(const std::string& file, const RecordedPaths& paths) {
  std::vector<CubicSpline> splines;
  for (const char* column : kPathColumns) splines.push_back(paths.at({file, column}));
  return [splines](double time) {
    PrescribedState state = CalcShift(Vector3d::UnitX(), splines[0].Calc(time));
    for (int i = 1; i < 3; ++i) state = Compose(state, CalcShift(Vector3d::Unit(i), splines[i].Calc(time)));
    for (int i = 2; i >= 0; --i) state = Compose(state, CalcTurn(Vector3d::Unit(i), splines[3 + i].Calc(time)));
    return state;
  };
}

PrescribedMotion MakeJointPath(const JointPathMotion& motion, const RecordedPaths& paths) {
  const auto calc = motion.kind == JointPathKind::kTurn ? CalcTurn : CalcShift;
  return [calc, axis = Vector3d(motion.axis.normalized()),
          spline = paths.at({motion.file, motion.column})](double time) { return calc(axis, spline.Calc(time)); };
}

PrescribedMotion MakeMotionAsWritten(const Motion& motion, const Vector3d& gravity, const RecordedPaths& paths) {
  return std::visit(Overloaded{[](const ZigzagMotion& m) -> PrescribedMotion {
                                 const Zigzag zigzag{m.amplitude, m.period, m.sharpness, m.forward_speed, m.stop_at};
                                 return [zigzag](double time) { return CalcZigzag(zigzag, time); };
                               },
                               [](const ConstantVelocityMotion& m) -> PrescribedMotion {
                                 return [m](double time) {
                                   return CalcConstantVelocity(m.velocity, m.angular_velocity, time);
                                 };
                               },
                               [&](const SegmentsMotion& m) -> PrescribedMotion {
                                 std::vector<MotionPiece> pieces;
                                 for (const MotionSegment& s : m.segments) pieces.push_back(MakePiece(s, gravity));
                                 return [pieces](double time) { return CalcPieces(pieces, time); };
                               },
                               [&](const PathMotion& m) { return MakePath(m.file, paths); },
                               [&](const JointPathMotion& m) { return MakeJointPath(m, paths); }},
                    motion);
}

// At so many times the speed that is written.
PrescribedMotion MakeMotion(const Motion& motion, double speed, const Vector3d& gravity, const RecordedPaths& paths) {
  const PrescribedMotion as_written = MakeMotionAsWritten(motion, gravity, paths);
  if (speed == 1.0) return as_written;
  return [as_written, speed](double time) {
    PrescribedState state = as_written(speed * time);
    state.V *= speed;
    state.A *= speed * speed;
    state.jerk *= speed * speed * speed;
    return state;
  };
}

// A rope at time 0.
struct RopePlace {
  Vector3d start;              // of its first joint in W
  std::vector<Matrix3d> R_WL;  // of its links
};

RopePlace PlaceHelix(const Rope& rope, const HelixState& helix) {
  const auto links_per_side = static_cast<int>(helix.links_per_side);
  const double rise = helix.advance / (4.0 * links_per_side);  // along x, a link
  const double along = std::sqrt(rope.pitch * rope.pitch - rise * rise);
  const double half_side = 0.5 * links_per_side * along;
  const Matrix3d whole = Eigen::AngleAxisd(helix.turn, Vector3d::UnitX()).toRotationMatrix();
  const Vector3d first(-0.5 * static_cast<double>(rope.links) * rise, half_side, half_side);
  RopePlace place{helix.center + whole * first, {}};
  for (int i = 0; i < rope.links; ++i) {
    const Matrix3d side =
        whole * Eigen::AngleAxisd(0.5 * std::numbers::pi * (i / links_per_side), Vector3d::UnitX()).toRotationMatrix();
    Matrix3d R_WL;
    R_WL.col(0) = side * Vector3d(rise, -along, 0.0) / rope.pitch;
    R_WL.col(2) = side * Vector3d::UnitZ();
    R_WL.col(1) = R_WL.col(2).cross(R_WL.col(0));
    place.R_WL.push_back(R_WL);
  }
  return place;
}

RopePlace PlaceStraight(const Rope& rope, const StraightState& straight) {
  const Matrix3d R_WL = MakeLinkAxes(straight.direction);
  return {straight.start, std::vector<Matrix3d>(static_cast<std::size_t>(rope.links), R_WL)};
}

RopePlace PlaceRope(const Rope& rope) {
  return std::visit(Overloaded{[&](const HelixState& helix) { return PlaceHelix(rope, helix); },
                               [&](const StraightState& straight) { return PlaceStraight(rope, straight); }},
                    rope.initial);
}

// Adds bodies one by one and remembers the initial state of their joints.
class Builder {
 public:
  Builder(const Vector3d& gravity, double speed, const RecordedPaths& paths) : paths_(paths), speed_(speed) {
    model_.tree.gravity = gravity;
  }

  void Add(const Body& body, const std::vector<const MassProperties*>& of_unit_density) {
    model_.joint_index[body.name] = model_.tree.size();
    TreeBody tree_body;
    tree_body.name = body.name;
    tree_body.parent = body.parent == kWorldName ? -1 : model_.body_index.at(body.parent);
    tree_body.X_PF = {RotationFromRpy(body.joint.orientation_rpy), body.joint.position};
    const Matrix6d M = MakeInertia(body, of_unit_density);
    std::visit(Overloaded{
                   [&](const FixedJoint&) { Append(tree_body, M, {}, {}); },
                   [&](const PrescribedJoint& j) {
                     tree_body.joint = JointType::kPrescribed;
                     tree_body.motion =
                         MakeMotion(j.motion, speed_, tree_body.X_PF.R.transpose() * model_.tree.gravity, paths_);
                     Append(tree_body, M, {}, {});
                   },
                   [&](const RevoluteJoint& j) {
                     AddOneDof(tree_body, JointType::kRevolute, j, M, j.initial.angle, j.initial.rate);
                   },
                   [&](const PrismaticJoint& j) {
                     AddOneDof(tree_body, JointType::kPrismatic, j, M, j.initial.displacement, j.initial.speed);
                   },
                   [&](const BallJoint& j) {
                     AddBall(tree_body, M, MakeLaw(j), j.initial.orientation_rpy, j.initial.angular_velocity);
                   },
                   [&](const PlanarJoint& j) {
                     const auto& s = j.initial;
                     AddMassless(Single(tree_body, JointType::kPrismatic, Vector3d::UnitX(), j.linear_damping),
                                 {s.position.x()}, {s.velocity.x()}, &tree_body);
                     AddMassless(Single(tree_body, JointType::kPrismatic, Vector3d::UnitY(), j.linear_damping),
                                 {s.position.y()}, {s.velocity.y()}, &tree_body);
                     Append(Single(tree_body, JointType::kRevolute, Vector3d::UnitZ(), j.angular_damping), M, {s.angle},
                            {s.angular_velocity});
                   },
                   [&](const FreeJoint& j) {
                     const auto& s = j.initial;
                     TreeBody slide = tree_body;
                     slide.joint = JointType::kTranslation;
                     AddMassless(slide, {s.position.x(), s.position.y(), s.position.z()},
                                 {s.velocity.x(), s.velocity.y(), s.velocity.z()}, &tree_body);
                     AddBall(tree_body, M, JointLaw{}, s.orientation_rpy, s.angular_velocity);
                   },
               },
               body.joint.kind);
    model_.body_index[body.name] = model_.tree.size() - 1;
  }

  void Add(const Rope& rope) {
    const Vector3d size(rope.pitch - rope.gap, rope.thickness, rope.thickness);
    const Vector3d s2 = size.cwiseAbs2();
    const Vector3d moments = rope.link_mass / 12.0 * Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y());
    const Matrix6d M = MakeSpatialInertia(rope.link_mass, Vector3d(0.5 * rope.pitch, 0.0, 0.0), moments.asDiagonal());
    const RopePlace place = PlaceRope(rope);
    TreeBody slide;
    slide.name = rope.name;
    slide.joint = JointType::kTranslation;
    Append(slide, Matrix6d::Zero(), {place.start.x(), place.start.y(), place.start.z()}, {0.0, 0.0, 0.0});
    Matrix3d R_WP = Matrix3d::Identity();
    for (int i = 0; i < rope.links; ++i) {
      TreeBody link;
      link.name = fmt::format("{} link {}", rope.name, i);
      link.parent = model_.tree.size() - 1;
      link.joint = JointType::kBall;
      if (i > 0) {
        link.X_PF.p.x() = rope.pitch;
        link.law.damping = rope.joint_damping;
      }
      const Matrix3d& R_WB = place.R_WL[i];
      const Eigen::Quaterniond q(Matrix3d(R_WP.transpose() * R_WB));
      Append(link, M, {q.x(), q.y(), q.z(), q.w()}, {0.0, 0.0, 0.0});
      model_.links[rope.name].push_back(model_.tree.size() - 1);
      R_WP = R_WB;
    }
  }

  SceneModel Finish() {
    model_.q0 = Eigen::Map<const VectorXd>(q_.data(), static_cast<Eigen::Index>(q_.size()));
    model_.v0 = Eigen::Map<const VectorXd>(v_.data(), static_cast<Eigen::Index>(v_.size()));
    return std::move(model_);
  }

  SceneModel& model() { return model_; }

 private:
  template <class OneDofJoint>
  void AddOneDof(TreeBody body, JointType type, const OneDofJoint& joint, const Matrix6d& M, double q, double v) {
    body.joint = type;
    body.axis = joint.axis.normalized();
    body.law = MakeLaw(joint);
    const std::string name = body.name;
    Append(std::move(body), M, {q}, {v});
    if (!joint.actuator) return;
    model_.tree.AddActuator(MakeActuator(*joint.actuator, model_.tree.size() - 1));
    model_.actuators.push_back(MakeCommand(*joint.actuator, name));
  }

  static TreeBody Single(TreeBody body, JointType joint, const Vector3d& axis, double damping) {
    body.joint = joint;
    body.axis = axis;
    body.law.damping = damping;
    return body;
  }

  void Append(TreeBody body, const Matrix6d& M, std::vector<double> q, std::vector<double> v) {
    body.M = M;
    model_.tree.AddBody(std::move(body));
    q_.insert(q_.end(), q.begin(), q.end());
    v_.insert(v_.end(), v.begin(), v.end());
  }

  // An inner body of a compound joint; *next becomes its child at the same place.
  void AddMassless(const TreeBody& body, std::vector<double> q, std::vector<double> v, TreeBody* next) {
    Append(body, Matrix6d::Zero(), std::move(q), std::move(v));
    next->parent = model_.tree.size() - 1;
    next->X_PF = Pose{};
  }

  void AddBall(TreeBody body, const Matrix6d& M, const JointLaw& law, const Vector3d& rpy, const Vector3d& w_F) {
    body.joint = JointType::kBall;
    body.law = law;
    const Matrix3d R_FB = RotationFromRpy(rpy);
    const Eigen::Quaterniond q(R_FB);
    const Vector3d w_B = R_FB.transpose() * w_F;
    Append(body, M, {q.x(), q.y(), q.z(), q.w()}, {w_B.x(), w_B.y(), w_B.z()});
  }

  SceneModel model_;
  const RecordedPaths& paths_;
  double speed_;
  std::vector<double> q_;
  std::vector<double> v_;
};

// In B. `mesh` of what design or file gives one; a fixed one may have several pieces.
std::vector<ContactGeometry> MakeGeometries(const Shape& shape, const std::vector<MeshGeometry>& meshes) {
  const Pose X_BG = MakePose(shape);
  const Vector3d z = X_BG.R.col(2);
  using Geometries = std::vector<ContactGeometry>;
  return std::visit(Overloaded{[&](const HalfSpaceShape&) {
                                 return Geometries{HalfSpaceGeometry{{z, z.dot(X_BG.p)}}};
                               },
                               [&](const SphereShape& s) {
                                 return Geometries{SphereGeometry{s.radius, X_BG.p}};
                               },
                               [&](const CapsuleShape& s) {
                                 return Geometries{CapsuleGeometry{s.radius, 0.5 * s.length, X_BG.p, z}};
                               },
                               [&](const CylinderShape& s) {
                                 return Geometries{CylinderGeometry{s.radius, 0.5 * s.length, X_BG.p, z}};
                               },
                               [&](const BoxShape& s) {
                                 return Geometries{BoxGeometry{0.5 * s.size, X_BG.p, X_BG.R}};
                               },
                               [&](const DesignedMeshShape&) { return Geometries(meshes.begin(), meshes.end()); },
                               [&](const MeshShape&) { return Geometries(meshes.begin(), meshes.end()); }},
                    shape.kind);
}

// A name in a contact stands for a body or for each link of a rope: what all of these touch with.
std::vector<ContactGeometry> MakePartnerGeometries(const World& world, const std::string& name,
                                                   const DesignedShapes& designed, const FixedMeshes& meshes) {
  if (const Rope* rope = FindRope(world, name)) {
    const Vector3d size(rope->pitch - rope->gap, rope->thickness, rope->thickness);
    return {BoxGeometry{0.5 * size, Vector3d(0.5 * rope->pitch, 0.0, 0.0)}};
  }
  const Body* body = FindBody(world, name);
  if (body == nullptr) throw std::runtime_error(fmt::format("no body '{}'", name));
  if (body->shapes.empty()) throw std::runtime_error(fmt::format("body '{}' has no shape to touch with", name));
  std::vector<ContactGeometry> out;
  for (std::size_t i = 0; i < body->shapes.size(); ++i) {
    std::vector<MeshGeometry> of_shape;
    if (const auto fixed = meshes.find({name, i}); fixed != meshes.end()) of_shape = fixed->second.pieces;
    if (std::holds_alternative<DesignedMeshShape>(body->shapes[i].kind)) of_shape = {designed.at(name).contact};
    const std::vector<ContactGeometry> pieces = MakeGeometries(body->shapes[i], of_shape);
    out.insert(out.end(), pieces.begin(), pieces.end());
  }
  return out;
}

bool IsDesigned(const ContactGeometry& geometry) {
  const auto* mesh = std::get_if<MeshGeometry>(&geometry);
  return mesh != nullptr && mesh->IsDesigned();
}

std::vector<int> GetPartners(const SceneModel& model, const std::string& name) {
  const auto links = model.links.find(name);
  return links != model.links.end() ? links->second : std::vector<int>{model.body_index.at(name)};
}

// Every shape of the one against every shape of the other.
void AddContact(const World& world, std::size_t index, const DesignedShapes& shapes, const FixedMeshes& meshes,
                SceneModel* model) {
  const Contact& contact = world.contacts[index];
  const auto& [first, second] = contact.bodies;
  const std::vector<ContactGeometry> of_first = MakePartnerGeometries(world, first, shapes, meshes);
  const std::vector<ContactGeometry> of_second = MakePartnerGeometries(world, second, shapes, meshes);
  ContactPair pair;
  pair.material = {contact.stiffness,          contact.damping,    contact.friction,
                   contact.rolling_resistance, contact.slip_speed, contact.stick_distance};
  const std::vector<int> a = GetPartners(*model, first);
  const std::vector<int> b = GetPartners(*model, second);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = first == second ? i + 2 : 0; j < b.size(); ++j) {
      pair.bodies = {a[i], b[j]};
      for (const ContactGeometry& shape : of_first) {
        for (const ContactGeometry& other : of_second) {
          pair.shapes = {shape, other};
          model->contacts.push_back(pair);
          model->contact_meshes.push_back(
              {IsDesigned(shape) ? first : std::string(), IsDesigned(other) ? second : std::string()});
          model->contact_of_pair.push_back(static_cast<int>(index));
        }
      }
    }
  }
}

GripSpring MakeGrip(const World& world, const Grip& grip, const SceneModel& model) {
  GripSpring spring;
  spring.holder = model.body_index.at(grip.body);
  spring.p_SA = grip.point;
  spring.p_BP = grip.held_point;
  const auto rope =
      std::find_if(world.ropes.begin(), world.ropes.end(), [&](const Rope& r) { return r.name == grip.held; });
  if (rope != world.ropes.end()) {
    const std::vector<int>& links = model.links.at(grip.held);
    const int last = static_cast<int>(links.size()) - 1;
    const int link = std::min(last, static_cast<int>(grip.held_point.x() / rope->pitch));
    spring.held = links[link];
    spring.p_BP.x() -= link * rope->pitch;
  } else {
    spring.held = model.body_index.at(grip.held);
  }
  spring.stiffness = grip.stiffness;
  spring.damping = grip.damping;
  if (grip.limit > 0.0) spring.limit = grip.limit;
  spring.from = grip.from;
  spring.until = grip.until;
  return spring;
}

}  // namespace

SceneModel BuildModel(const World& world, const DesignedShapes& shapes, const FixedMeshes& meshes,
                      const RecordedPaths& paths) {
  const auto find_masses = [&](const Body& body) {
    std::vector<const MassProperties*> masses(body.shapes.size(), nullptr);
    for (std::size_t i = 0; i < masses.size(); ++i) {
      if (const auto mesh = meshes.find({body.name, i}); mesh != meshes.end())
        masses[i] = &mesh->second.of_unit_density;
      if (std::holds_alternative<DesignedMeshShape>(body.shapes[i].kind)) {
        masses[i] = &shapes.at(body.name).of_unit_density;
      }
    }
    return masses;
  };
  Builder builder(CalcGravity(world), world.perturbation ? world.perturbation->speed : 1.0, paths);
  // Parents first, else in the order of the file.
  std::vector<bool> added(world.bodies.size(), false);
  for (std::size_t count = 0; count < world.bodies.size(); ++count) {
    for (std::size_t i = 0; i < world.bodies.size(); ++i) {
      const Body& body = world.bodies[i];
      if (added[i] || (body.parent != kWorldName && builder.model().body_index.count(body.parent) == 0)) continue;
      builder.Add(body, find_masses(body));
      added[i] = true;
      break;
    }
  }
  for (const Rope& rope : world.ropes) builder.Add(rope);
  SceneModel model = builder.Finish();
  for (std::size_t i = 0; i < world.contacts.size(); ++i) AddContact(world, i, shapes, meshes, &model);
  for (const Grip& grip : world.grips) model.grips.push_back(MakeGrip(world, grip, model));
  return model;
}

}  // namespace knap
