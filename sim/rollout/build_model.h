// Turns a scene and its designed shapes into what the simulator runs: a tree, contacts, an initial state.
//
// A free joint becomes a translation and a ball, a planar joint two prismatic ones and a revolute; the named body is
// the last of them. Bodies may be listed in any order. A rope becomes a translation and its links, after all bodies.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/geometry/mass_properties.h"
#include "sim/multibody/tree.h"
#include "sim/rollout/fixed_meshes.h"
#include "sim/rollout/recorded_paths.h"
#include "sim/scenarios/scene.h"

namespace knap {

// A designed body's shape at one theta, in its B.
struct DesignedShape {
  TriangleMesh mesh;
  MassProperties of_unit_density;  // at 1 kg/m³
  MeshGeometry contact;            // without a mesh where nothing touches it
  std::string fault{};  // why the mesh bounds no body at this theta; then it has neither mass nor contact. Else empty
};
using DesignedShapes = std::map<std::string, DesignedShape>;  // by the body's name

// The control of one of the tree's actuators: center + half·u for a command u (joint_forces.h).
struct ActuatorCommand {
  std::string body;  // by whose name the actuator is known
  double center = 0.0;
  double half = 1.0;
};

struct SceneModel {
  Tree tree;
  std::vector<ContactPair> contacts;
  std::vector<GripSpring> grips;  // in the order of the scene
  // For each contact's two shapes: the designed body whose mesh it is, else empty.
  std::vector<std::array<std::string, 2>> contact_meshes;
  std::vector<int> contact_of_pair;               // which of the scene's contacts one of `contacts` belongs to
  std::vector<ActuatorCommand> actuators;         // in the tree's order
  std::map<std::string, int> body_index;          // name → index in the tree
  std::map<std::string, int> joint_index;         // name → index of the body whose placement is that of the joint
  std::map<std::string, std::vector<int>> links;  // of a rope, from its first link
  Eigen::VectorXd q0;
  Eigen::VectorXd v0;
};

// In W [m/s²].
Eigen::Vector3d CalcGravity(const World& world);

// R_WL of a straight rope's links: z as near to the world's as the direction lets it be, else y.
Eigen::Matrix3d MakeLinkAxes(const Eigen::Vector3d& direction_W);

// `shapes` of all designed bodies, without faults; `meshes` of all others that have one. Throws std::runtime_error with
// one line naming what this simulator cannot do: a contact of a body without shapes, a mass spread over a shape
// without a volume. Contacts that ContactModel refuses are reported there.
SceneModel BuildModel(const World& world, const DesignedShapes& shapes, const FixedMeshes& meshes = {},
                      const RecordedPaths& paths = {});

}  // namespace knap
