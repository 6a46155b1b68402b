// Turns a scene and a designed mesh into what the simulator runs: a tree, contacts, an initial state.
//
// A free joint becomes a translation and a ball, a planar joint two prismatic ones and a revolute; the named body is
// the last of them. Bodies may be listed in any order. A rope becomes a translation and its links, after all bodies.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/multibody/tree.h"
#include "sim/scenarios/scene.h"

namespace knap {

struct SceneModel {
  Tree tree;
  std::vector<ContactPair> contacts;
  std::map<std::string, int> body_index;           // name → index in the tree
  std::map<std::string, std::vector<int>> links;   // of a rope, from its first link
  std::vector<int> contact_of_pair;                // which of the scene's contacts a pair of `contacts` belongs to
  Eigen::VectorXd q0;
  Eigen::VectorXd v0;
};

// `mesh` is the designed body's, null without one. Throws std::runtime_error with one line naming what this simulator
// cannot do: a designed body that moves freely, a contact of a body without a shape. Contacts that ContactModel refuses
// are reported there.
SceneModel BuildModel(const Scene& scene, std::shared_ptr<const ContactMesh> mesh);

// The sample points that the contacts of the designed mesh need, on its initial shape; null when they need none.
std::shared_ptr<const SurfaceSampling> MakeSampling(const Scene& scene, const TriangleMesh& reference);

}  // namespace knap
