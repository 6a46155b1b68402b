// What a body of a scene is made of, as the tree wants it: inertia, joint law, actuator.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "sim/geometry/mass_properties.h"
#include "sim/multibody/tree.h"
#include "sim/rollout/build_model.h"
#include "sim/scenarios/scene.h"

namespace knap {

// Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d RotationFromRpy(const Eigen::Vector3d& rpy);

// X_BG of a shape.
Pose MakePose(const Shape& shape);

// Zero without an inertia. `of_unit_density`: for each of the body's shapes, of its mesh, which bounds a body, else
// null. What shapes share counts twice. Throws std::runtime_error with one line where a mass is spread over a shape
// without a volume of its own, or over a designed mesh.
Matrix6d MakeInertia(const Body& body, const std::vector<const MassProperties*>& of_unit_density);

JointLaw MakeLaw(const RevoluteJoint& joint);
JointLaw MakeLaw(const PrismaticJoint& joint);
JointLaw MakeLaw(const BallJoint& joint);

Actuator MakeActuator(const JointActuator& actuator, int body);
ActuatorCommand MakeCommand(const JointActuator& actuator, const std::string& body);

}  // namespace knap
