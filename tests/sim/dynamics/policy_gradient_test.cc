// The gradient of closed-loop rollouts: random trees under a random network that sees every kind of signal, in
// free motion and touching a floor. All kinds of parameter are compared with differences, so the way through the state
// at the start of each interval (what the policy sees of it) is in every one of them; the weights too.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "sim/math/so3.h"
#include "sim/signals/body_signals.h"
#include "sim/signals/combined_signals.h"
#include "sim/signals/coordinate_signals.h"
#include "sim/signals/group_signals.h"
#include "sim/signals/track_signals.h"
#include "tests/sim/dynamics/random_world.h"

namespace knap {
namespace policy_gradient_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::CompareSlopes;
using test::MakeDirections;
using test::MakeWorldCase;
using test::RandomTree;
using test::WorldCase;
using test::WorldDirection;

// One of every kind of signal that a policy may see, and a second position; of one watched point each.
std::vector<PolicyInput> MakeInputs(RandomTree* random, int* num_points) {
  const int n = random->tree.size();
  std::vector<SignalPointer> signals;
  for (const TreeBody& body : random->tree.bodies()) {
    if (CountDof(body.joint) != 1) continue;
    signals.push_back(MakeCoordinateSignal(body.q_start, body.v_start));
    signals.push_back(MakeRateSignal(body.v_start));
  }
  *num_points = 0;
  const auto pick_point = [&] { return WatchedPoint{random->Pick(n), random->Vec(), (*num_points)++}; };
  const auto pick_frame = [&] { return random->Pick(n + 1) - 1; };
  const auto pick_axis = [&] { return Vector3d(random->Vec().normalized()); };
  std::vector<int> massive;
  for (int i = 0; i < n; ++i) {
    if (random->tree.bodies()[i].M(3, 3) > 0.0) massive.push_back(i);
  }
  const Group group(random->tree, massive);
  for (int i = 0; i < 2; ++i) {
    const WatchedPoint point = pick_point();
    const int in = pick_frame();
    signals.push_back(MakePositionSignal(point, in, pick_axis()));
  }
  const WatchedPoint fast = pick_point();
  signals.push_back(MakeVelocitySignal(fast, pick_axis()));
  const int turned = random->Pick(n);
  const Vector3d of = pick_axis();
  const int in = pick_frame();
  signals.push_back(MakeDirectionSignal(turned, of, in, pick_axis()));
  const int turning = random->Pick(n);
  signals.push_back(MakeAngularVelocitySignal(turning, pick_axis()));
  const WatchedPoint far = pick_point();
  const int from = pick_frame();
  signals.push_back(MakeDistanceSignal(far, from, {{0.0, random->Vec()}, {1e-3, random->Vec()}}));
  const int carrier = pick_frame();
  if (!massive.empty()) signals.push_back(MakeCenterSignal(group, carrier, pick_axis()));
  signals.push_back(MakeTimeSignal());
  signals.push_back(MakeConstantSignal(random->U()));
  const std::vector<SignalPointer> parts(signals.end() - 5, signals.end());
  signals.push_back(MakeNormSignal(parts));
  signals.push_back(MakeLeastSignal(parts));
  signals.push_back(MakeLargestSignal(parts));
  signals.push_back(MakeDifferenceSignal(parts[0], parts[1]));
  std::vector<PolicyInput> inputs;
  for (const SignalPointer& signal : signals) inputs.push_back({signal, random->U(), 1.5 + random->U()});
  return inputs;
}

// Drives all force actuators but the first of the tree, whose controls stay open loop; false: the tree has no two.
bool AddPolicy(RandomTree* random, WorldCase* at) {
  std::vector<PolicyOutput> outputs;
  for (int a = 1; a < random->tree.num_controls(); ++a) outputs.push_back({a, 0.1 * random->U(), 0.5});
  if (outputs.empty()) return false;
  int num_points = 0;
  const std::vector<PolicyInput> inputs = MakeInputs(random, &num_points);
  const Network network(static_cast<int>(inputs.size()), {3, 2}, static_cast<int>(outputs.size()),
                        random->Pick(2) == 0);
  ControlSequence& controls = at->world.controls;
  controls.values = Eigen::MatrixXd::NullaryExpr(random->tree.num_controls(), 4, [&] { return 0.9 * random->U(); });
  at->world.weights = random->Values(network.num_weights(), 1.0);
  at->world.make_policy = [=](const VectorXd& weights) {
    return ClosedLoop(network, inputs, outputs, weights, 4, num_points);
  };
  return true;
}

// A tilted floor under a ball on a body, in touch at the start.
void AddFloor(RandomTree* random, WorldCase* at) {
  const Tree tree = at->world.MakeTree();
  Dynamics dynamics(tree);
  dynamics.CalcKinematics(at->world.q0, at->world.v0, VectorXd::Zero(tree.nv()), 0.0);
  ContactPair pair;
  pair.bodies = {random->Pick(tree.size()), tree.size()};
  pair.shapes = {SphereGeometry{0.4, Vector3d::Zero()}, HalfSpaceGeometry{}};
  pair.material = {60.0, 0.3, 0.5, 0.05, 0.3, 0.05};
  TreeBody floor;
  const Eigen::Matrix3d R = ExpSo3(3.0 * random->Vec()).toRotationMatrix();
  floor.X_PF = {R, dynamics.kinematics()[pair.bodies[0]].X_WB.p - 0.3 * R.col(2)};
  at->world.bodies.push_back(floor);
  at->world.contacts.push_back(pair);
  for (auto* list : {&at->loss.a, &at->loss.b, &at->loss.c, &at->loss.d}) list->push_back(Vector3d::Zero());
}

// Compares the slopes of every kind, the weights' too. Counts the kinds that were compared.
void Compare(RandomTree* random, const WorldCase& at, double tolerance, std::map<std::string, int>* compared) {
  VectorXd bar_weights;
  const TrajectoryGradient g = at.loss.Sweep(at.world, &bar_weights);
  RC_ASSERT(g.finite && g.solvable);
  // What a policy sets is nobody else's.
  RC_ASSERT(g.controls.bottomRows(g.controls.rows() - 1).isZero(0.0));
  std::vector<WorldDirection> directions = MakeDirections(random, at.world, g);
  const VectorXd dw = random->Values(static_cast<int>(at.world.weights.size()), 1.0).normalized();
  directions.push_back({"weights",
                        [dw](const test::World& from, double s) {
                          test::World moved = from;
                          moved.weights += s * dw;
                          return moved;
                        },
                        bar_weights.dot(dw)});
  CompareSlopes(at, directions, tolerance, compared);
}

void ExpectCompared(const std::map<std::string, int>& compared) {
  for (const char* kind : {"initial pose", "initial rates", "gravity", "placement", "mass", "damping", "weights"}) {
    EXPECT_GE(compared.count(kind) == 0 ? 0 : compared.at(kind), 5) << kind;
  }
}

TEST(PolicyGradient, EqualsDifferencesForEveryKindOfParameter) {
  std::map<std::string, int> compared;
  EXPECT_TRUE(rc::check("gradients equal differences", [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    WorldCase at = MakeWorldCase(&random);
    RC_PRE(AddPolicy(&random, &at));
    Compare(&random, at, 1e-7, &compared);
  }));
  ExpectCompared(compared);
  EXPECT_GE(compared["force control"] + compared["position control"], 5);
}

TEST(PolicyGradient, EqualsDifferencesWhileTouching) {
  std::map<std::string, int> compared;
  EXPECT_TRUE(rc::check("gradients equal differences", [&] {
    RandomTree random(*rc::gen::arbitrary<std::uint64_t>());
    WorldCase at = MakeWorldCase(&random);
    RC_PRE(AddPolicy(&random, &at));
    AddFloor(&random, &at);
    test::World apart = at.world;
    apart.contacts.clear();
    RC_PRE(std::abs(at.loss.Evaluate(at.world) - at.loss.Evaluate(apart)) > 1e-3);
    Compare(&random, at, 1e-5, &compared);
  }));
  ExpectCompared(compared);
}

// Without the way through the state the gradient is another one: the test above could not pass with zeros there.
TEST(PolicyGradient, TheWayThroughTheStateMatters) {
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomTree random(seed);
    WorldCase at = MakeWorldCase(&random);
    if (!AddPolicy(&random, &at)) continue;
    VectorXd bar_weights;
    const TrajectoryGradient closed = at.loss.Sweep(at.world, &bar_weights);
    // The same motion with the same controls, but none of them asks the state.
    test::World open = at.world;
    const Tree tree = open.MakeTree();
    Dynamics dynamics(tree);
    ContactModel contacts = open.MakeContacts();
    ClosedLoop policy = open.make_policy(open.weights);
    open.controls =
        Simulator(&dynamics, &contacts).Run(open.q0, open.v0, at.loss.options, open.controls, &policy).controls;
    open.make_policy = {};
    const TrajectoryGradient held = at.loss.Sweep(open);
    if ((closed.v0 - held.v0).norm() > 1e-3 * held.v0.norm()) ++seen;
  }
  EXPECT_GE(seen, 10);
}

}  // namespace policy_gradient_test
}  // namespace knap
