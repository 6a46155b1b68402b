#include "sim/rollout/build_body.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/math/so3.h"
#include "sim/scenarios/check_rules.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d RotationFromRpy(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Pose MakePose(const Shape& shape) { return {RotationFromRpy(shape.orientation_rpy), shape.position}; }

namespace {

// A shape that is filled evenly, in B.
struct Solid {
  double volume = 0.0;  // [m³]
  Vector3d center = Vector3d::Zero();
  Matrix3d inertia_per_mass = Matrix3d::Zero();  // about the centre [m²]
};

// Of a shape around Go, with the axes of G as principal ones.
std::optional<Solid> MakeSolid(double volume, const Vector3d& moments_per_mass, const Pose& X_BG) {
  return Solid{volume, X_BG.p, X_BG.R * moments_per_mass.asDiagonal() * X_BG.R.transpose()};
}

std::optional<Solid> FillShape(const Shape& shape, const MassProperties* of_unit_density) {
  const Pose X_BG = MakePose(shape);
  const auto fill_mesh = [&]() -> std::optional<Solid> {
    const double volume = of_unit_density->mass;
    return Solid{volume, of_unit_density->CalcCenter(), of_unit_density->CalcCentralInertia() / volume};
  };
  return std::visit(
      Overloaded{[](const HalfSpaceShape&) -> std::optional<Solid> { return std::nullopt; },
                 [&](const SphereShape& s) {
                   const double r = s.radius;
                   return MakeSolid(4.0 / 3.0 * std::numbers::pi * r * r * r, Vector3d::Constant(0.4 * r * r), X_BG);
                 },
                 [&](const BoxShape& s) {
                   const Vector3d s2 = s.size.cwiseAbs2() / 12.0;
                   return MakeSolid(s.size.prod(), Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y()), X_BG);
                 },
                 [&](const CylinderShape& s) {
                   const double r2 = s.radius * s.radius;
                   const double across = s.length * s.length / 12.0 + r2 / 4.0;
                   return MakeSolid(std::numbers::pi * r2 * s.length, Vector3d(across, across, 0.5 * r2), X_BG);
                 },
                 [&](const CapsuleShape& s) {
                   const double r = s.radius;
                   const double l = s.length;
                   const double cylinder = std::numbers::pi * r * r * l;
                   const double ends = 4.0 / 3.0 * std::numbers::pi * r * r * r;
                   const double volume = cylinder + ends;
                   // Half spheres have their centres of mass 3r/8 beyond the cylinder's ends.
                   const double across =
                       cylinder * (l * l / 12.0 + r * r / 4.0) + ends * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * l * r);
                   const double along = cylinder * 0.5 * r * r + ends * 0.4 * r * r;
                   return MakeSolid(volume, Vector3d(across, across, along) / volume, X_BG);
                 },
                 [&](const DesignedMeshShape&) { return fill_mesh(); }, [&](const MeshShape&) { return fill_mesh(); }},
      shape.kind);
}

std::vector<Solid> FillShapes(const Body& body, const std::vector<const MassProperties*>& of_unit_density) {
  std::vector<Solid> solids;
  for (std::size_t i = 0; i < body.shapes.size(); ++i) {
    if (const std::optional<Solid> solid = FillShape(body.shapes[i], of_unit_density[i])) solids.push_back(*solid);
  }
  if (solids.empty() || solids.size() < body.shapes.size()) {
    throw std::runtime_error(fmt::format(
        "body '{}': a solid inertia needs spheres, capsules, cylinders, boxes or meshes as shapes; give it explicitly",
        body.name));
  }
  return solids;
}

Matrix6d SumUp(const std::vector<Solid>& solids, double density) {
  Matrix6d M = Matrix6d::Zero();
  for (const Solid& solid : solids) {
    const double mass = density * solid.volume;
    M += MakeSpatialInertia(mass, solid.center, mass * solid.inertia_per_mass);
  }
  return M;
}

}  // namespace

Matrix6d MakeInertia(const Body& body, const std::vector<const MassProperties*>& of_unit_density) {
  if (!body.inertia) return Matrix6d::Zero();
  return std::visit(
      Overloaded{[&](const SolidInertia& i) {
                   if (FindShape<DesignedMeshShape>(body) != nullptr) {
                     throw std::runtime_error(
                         fmt::format("body '{}': the mass of a designed mesh follows from a density", body.name));
                   }
                   const std::vector<Solid> solids = FillShapes(body, of_unit_density);
                   double volume = 0.0;
                   for (const Solid& solid : solids) volume += solid.volume;
                   return SumUp(solids, i.mass / volume);
                 },
                 [&](const DensityInertia& i) { return SumUp(FillShapes(body, of_unit_density), i.density); },
                 [](const ExplicitInertia& i) {
                   Matrix3d I = i.moments.asDiagonal();
                   I(0, 1) = I(1, 0) = i.products(0);
                   I(0, 2) = I(2, 0) = i.products(1);
                   I(1, 2) = I(2, 1) = i.products(2);
                   return MakeSpatialInertia(i.mass, i.center, I);
                 }},
      *body.inertia);
}

namespace {

JointLimit MakeLimit(const std::optional<JointLimits>& limits) {
  if (!limits) return {};
  return {limits->lower, limits->upper, limits->stiffness, limits->damping, limits->width};
}

template <class OneDofJoint>
JointLaw MakeOneDofLaw(const OneDofJoint& joint) {
  return {joint.damping, joint.stiffness, Vector3d(joint.rest, 0.0, 0.0), MakeLimit(joint.limits)};
}

}  // namespace

JointLaw MakeLaw(const RevoluteJoint& joint) { return MakeOneDofLaw(joint); }
JointLaw MakeLaw(const PrismaticJoint& joint) { return MakeOneDofLaw(joint); }
JointLaw MakeLaw(const BallJoint& joint) {
  const Eigen::AngleAxisd rest(RotationFromRpy(joint.rest_rpy));
  return {joint.damping, joint.stiffness, rest.angle() * rest.axis(), {}};
}

Actuator MakeActuator(const JointActuator& actuator, int body) {
  return std::visit(
      Overloaded{[&](const ForceActuator& a) { return Actuator{body, 0, ActuatorKind::kForce, a.limit, 0.0, 0.0}; },
                 [&](const PositionActuator& a) {
                   return Actuator{body, 0, ActuatorKind::kPosition, a.limit, a.stiffness, a.damping};
                 }},
      actuator);
}

ActuatorCommand MakeCommand(const JointActuator& actuator, const std::string& body) {
  const auto* position = std::get_if<PositionActuator>(&actuator);
  if (position == nullptr) return {body, 0.0, 1.0};
  return {body, 0.5 * (position->lower + position->upper), 0.5 * (position->upper - position->lower)};
}

}  // namespace knap
