// Implicit time stepping of a tree in contact.
//
// Time is a grid of whole steps, on which samples, controls and blocks of records lie. Within each, either one step of
// fixed length is taken, by BDF1 or BDF2, or as many of TR-BDF2 as an error asks for (step_control.h). TR-BDF2 looks at
// the acceleration at its start: where forces jump, at the beginning and where controls or grips change, a step of BDF1
// of kRestartShare of a whole one leads to a state whose acceleration is that of the new forces. Its own error, half
// its length squared times the acceleration, is far below all others.
//
// Each solve is of r(xi) = 0 (dynamics.h) by Newton with a backtracking line search, from a predicted acceleration
// (acceleration_predictor.h). The residual is tested before the first iteration, so what rests costs one evaluation. A
// row's residual is judged against the magnitudes of the terms it sums, the largest of its joint: scaled residual =
// max_rows |r| / magnitude. Where the line search is held up, Newton's matrix being nearly singular, the step is begun
// again with added inertia (solve_step.cc). A root that turns a joint by kLongestTurn or more is none: where everything
// has been thrown away, forces are small beside the inertial terms, which are quadratic in the rates and judge the
// residual. A fixed step that does not converge even so is cut in two, by BDF1, up to kMaxSubdivisions times; one of
// chosen length is begun again with a quarter of it, down to kLeastShare of a whole step. What still fails, and more
// than CalcMostIterations, ends the trajectory with converged = false. A step that leads through a body
// (ContactModel::FindPassage) is cut likewise; what passes even in the least step is named by the certificate.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/acceleration_predictor.h"
#include "sim/integrators/control_sequence.h"
#include "sim/integrators/feedback.h"
#include "sim/integrators/step_control.h"
#include "sim/integrators/trajectory.h"
#include "sim/multibody/dynamics.h"

namespace knap {

inline constexpr int kMaxSubdivisions = 8;
// Shares of a whole step: of the step that finds the acceleration anew, and of the least one that is tried.
inline constexpr double kRestartShare = 0x1p-8;
inline constexpr double kLeastShare = 0x1p-20;
// Where a mechanism jams, steps become ever shorter without failing. Newton's iterations that a trajectory of chosen
// steps may take: some fifty times what the gallery's need at the default tolerance (seven a whole step).
constexpr long CalcMostIterations(int whole_steps) { return 32768L + 256L * whole_steps; }

// Half a turn: a step that spans more cannot tell which way a joint went [rad].
inline constexpr double kLongestTurn = std::numbers::pi;
// A scaled residual that no step along Newton's direction lowers any more is accepted below this: what is left is
// rounding, which grows with the stiffness of the contact. The certificate reports it as it is.
inline constexpr double kRoundingFloor = 1e-11;

struct SimulationOptions {
  double step = 1e-3;  // a whole step [s]
  int steps = 0;       // whole steps
  int order = 2;       // of fixed steps: 1 or 2
  // > 0: TR-BDF2 with steps of at most this error, no longer than a whole one. 0: fixed steps.
  double tolerance = 0.0;
  // With a tolerance: where the steps of another trajectory end, in place of chosen ones; they stay there
  // (Trajectory::ListNodes) or follow this one's touchdowns (ListFollowingNodes). Null: chosen.
  std::shared_ptr<const TimeNodeList> nodes;
  double newton_tolerance = 1e-10;
  int newton_max_iterations = 30;
  std::size_t memory = std::size_t{256} << 20;  // of a trajectory's records; beyond, they are computed again [bytes]
  std::function<void(int)> progress;            // called with the whole steps done, now and then; may be empty
};

class Simulator {
 public:
  // Both must outlive the simulator.
  Simulator(Dynamics* dynamics, ContactModel* contacts);

