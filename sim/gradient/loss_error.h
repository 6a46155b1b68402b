// What the time steps do to the loss: the dual-weighted residual of a curve through a trajectory's states.
//
// Between two nodes of TR-BDF2, h apart, let q~, v~, z~ be the cubic Hermite curves through positions, rates and
// bristles with their slopes. At the nodes they meet the equations of motion, between them not quite; the residual is
// about that of a parabola, whose integral is 2h/3 times its middle. What it is worth there the adjoint knows:
//
//   J_exact − J ≈ Σ_steps (2h/3) (lambda_q·(v~ − q~') − mu·r(q~, v~, v~') + lambda_z·(z'(z~, motion) − z~'))
//
// lambda_q and lambda_z are the means of the cotangents at both nodes, mu that of the multipliers of the solves into
// them, each over the time that it stands for: a force's slope at a node is used by the step that ends there, with the
// share d of its length, and by the next, with the share w. What the next step sees of the node's position through that
// slope belongs to lambda_q. One evaluation of the forces a step, three where a contact begins or ends within it, and
// the residual has a kink: at the quarters, by Simpson's rule.                                   [Cao & Petzold 2004]
//
// Formulas of fixed steps have no such curve: there is no estimate for them.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/gradient/solve_pull_back.h"
#include "sim/integrators/trajectory.h"
#include "sim/multibody/dynamics.h"

namespace knap {

class LossErrorSum {
 public:
  LossErrorSum(const Trajectory& trajectory, Dynamics* dynamics, ContactModel* contacts);

  // For every state from the last to the first, with its whole cotangents, before the solve into it is pulled back …
  void Look(int k, const StateBars& bars);
  // … and afterwards with that solve's multiplier and lambda·∂r/∂pose. The dynamics are then at another state.
  void AddSolve(int k, const Eigen::VectorXd& lambda, const Eigen::VectorXd& by_pose);

  double sum() const { return sum_; }

 private:
  struct Node {
    int state = -1;
    Eigen::VectorXd bar_pose, mu;
    BristleState bristles;
    std::vector<Bristle> bar_bristles;
    std::vector<bool> active;  // of each contact
  };
  // The integral over the step between the nodes.
  double CalcStep(const Node& start, const Node& end);
  // The residual's worth at a share s of the step.
  double CalcAt(double s, const Node& start, const Node& end);
  // Bristles between the nodes, and the cotangents' mean.
  void CalcBristles(double s, const Node& start, const Node& end, double h);

  const Trajectory& trajectory_;
  Dynamics* dynamics_;
  ContactModel* contacts_;
  Node now_, after_;
  Bristles middle_;
  std::vector<Bristle> middle_rate_, bar_middle_;
  double sum_ = 0.0;
};

}  // namespace knap
