// Implicit time stepping of a tree in contact.
//
// Each step solves r(xi) = 0 (dynamics.h) by Newton with a backtracking line search, from a predicted acceleration
// (acceleration_predictor.h). The residual is tested before the first iteration, so what rests costs one evaluation. A
// row's residual is judged against the magnitudes of the terms it sums, the largest of its joint: scaled residual =
// max_rows |r| / magnitude. Where the line search is held up, Newton's matrix being nearly singular, the step is begun
// again with added inertia (solve_step.cc). A root that turns a joint by kLongestTurn or more is none: where everything
// has been thrown away, forces are small beside the inertial terms, which are quadratic in the rates and judge the
// residual. A step that does not converge even so is cut in two, by BDF1, up to kMaxSubdivisions times; what still
// fails ends the trajectory with converged = false.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/acceleration_predictor.h"
#include "sim/integrators/control_sequence.h"
#include "sim/integrators/feedback.h"
#include "sim/integrators/trajectory.h"
#include "sim/multibody/dynamics.h"

namespace knap {

inline constexpr int kMaxSubdivisions = 8;
// Half a turn: a step that spans more cannot tell which way a joint went [rad].
inline constexpr double kLongestTurn = std::numbers::pi;
// A scaled residual that no step along Newton's direction lowers any more is accepted below this: what is left is
// rounding, which grows with the stiffness of the contact. The certificate reports it as it is.
inline constexpr double kRoundingFloor = 1e-11;

struct SimulationOptions {
  double step = 1e-3;  // [s]
  int steps = 0;       // whole steps
  int order = 2;       // 1 or 2
  double newton_tolerance = 1e-10;
  int newton_max_iterations = 30;
  std::size_t memory = std::size_t{256} << 20;  // of a trajectory's records; beyond, they are computed again [bytes]
  std::function<void(int)> progress;            // called with the whole steps done, now and then; may be empty
};

// The rate v and acceleration that an increment xi means for the step to state k+1 of the trajectory.
void CalcRates(const BdfCoefficients& c, const Eigen::Ref<const Eigen::VectorXd>& xi,
               const Eigen::Ref<const Eigen::VectorXd>& xi_previous, const Eigen::Ref<const Eigen::VectorXd>& v_now,
               const Eigen::Ref<const Eigen::VectorXd>& v_before, Eigen::VectorXd* v, Eigen::VectorXd* vdot);

class Simulator {
 public:
  // Both must outlive the simulator.
  Simulator(Dynamics* dynamics, ContactModel* contacts);

  // From (q0, v0) at time 0. `controls` has a row for each of the tree's actuators, or no values. With a feedback law
  // (may be null) it has a column for every interval of the options' steps; the law overwrites its own rows as they
  // come, and the trajectory keeps what acted.
  Trajectory Run(const Eigen::VectorXd& q0, const Eigen::VectorXd& v0, const SimulationOptions& options,
                 const ControlSequence& controls = {}, Feedback* feedback = nullptr);

  // Called after every accepted state with the kinematics and contact reports of that state; for books and tests.
  std::function<void(double time)> observer;

 private:
  bool Advance(double time, double h, int depth, const SimulationOptions& options, Trajectory* trajectory);
  bool SolveStep(double time, const BdfCoefficients& c, const SimulationOptions& options, Trajectory* trajectory);
  // *scaled: the scaled residual at xi_trial_, before and after.
  bool FindRoot(double time, const BdfCoefficients& c, const SimulationOptions& options, Trajectory* trajectory,
                double* scaled);
  // At xi_trial_: whether no joint turns by kLongestTurn or more.
  bool IsWithinATurn() const;
  bool ComeNearWithAddedInertia(double time, const BdfCoefficients& c, Trajectory* trajectory, double* scaled);
  bool CalcNewtonStep(const BdfCoefficients& c, double added_inertia, Trajectory* trajectory);
  double CalcMerit() const;
  double Evaluate(double time, const BdfCoefficients& c, const Trajectory& trajectory);
  void NoteContacts(double time, Trajectory* trajectory);
  // Whole steps from `begin` to `end`, or until one fails: whether none did.
  bool TakeSteps(int begin, int end, const SimulationOptions& options, Feedback* feedback, Trajectory* trajectory);
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
  Bristles bristles_;  // at the start of the step
  AccelerationPredictor predictor_;
  // Scratch of one step.
  Eigen::VectorXd q_, v_, xi_, xi_trial_, vdot_, r_, magnitude_, scale_, scale_now_, dx_, start_, zero_;
};

}  // namespace knap