  // From (q0, v0) at time 0. `controls` has a row for each of the tree's actuators, or no values. With a feedback law
  // (may be null) it has a column for every interval of the options' steps; the law overwrites its own rows as they
  // come, and the trajectory keeps what acted.
  Trajectory Run(const Eigen::VectorXd& q0, const Eigen::VectorXd& v0, const SimulationOptions& options,
                 const ControlSequence& controls = {}, Feedback* feedback = nullptr);

  // Called at the start and after every accepted step, with the kinematics and contact reports of that state; for
  // recordings, books and tests.
  std::function<void(double time)> observer;

 private:
  // One solve to a state at `time`, which is appended.
  bool Solve(double time, const StepFormula& f, const SimulationOptions& options, Trajectory* trajectory);
  // *scaled: the scaled residual at xi_trial_, before and after.
  bool FindRoot(double time, const StepFormula& f, const SimulationOptions& options, Trajectory* trajectory,
                double* scaled);
  // At xi_trial_: whether no joint turns by kLongestTurn or more.
  bool IsWithinATurn() const;
  bool ComeNearWithAddedInertia(double time, const StepFormula& f, Trajectory* trajectory, double* scaled);
  bool CalcNewtonStep(const StepFormula& f, double added_inertia, Trajectory* trajectory);
  double CalcMerit() const;
  double Evaluate(double time, const StepFormula& f, const Trajectory& trajectory);
  // After a step that led to the trajectory's last state, which was evaluated last.
  void Accept(Trajectory* trajectory);
  void NoteContacts(double time, Trajectory* trajectory);

  // Whole steps from `begin` to `end`, or until one fails: whether none did.
  bool TakeSteps(int begin, int end, const SimulationOptions& options, Feedback* feedback, Trajectory* trajectory);
  // A whole step, or a part of one, of fixed length.
  bool TakeFixed(double time, double h, int depth, const SimulationOptions& options, Trajectory* trajectory);
  // Whole step n in steps of chosen length.
  bool TakeChosen(int n, const SimulationOptions& options, Trajectory* trajectory);
  // Likewise with given ends. False also where a touchdown that is to be followed does not come.
  bool TakeGiven(int n, const SimulationOptions& options, Trajectory* trajectory);
  bool SolveGiven(double end, const SimulationOptions& options, Trajectory* trajectory);
  // From the trajectory's last state, which was evaluated last.
  std::optional<double> FindShift(const TimeNode& node, const Trajectory& trajectory) const;
  // The step that finds the acceleration anew, before it is accepted.
  bool SolveRestart(double end, const SimulationOptions& options, Trajectory* trajectory);
  bool ForcesJumpAt(double time) const;
  // A step of chosen length, from the last state to at most `end`.
  bool ChooseStep(double end, const SimulationOptions& options, Trajectory* trajectory);
  bool TakeTrBdf2(double end, const SimulationOptions& options, Trajectory* trajectory);
  // Where forces may jump: the times that steps must not step over, ascending.
  void ListJumps(const SimulationOptions& options, const ControlSequence& controls);

  // Lets the law set interval i's controls, which begins at the trajectory's last state.
  void AskFeedback(int interval, Feedback* feedback, Trajectory* trajectory);
  // The block of whole steps from `first_step` on, as Run took them.
  Trajectory Repeat(const Trajectory::Seed& seed, int first_step, const SimulationOptions& options,
                    const ControlSequence& controls);
  Trajectory::Replay MakeReplay(const SimulationOptions& options) const;

  Dynamics* dynamics_;
  ContactModel* contacts_;
  std::vector<bool> was_active_;
  std::vector<int> joint_of_row_;
  StepControl control_;
  std::vector<double> jumps_;
  AccelerationPredictor predictor_;
  AccelerationPredictor saved_predictor_;  // of a step's start
  // Scratch of one solve.
  BristleState bristles_now_, bristles_before_, bristles_next_;
  Bristles bristle_base_;
  Eigen::VectorXd q_, v_, xi_, xi_trial_, vdot_, r_, magnitude_, scale_, scale_now_, dx_, start_, zero_;
};

}  // namespace knap
