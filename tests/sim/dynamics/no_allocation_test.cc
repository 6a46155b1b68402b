// Counts every allocation of the program (Eigen's too, which bypass operator new): steps of a warm simulator make none.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "sim/integrators/simulate.h"
#include "sim/policy/closed_loop.h"
#include "sim/signals/body_signals.h"
#include "sim/signals/coordinate_signals.h"
#include "sim/signals/track_signals.h"
#include "tests/sim/dynamics/mechanisms.h"
#include "tests/sim/dynamics/random_tree.h"
#include "tests/sim/dynamics/rope.h"

// Stands before the C library's malloc, which it calls. A sanitizer wants that place itself.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define KNAP_COUNTS_ALLOCATIONS 1
namespace {
std::atomic<long> g_allocations{0};
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void* malloc(std::size_t size) {
  ++g_allocations;
  return __libc_malloc(size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++g_allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace knap {
namespace {

using Eigen::VectorXd;

#ifdef KNAP_COUNTS_ALLOCATIONS

// No allocation between the second state of a run and its last one.
void ExpectNone(const Tree& tree, const VectorXd& q0, const ControlSequence& controls, ContactModel* contacts, int runs,
                Feedback* feedback = nullptr) {
  Dynamics dynamics(tree);
  Simulator simulator(&dynamics, contacts);
  SimulationOptions options;
  options.step = 2e-3;
  options.steps = 100;
  const VectorXd v0 = VectorXd::Constant(tree.nv(), 0.3);
  for (int run = 1; run < runs; ++run) simulator.Run(q0, v0, options, controls, feedback);
  long before = 0;
  long after = -1;
  int states = 0;
  simulator.observer = [&](double) {
    if (++states == 2) before = g_allocations;
    if (states == options.steps) after = g_allocations;
  };
  const Trajectory t = simulator.Run(q0, v0, options, controls, feedback);
  EXPECT_TRUE(t.certificate.converged);
  EXPECT_GT(before, 0);  // the counter counts
  EXPECT_EQ(after - before, 0);
  EXPECT_GT(t.certificate.newton_iterations, 50);
}

TEST(NoAllocation, WithinTheStepsOfAFingerUnderControl) {
  const Tree tree = test::MakeFinger();
  ControlSequence controls;
  controls.steps_per_interval = 20;
  controls.values = Eigen::MatrixXd::Constant(tree.num_controls(), 5, 0.1);
  ContactModel none({});
  ExpectNone(tree, tree.MakeDefaultPositions(), controls, &none, 1);
}

TEST(NoAllocation, WithinTheStepsOfAFingerUnderAPolicy) {
  const Tree tree = test::MakeFinger();
  const std::vector<PolicyInput> inputs = {
      {MakeCoordinateSignal(0, 0), 0.0, 1.0},
      {MakeRateSignal(0), 0.0, 1.0},
      {MakePositionSignal({tree.size() - 1, Eigen::Vector3d::Zero(), 0}, kWorldFrame, Eigen::Vector3d::UnitX()), 0.0,
       1.0},
      {MakeTimeSignal(), 0.0, 1.0}};
  std::vector<PolicyOutput> outputs;
  for (int i = 0; i < tree.num_controls(); ++i) outputs.push_back({i, 0.0, 0.1});
  const Network network(4, {8, 8}, tree.num_controls(), true);
  ControlSequence controls;
  controls.steps_per_interval = 10;
  controls.values.setZero(tree.num_controls(), 10);
  ClosedLoop policy(network, inputs, outputs, VectorXd::Constant(network.num_weights(), 0.2), 10, 1);
  ContactModel none({});
  ExpectNone(tree, tree.MakeDefaultPositions(), controls, &none, 1, &policy);
}

TEST(NoAllocation, WithinTheStepsOfAChain) {
  const Tree tree = test::MakeChain(15, 2e-5);
  ContactModel none({});
  ExpectNone(tree, tree.MakeDefaultPositions(), {}, &none, 1);
}

// Once as many points have touched as ever will. Bristles would be recorded, which takes room by doubling.
TEST(NoAllocation, WithinTheStepsOfARopeInContactThatHasRunBefore) {
  const test::WoundRope rope = test::MakeWoundRope(test::MakeSpool(0.05, 0.1), {2e8, 2.0, 0.3, 0.0, 1e-3, 0.0});
  ContactModel contacts(rope.scene.contacts);
  ExpectNone(rope.scene.tree, rope.scene.q0(), {}, &contacts, 2);
  const auto& reports = contacts.reports();
  EXPECT_TRUE(std::any_of(reports.begin(), reports.end(), [](const ContactReport& report) { return report.active; }));
}

TEST(NoAllocation, InACoupledFactorisationOnceSized) {
  test::RandomTree random(3);
  random.Couple(6);
  Dynamics dynamics(random.tree);
  VectorXd r(random.tree.nv());
  VectorXd magnitude(random.tree.nv());
  VectorXd x(random.tree.nv());
  const VectorXd v = VectorXd::Constant(random.tree.nv(), 0.3);
  long before = 0;
  for (int pass = 0; pass < 3; ++pass) {
    if (pass == 1) before = g_allocations;
    dynamics.CalcKinematics(random.q, v, v, 0.1);
    for (const auto& c : random.couplings) dynamics.cross().push_back({c.body, c.other, c.by_twist, c.by_twist});
    dynamics.CalcResidual(0.0, &r, &magnitude);
    ASSERT_TRUE(dynamics.Factor(random.xi, 3.0, 7.0));
    dynamics.Solve(r, &x);
    dynamics.SolveTransposed(r, &x);
  }
  EXPECT_EQ(g_allocations - before, 0);
}

#else

TEST(NoAllocation, Skipped) { GTEST_SKIP() << "allocations cannot be counted under a sanitizer or without glibc"; }

#endif

}  // namespace
}  // namespace knap
