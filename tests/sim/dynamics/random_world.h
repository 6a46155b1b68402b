// A random world, a loss on its trajectory, and for every kind of parameter a direction in which the world can change,
// with the slope that the adjoint predicts: what tests of gradients compare with differences.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/policy/closed_loop.h"
#include "tests/sim/dynamics/random_tree.h"

namespace knap::test {

// All that a trajectory depends on.
struct World {
  std::vector<TreeBody> bodies;
  std::vector<Actuator> actuators;
  Eigen::Vector3d gravity;
  Eigen::VectorXd q0;
  Eigen::VectorXd v0;
  ControlSequence controls;
  std::vector<ContactPair> contacts;
  std::vector<GripSpring> grips;
  // Of the contacts that have a mesh: theirs, which takes the place of what `contacts` say.
  struct ContactMeshOf {
    int contact = 0;
    int side = 0;  // 0 or 1: which of the two shapes it is
    TriangleMesh mesh;
  };
  std::vector<ContactMeshOf> meshes;
  // A closed-loop policy that takes the place of some controls; empty: none.
  std::function<ClosedLoop(const Eigen::VectorXd& weights)> make_policy;
  Eigen::VectorXd weights;

  Tree MakeTree() const { return RandomTree::Rebuild(bodies, actuators, gravity); }
  ContactModel MakeContacts() const;
};

// Of each body, halfway and at the end: a linear function of position, velocity, orientation and angular velocity, and
// the square of the position; of a policy's commands: half the sum of their squares. A world whose trajectory fails or
// needs smaller steps is none to compare: RC_PRE.
struct WorldLoss {
  std::vector<Eigen::Vector3d> a, b, c, d;
  SimulationOptions options;

  double Evaluate(const World& world) const;
  // `bar_weights`: of the world's policy, null where it has none.
  TrajectoryGradient Sweep(const World& world, Eigen::VectorXd* bar_weights = nullptr) const;
};

// One way of changing a world, and the slope that the adjoint predicts for it.
struct WorldDirection {
  std::string kind;
  std::function<World(const World&, double)> move;
  double slope = 0.0;
};

// One direction of unit length for each kind of parameter and each body that has it.
std::vector<WorldDirection> MakeDirections(RandomTree* random, const World& world, const TrajectoryGradient& g);

// A world without contact, and its loss.
struct WorldCase {
  World world;
  WorldLoss loss;
};
WorldCase MakeWorldCase(RandomTree* random);

// Slopes in the given directions against differences (slope_comparison.h): RC_FAIL where they disagree.
void CompareSlopes(const WorldCase& at, const std::vector<WorldDirection>& directions, double tolerance,
                   std::map<std::string, int>* compared);

// The sweep's, in all of MakeDirections.
void CompareEveryKind(RandomTree* random, const WorldCase& at, double tolerance, std::map<std::string, int>* compared);

// Along all those directions at once: CheckTaylorRemainder's answer.
std::string CheckTaylorRemainderOfEveryKind(RandomTree* random, const WorldCase& at);

}  // namespace knap::test
