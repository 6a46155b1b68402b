// The adjoint's gradient in every kind of parameter against differences, on random trees whose bodies touch a floor and
// one another: contact with fixed, prescribed and freely moving bodies, with meshes, and with both laws of friction.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/math/so3.h"
#include "tests/sim/dynamics/random_world.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace touching_gradient_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::CheckTaylorRemainderOfEveryKind;
using test::CompareEveryKind;
using test::MakeWorldCase;
using test::RandomTree;
using test::World;
using test::WorldCase;

constexpr double kHalf = 0.4;  // of boxes and of the mesh, a cube [m]

// Adds contacts between shapes that overlap at the start.
class Toucher {
 public:
  Toucher(RandomTree* random, World* world) : random_(*random), world_(*world) {
    const Tree tree = world_.MakeTree();
    Dynamics dynamics(tree);
    dynamics.CalcKinematics(world_.q0, world_.v0, VectorXd::Zero(tree.nv()), 0.0);
    for (const BodyKinematics& body : dynamics.kinematics()) p_.push_back(body.X_WB.p);
  }

  // A half-space on the world under a ball, a box or the mesh on `body`, tilted at random.
  void TouchFloor(int body) {
    TreeBody floor;
    const Eigen::Matrix3d R = ExpSo3(3.0 * random_.Vec()).toRotationMatrix();
    const int kind = random_.Pick(3);
    floor.X_PF = {R, p_[body] - 0.3 * R.col(2)};
    world_.bodies.push_back(floor);
    const int ground = static_cast<int>(world_.bodies.size()) - 1;
    const ContactGeometry box = BoxGeometry{Vector3d::Constant(kHalf), Vector3d::Zero()};
    Add(body, kind == 0 ? ContactGeometry(SphereGeometry{kHalf, 0.05 * random_.Vec()}) : box, ground,
        HalfSpaceGeometry{});
    if (kind == 2) MakeMesh(0);
  }

  // Two balls, or a ball and the mesh.
  void TouchEachOther(int a, int b) {
    const double distance = (p_[a] - p_[b]).norm();
    if (a == b || distance < 1.1 * kHalf) return;
    const SphereGeometry ball{std::max(distance - 0.9 * kHalf, 0.3), 0.05 * random_.Vec()};
    Add(a, ball, b, SphereGeometry{kHalf, Vector3d::Zero()});
    if (random_.Pick(2) == 0) MakeMesh(1);
  }

 private:
  void Add(int a, const ContactGeometry& shape_a, int b, const ContactGeometry& shape_b) {
    ContactPair pair;
    pair.bodies = {a, b};
    pair.shapes = {shape_a, shape_b};
    pair.material = {60.0, 0.3, 0.5, 0.05, 0.3, random_.Pick(2) == 0 ? 0.05 : 0.0};
    world_.contacts.push_back(pair);
  }

  // Puts a cube's mesh in place of one shape of the contact added last.
  void MakeMesh(int side) {
    World::ContactMeshOf of;
    of.contact = static_cast<int>(world_.contacts.size()) - 1;
    of.side = side;
    of.mesh = test::MakeBar(kHalf, 2.0 * kHalf, 2.0 * kHalf, 3, 3);
    for (Vector3d& v : of.mesh.vertices) v += Vector3d(0.0, kHalf, -kHalf) + 0.03 * random_.Vec();
    world_.meshes.push_back(of);
  }

  RandomTree& random_;
  World& world_;
  std::vector<Vector3d> p_;  // of the bodies' origins in the world at the start
};

WorldCase MakeTouchingCase(RandomTree* random) {
  WorldCase out = MakeWorldCase(random);
  const int n = random->tree.size();
  Toucher toucher(random, &out.world);
  toucher.TouchFloor(random->Pick(n));
  toucher.TouchEachOther(random->Pick(n), random->Pick(n));
  toucher.TouchEachOther(random->Pick(n), random->Pick(n));
  while (out.loss.a.size() < out.world.bodies.size()) {
    for (auto* list : {&out.loss.a, &out.loss.b, &out.loss.c, &out.loss.d}) list->push_back(Vector3d::Zero());
  }
  return out;
}

// How much of the loss there is because bodies touch.
double CalcWeightOfContact(const WorldCase& at) {
  World apart = at.world;
  apart.contacts.clear();
  apart.meshes.clear();
  return std::abs(at.loss.Evaluate(at.world) - at.loss.Evaluate(apart));
}

TEST(TouchingGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    const WorldCase at = MakeTouchingCase(&random);
    RC_PRE(CalcWeightOfContact(at) > 1e-3);
    CompareEveryKind(&random, at, 1e-5, &compared);
  };
  EXPECT_TRUE(rc::check("gradients equal differences", property));
  for (const char* kind :
       {"initial pose", "initial rates", "gravity", "force control", "position control", "placement",
        "placement of what does not move freely", "mass", "first moment", "rotational inertia", "damping", "stiffness",
        "ball stiffness", "rest", "rest of a ball", "revolute axis", "prismatic axis", "mesh vertices"}) {
    EXPECT_GE(compared[kind], 5) << kind;
  }
}

TEST(TouchingGradient, TaylorRemainderFallsAsTheSquare) {
  int checked = 0;
  const auto property = [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    WorldCase at = MakeTouchingCase(&random);
    for (TreeBody& body : at.world.bodies) body.law.limit = JointLimit{};
    RC_PRE(CalcWeightOfContact(at) > 1e-3);
    RC_ASSERT(CheckTaylorRemainderOfEveryKind(&random, at) == "");
    ++checked;
  };
  EXPECT_TRUE(rc::check("the remainder falls as the square", property));
  EXPECT_GE(checked, 20);
}

}  // namespace touching_gradient_test
}  // namespace knap
