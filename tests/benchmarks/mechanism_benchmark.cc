// Speed of mechanisms: steps a second, and what a gradient in everything costs beside them. Prints; gates nothing.
#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/gradient/adjoint.h"
#include "sim/integrators/simulate.h"
#include "sim/rollout/rollout.h"
#include "sim/scenarios/scenario_files.h"
#include "tests/sim/dynamics/flipping.h"
#include "tests/sim/dynamics/mechanisms.h"
#include "tests/sim/dynamics/rope.h"

namespace knap {
namespace {

using Eigen::VectorXd;

// Seconds of this thread on a processor: others on the machine do not count.
double Now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

VectorXd MakeCrookedPositions(const Tree& tree) {
  VectorXd q0 = tree.MakeDefaultPositions();
  VectorXd start = VectorXd::Zero(tree.nv());
  for (Eigen::Index k = 0; k < start.size(); ++k) start(k) = 0.2 * std::sin(static_cast<double>(k + 1));
  tree.AddIncrement(tree.MakeDefaultPositions(), start, &q0);
  return q0;
}

// Runs forward and adjoint in turn and reports both against each other.
void Measure(benchmark::State& state, const Tree& tree, const std::vector<ContactPair>& pairs, const VectorXd& q0,
             const SimulationOptions& options, const ControlSequence& controls) {
  Dynamics dynamics(tree);
  ContactModel contacts(pairs);
  Simulator simulator(&dynamics, &contacts);
  const VectorXd v0 = VectorXd::Zero(tree.nv());
  double forward = 0.0;
  double adjoint = 0.0;
  double steps = 0.0;
  double newton = 0.0;
  for (auto _ : state) {
    const double t0 = Now();
    const Trajectory trajectory = simulator.Run(q0, v0, options, controls);
    const double t1 = Now();
    if (!trajectory.certificate.converged) {
      state.SkipWithError("a step did not converge");
      return;
    }
    std::vector<StateCotangent> cotangents;
    StateCotangent at;
    at.body = tree.size() - 1;
    at.p_W = Eigen::Vector3d(1.0, -2.0, 0.5);
    for (int n = 1; n <= trajectory.whole_steps(); n += 20) {
      at.state = trajectory.state_of_step(n);
      cotangents.push_back(at);
    }
    const double t2 = Now();
    const TrajectoryGradient gradient = SweepAdjoint(trajectory, cotangents, &dynamics, &contacts);
    const double t3 = Now();
    benchmark::DoNotOptimize(gradient.pose0.data());
    forward += t1 - t0;
    adjoint += t3 - t2;
    steps += trajectory.whole_steps();
    newton += static_cast<double>(trajectory.certificate.newton_iterations);
  }
  state.counters["steps_per_s"] = steps / forward;
  state.counters["us_per_step"] = 1e6 * forward / steps;
  state.counters["gradient_to_forward"] = adjoint / forward;
  state.counters["newton_per_step"] = newton / steps;
  state.counters["us_per_newton"] = 1e6 * forward / newton;
}

// DiffHand's Reaching: 5 ms, controls held for 20 steps.
void BM_Finger(benchmark::State& state) {
  const Tree tree = test::MakeFinger();
  SimulationOptions options;
  options.step = 5e-3;
  options.steps = 600;
  options.newton_tolerance = 1e-10;
  ControlSequence controls;
  controls.steps_per_interval = 20;
  controls.values.resize(tree.num_controls(), 30);
  for (Eigen::Index i = 0; i < controls.values.size(); ++i) {
    controls.values(i) = 0.1 * std::sin(1.7 * static_cast<double>(i));
  }
  Measure(state, tree, {}, MakeCrookedPositions(tree), options, controls);
}
BENCHMARK(BM_Finger)->Unit(benchmark::kMillisecond);

// A scenario as it is learned from: the whole rollout and its gradient in design and controls.
void MeasureRollout(benchmark::State& state, const char* config, const std::vector<double>& variation) {
  const LoadedScenario scenario = LoadScenario(std::string(KNAP_CONFIGS "/") + config);
  if (!scenario.parsed.ok()) throw std::runtime_error(scenario.parsed.FormatErrors());
  RolloutModel model(scenario.files);
  model.clock = Now;
  RolloutInput input;
  input.theta = model.initial_theta();
  input.controls.resize(model.num_controls());
  for (Eigen::Index i = 0; i < input.controls.size(); ++i) {
    input.controls(i) = 0.4 * std::sin(0.9 * static_cast<double>(i));
  }
  input.variation = variation;
  double forward = 0.0;
  double gradient = 0.0;
  double steps = 0.0;
  double newton = 0.0;
  for (auto _ : state) {
    const RolloutOutput out = model.Run(input, {});
    benchmark::DoNotOptimize(out.loss);
    if (!out.certificate.converged) state.SkipWithError("a step did not converge");
    forward += model.forward_s;
    gradient += model.gradient_s;
    steps += out.steps;
    newton += static_cast<double>(out.certificate.newton_iterations);
  }
  state.counters["steps_per_s"] = steps / forward;
  state.counters["us_per_step"] = 1e6 * forward / steps;
  state.counters["gradient_to_forward"] = gradient / forward;
  state.counters["newton_per_step"] = newton / steps;
}

void BM_Reaching(benchmark::State& state) { MeasureRollout(state, "reaching.yaml", {}); }
BENCHMARK(BM_Reaching)->Unit(benchmark::kMillisecond);

// The pea starts a little beside the middle.
void BM_Pushing(benchmark::State& state) { MeasureRollout(state, "pushing.yaml", {0.007, 0.095}); }
BENCHMARK(BM_Pushing)->Unit(benchmark::kMillisecond);

void BM_Flipping(benchmark::State& state) {
  const test::Flipping flipping = test::MakeFlipping();
  Measure(state, flipping.tree, flipping.contacts, flipping.q0, flipping.options, flipping.controls);
}
BENCHMARK(BM_Flipping)->Unit(benchmark::kMillisecond);

void MeasureChain(benchmark::State& state, const Tree& tree, const VectorXd& q0) {
  SimulationOptions options;
  options.step = 2e-3;
  options.steps = 250;
  options.newton_tolerance = 1e-10;
  Measure(state, tree, {}, q0, options, {});
}

// Ball joints, a straight chain that swings from its upper end: one motion whatever the number of links, so the time of
// a step shows what a link costs.
void BM_Chain(benchmark::State& state) {
  const Tree tree = test::MakeChain(static_cast<int>(state.range(0)), 2e-5);
  VectorXd q0 = tree.MakeDefaultPositions();
  VectorXd start = VectorXd::Zero(tree.nv());
  start.head<3>() << 0.3, 0.2, 0.1;
  tree.AddIncrement(tree.MakeDefaultPositions(), start, &q0);
  MeasureChain(state, tree, q0);
}
BENCHMARK(BM_Chain)->Arg(5)->Arg(10)->Arg(15)->Arg(20)->Arg(40)->Arg(80)->Unit(benchmark::kMillisecond);

// The same chain bent at every joint. Its kinks run along it the faster the more links pull below: the step stays, the
// motion does not, and Newton needs more iterations.
void BM_KinkedChain(benchmark::State& state) {
  const Tree tree = test::MakeChain(static_cast<int>(state.range(0)), 2e-5);
  MeasureChain(state, tree, MakeCrookedPositions(tree));
}
BENCHMARK(BM_KinkedChain)->Arg(5)->Arg(20)->Arg(80)->Unit(benchmark::kMillisecond);

// Half a second of a rope that falls onto the spool it is wound around.
// Argument: the size of the spool's ends, in percent of its middle.
void BM_RopeOnSpool(benchmark::State& state) {
  const double side = 0.05;
  const auto rope = test::MakeWoundRope(test::MakeSpool(side, 0.01 * side * static_cast<double>(state.range(0))),
                                        {2e8, 2.0, 0.3, 0.0, 1e-3, 2e-5});
  SimulationOptions options;
  options.step = 2e-3;
  options.steps = 250;
  options.newton_tolerance = 1e-10;
  Measure(state, rope.scene.tree, rope.scene.contacts, rope.scene.q0(), options, {});
}
BENCHMARK(BM_RopeOnSpool)->Arg(100)->Arg(200)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace knap
