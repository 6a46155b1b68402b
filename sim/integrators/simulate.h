// Implicit time stepping of a tree in contact, recorded so that an adjoint can run back over it.
//
// Each step solves r(xi) = 0 (dynamics.h) by Newton with a backtracking line search. The residual is tested before the
// first iteration, so what rests costs one evaluation. A row's residual is judged against the magnitudes of the terms
// it sums, the largest of its joint: scaled residual = max_rows |r| / magnitude. A step that does not converge is cut
// in two, by BDF1, up to kMaxSubdivisions times; what still fails ends the trajectory with converged = false.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/bdf.h"
#include "sim/integrators/control_sequence.h"
#include "sim/multibody/dynamics.h"

namespace knap {

inline constexpr int kMaxSubdivisions = 8;
// A scaled residual that no step along Newton's direction lowers any more is accepted below this: what is left is
// rounding, which grows with the stiffness of the contact. The certificate reports it as it is.
inline constexpr double kRoundingFloor = 1e-11;

struct SimulationOptions {
  double step = 1e-3;     // [s]
  int steps = 0;          // whole steps
  int order = 2;          // 1 or 2
  double newton_tolerance = 1e-10;
  int newton_max_iterations = 30;
  std::function<void(int)> progress;  // called with the whole steps done, now and then; may be empty
};

struct SimulationCertificate {
  bool converged = true;
  bool finite = true;
  double worst_residual = 0.0;  // largest accepted scaled residual
  int subdivided_steps = 0;     // whole steps that had to be cut
  int contact_onsets = 0;       // times that some contact began
  long newton_iterations = 0;
};

// States 0…K and the records that lead from each to the next; substeps are states too.
class Trajectory {
 public:
  Trajectory(int nq, int nv) : nq_(nq), nv_(nv) {}

  int size() const { return static_cast<int>(times_.size()); }
  double time(int k) const { return times_[k]; }
  Eigen::Map<const Eigen::VectorXd> q(int k) const { return {q_.data() + k * nq_, nq_}; }
  Eigen::Map<const Eigen::VectorXd> v(int k) const { return {v_.data() + k * nv_, nv_}; }
  // xi(k), vdot(k) and coefficients(k) belong to the step from k−1 to k; zero for k = 0.
  Eigen::Map<const Eigen::VectorXd> xi(int k) const { return {xi_.data() + k * nv_, nv_}; }
  Eigen::Map<const Eigen::VectorXd> vdot(int k) const { return {vdot_.data() + k * nv_, nv_}; }
  // The bristles of the contacts at state k.
  void GetBristles(int k, Bristles* out) const;
  const BdfCoefficients& coefficients(int k) const { return coefficients_[k]; }
  // The state at the end of whole step n (0: the start), n ≤ whole_steps().
  int state_of_step(int n) const { return state_of_step_[n]; }
  int whole_steps() const { return static_cast<int>(state_of_step_.size()) - 1; }
  // When each contact was last active [s]; minus infinity where it never was.
  const std::vector<double>& last_touched() const { return last_touched_; }

  SimulationCertificate certificate;
  ControlSequence controls;  // that acted

 private:
  friend class Simulator;
  void Reserve(int states);
  void Append(double time, const BdfCoefficients& c, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
              const Eigen::VectorXd& xi, const Eigen::VectorXd& vdot, const Bristles& bristles);

  int nq_;
  int nv_;
  std::vector<double> times_;
  std::vector<double> q_;
  std::vector<double> v_;
  std::vector<double> xi_;
  std::vector<double> vdot_;
  std::vector<BdfCoefficients> coefficients_;
  std::vector<int> state_of_step_;
  std::vector<double> last_touched_;
  Bristles bristles_;  // of all states, one after the other
  std::vector<int> bristle_start_{0};
};

// The rate v and acceleration that an increment xi means for the step to state k+1 of the trajectory.
void CalcRates(const BdfCoefficients& c, const Eigen::Ref<const Eigen::VectorXd>& xi,
               const Eigen::Ref<const Eigen::VectorXd>& xi_previous, const Eigen::Ref<const Eigen::VectorXd>& v_now,
               const Eigen::Ref<const Eigen::VectorXd>& v_before, Eigen::VectorXd* v, Eigen::VectorXd* vdot);

class Simulator {
 public:
  // Both must outlive the simulator.
  Simulator(Dynamics* dynamics, ContactModel* contacts);

  // From (q0, v0) at time 0. `controls` has a row for each of the tree's actuators, or no values.
  Trajectory Run(const Eigen::VectorXd& q0, const Eigen::VectorXd& v0, const SimulationOptions& options,
                 const ControlSequence& controls = {});

  // Called after every accepted state with the kinematics and contact reports of that state; for books and tests.
  std::function<void(double time)> observer;

 private:
  bool Advance(double time, double h, int depth, const SimulationOptions& options, Trajectory* trajectory);
  bool SolveStep(double time, const BdfCoefficients& c, const SimulationOptions& options, Trajectory* trajectory);
  double Evaluate(double time, const BdfCoefficients& c, const Trajectory& trajectory);
  void NoteContacts(double time, Trajectory* trajectory);

  Dynamics* dynamics_;
  ContactModel* contacts_;
  std::vector<bool> was_active_;
  std::vector<int> joint_of_row_;
  Bristles bristles_;  // at the start of the step
  // Scratch of one step.
  Eigen::VectorXd q_, v_, xi_, xi_trial_, vdot_, r_, magnitude_, scale_, scale_now_, dx_, zero_;
};

}  // namespace knap
