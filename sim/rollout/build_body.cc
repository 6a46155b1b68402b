#include "sim/rollout/build_body.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/math/so3.h"

namespace knap {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d RotationFromRpy(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

namespace {

// A body that fills its shape with unit density.
struct UnitBody {
  double volume = 0.0;  // [m³]
  Vector3d center = Vector3d::Zero();
  Vector3d moments_per_mass = Vector3d::Zero();  // about the centre [m²]
};

std::optional<UnitBody> MakeUnitBody(const std::optional<Shape>& shape) {
  if (!shape) return {};
  if (const auto* sphere = std::get_if<SphereShape>(&*shape)) {
    const double r = sphere->radius;
    return UnitBody{4.0 / 3.0 * std::numbers::pi * r * r * r, Vector3d::Zero(), Vector3d::Constant(0.4 * r * r)};
  }
  if (const auto* box = std::get_if<BoxShape>(&*shape)) {
    const Vector3d s2 = box->size.cwiseAbs2() / 12.0;
    return UnitBody{box->size.prod(), box->center, Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y())};
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&*shape)) {
    const double r2 = cylinder->radius * cylinder->radius;
    const double across = cylinder->length * cylinder->length / 12.0 + r2 / 4.0;
    return UnitBody{std::numbers::pi * r2 * cylinder->length, cylinder->center, Vector3d(across, across, 0.5 * r2)};
  }
  if (const auto* capsule = std::get_if<CapsuleShape>(&*shape)) {
    const double r = capsule->radius;
    const double l = capsule->length;
    const double cylinder = std::numbers::pi * r * r * l;
    const double ends = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    const double volume = cylinder + ends;
    // Half spheres have their centres of mass 3r/8 beyond the cylinder's ends.
    const double across =
        cylinder * (l * l / 12.0 + r * r / 4.0) + ends * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * l * r);
    const double along = cylinder * 0.5 * r * r + ends * 0.4 * r * r;
    return UnitBody{volume, capsule->center, Vector3d(across, across, along) / volume};
  }
  return {};
}

}  // namespace

Matrix6d MakeInertia(const Body& body, const MassProperties* of_unit_density) {
  if (!body.inertia) return Matrix6d::Zero();
  const auto fill_mesh = [&](double density) {
    return MakeSpatialInertia(density * of_unit_density->mass, of_unit_density->CalcCenter(),
                              density * of_unit_density->CalcCentralInertia());
  };
  const auto* density = std::get_if<DensityInertia>(&*body.inertia);
  const auto* of_mass = std::get_if<SolidInertia>(&*body.inertia);
  const bool keeps_volume = body.shape && std::holds_alternative<MeshShape>(*body.shape);
  if (of_unit_density != nullptr && density != nullptr) return fill_mesh(density->density);
  if (of_unit_density != nullptr && of_mass != nullptr && keeps_volume) {
    return fill_mesh(of_mass->mass / of_unit_density->mass);
  }
  const auto solid = [&](const auto& mass_of_volume) {
    const std::optional<UnitBody> unit = MakeUnitBody(body.shape);
    if (!unit) {
      throw std::runtime_error(fmt::format(
          "body '{}': a solid inertia needs a sphere, capsule, cylinder, box or mesh as shape; give it explicitly",
          body.name));
    }
    const double mass = mass_of_volume(unit->volume);
    const Vector3d moments = mass * unit->moments_per_mass;
    return MakeSpatialInertia(mass, unit->center, moments.asDiagonal());
  };
  return std::visit(
      Overloaded{[&](const SolidInertia& i) { return solid([&](double) { return i.mass; }); },
                 [&](const DensityInertia& i) { return solid([&](double volume) { return i.density * volume; }); },
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
