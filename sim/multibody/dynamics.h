// Inverse dynamics residual of a tree, its exact linearisation, and both solved in O(bodies).
//
// With T_i the twist, A_i its componentwise rate (gravity enters as the acceleration of the world), body i needs the
// wrench f_i = M A_i + crf(V_i) M V_i − f_ext, its subtree F_i = f_i + Σ_children Xᵀ F_c, and the joint equations are
//
//   r_i = S_iᵀ F_i − tau_i = 0                                                               (nv equations)
//
// with tau the joint's own forces (joint_forces.h).
//
// A perturbation of body i is z = (eta, dV, w): eta the twist of its pose error, dV and dA the changes of its twist and
// acceleration as components in B, w = dA + crm(V_i) dV. With all of these seen from one frame R for the whole tree
// (axes of the world, at the root's origin) the parent's perturbation is carried along as it is, and
//
//   z_i = z_p + U dxi                                                                        U 18×n
//
// because implicit integration makes the joint's d = Jr dxi, dv = c_v dxi and dvdot = c_a dxi multiples of one unknown.
// The subtree's wrench is linear in it, dF_i = P_i z_i + b_i with P_i 6×18, so eliminating the joints from the tips to
// the root solves the Newton system exactly, as the articulated-body algorithm does for forces [Featherstone 2008,
// ch. 7]; the transpose of both passes solves the adjoint. A wrench on body b enters P through its derivatives in b's
// own perturbation. Where it also hangs on another body o, dF_b = D z_o, the matrix is the tree's less a term of rank 6
// for each such b:
//
//   J = J_tree − U V,   U = [Φ_bᵀ],   V = [Σ_o D z_o]          Φ_b: joint rates to the twist of b
//   J⁻¹ rhs = J_tree⁻¹ (rhs + U s),   (1 − V J_tree⁻¹ U) s = V J_tree⁻¹ rhs     [Golub & Van Loan 2013, §2.1.4]
//
// so that six more passes over the tree for each b that hangs on others, and two a solve, keep everything exact.
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "sim/math/dense_lu.h"
#include "sim/multibody/tree.h"

namespace knap {

struct BodyKinematics {
  Pose X_FB;
  Pose X_PB;
  Pose X_WB;
  Vector6d V_joint = Vector6d::Zero();    // twist of B in F [B]
  Vector6d V_carried = Vector6d::Zero();  // X V_p
  Vector6d A_carried = Vector6d::Zero();  // X A_p
  Vector6d V = Vector6d::Zero();          // V_WB_B
  Vector6d A = Vector6d::Zero();          // rate of V's components, less gravity
};

// The wrench on one body from outside, about Bo in B, and its derivatives in the body's own perturbation.
struct ExternalWrench {
  Vector6d F = Vector6d::Zero();
  double moment_scale = 0.0;  // sum of force × lever over the forces that F's moment sums [N m]
  Matrix6d dF_deta = Matrix6d::Zero();
  Matrix6d dF_dV = Matrix6d::Zero();
};

// How the wrench on `body` (about its Bo, in its B) moves with the perturbation of `other`, which lies anywhere in the
// forest. Only dynamic bodies have equations, so nothing comes of a `body` that is not; an `other` that is not dynamic
// adds nothing to the matrix.
struct CrossWrench {
  int body = 0;
  int other = 0;
  Matrix6d dF_deta = Matrix6d::Zero();
  Matrix6d dF_dV = Matrix6d::Zero();
};

// Joint cotangents: of the pose increment d, the rates v and their derivatives, each of length nv.
struct JointCotangents {
  Eigen::VectorXd pose;
  Eigen::VectorXd v;
  Eigen::VectorXd vdot;
};

// Cotangents of one body's perturbation (eta, dV, dA).
struct BodyCotangent {
  Vector6d eta = Vector6d::Zero();
  Vector6d V = Vector6d::Zero();
  Vector6d A = Vector6d::Zero();
};

// Cotangents of one body's parameters.
struct BodyParameterCotangent {
  Vector6d placement = Vector6d::Zero();           // of X_PF: of the twist of its error, in F
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // within the plane normal to it; revolute and prismatic
  double mass = 0.0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();  // of m p_BoBcm_B
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();       // of I_BBo_B: symmetric, pairs as Σ inertia(i,j) dI(i,j)
  JointLawCotangent law;
};

// Cotangents of all that a tree is made of, and of the controls.
struct ParameterCotangents {
  explicit ParameterCotangents(const Tree& tree)
      : bodies(tree.size()), controls(Eigen::VectorXd::Zero(tree.num_controls())) {}
  std::vector<BodyParameterCotangent> bodies;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double time = 0.0;  // through prescribed motions
  Eigen::VectorXd controls;
};

class Dynamics {
 public:
  explicit Dynamics(const Tree& tree);

  const Tree& tree() const { return *tree_; }

  // One value an actuator, to be set before CalcKinematics; zero at first.
  Eigen::VectorXd& controls() { return controls_; }

  // Poses, twists and accelerations of all bodies at one time, and the joints' own forces. No allocation.
  void CalcKinematics(const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Eigen::VectorXd& vdot, double time);
  const std::vector<BodyKinematics>& kinematics() const { return kinematics_; }
  double time() const { return prescribed_time_; }  // of these kinematics [s]

  // To be filled by the caller after CalcKinematics; one for each body.
  std::vector<ExternalWrench>& external() { return external_; }
  // Likewise; emptied by CalcKinematics. Several entries of one pair add up.
  std::vector<CrossWrench>& cross() { return cross_; }

  // r, and for each row the sum of the magnitudes of its terms, against which the residual is judged. Accelerations are
  // differences of rates over a step, so rounding leaves in them a part of `rate` [1/s] times the momentum: it counts
  // as a term too.
  void CalcResidual(double rate, Eigen::VectorXd* r, Eigen::VectorXd* magnitude);

  // Linearises at the current kinematics and external wrenches. xi is the pose increment over the step, c_v = dv/dxi,
  // c_a = dvdot/dxi [1/s, 1/s²]. Needs CalcResidual before. False when a pivot is singular or not finite. Allocates
  // only when there are more coupled bodies than ever before.
  bool Factor(const Eigen::VectorXd& xi, double c_v, double c_a);

  // J x = rhs, with J = dr/dxi of the last Factor.
  void Solve(const Eigen::VectorXd& rhs, Eigen::VectorXd* x);
  // Jᵀ x = rhs.
  void SolveTransposed(const Eigen::VectorXd& rhs, Eigen::VectorXd* x);

  // Cotangents of lambdaᵀ r in the joint quantities, and added to *parameters (may be null) those in all parameters.
  // Leaves in virtual_twists() the twist W_i that lambda gives body i, so that −W_i is the cotangent of the external
  // wrench on it. Needs CalcResidual before.
  void PullBackResidual(const Eigen::VectorXd& lambda, JointCotangents* out, ParameterCotangents* parameters);
  const std::vector<Vector6d>& virtual_twists() const { return W_; }

  // Joint cotangents of given body cotangents, and added to *parameters (may be null) those in placements, axes and
  // gravity; bodies is overwritten.
  void PullBackKinematics(std::vector<BodyCotangent>* bodies, JointCotangents* out,
                          ParameterCotangents* parameters) const;

 private:
  using Matrix18x6 = Eigen::Matrix<double, 18, 6>;
  using Matrix18x3 = Eigen::Matrix<double, 18, 3>;
  using Matrix6x3 = Eigen::Matrix<double, 6, 3>;
  using Vector18d = Eigen::Matrix<double, 18, 1>;

  // Of one body, in R. P and N lie on their sides, so that the loops over a perturbation's 18 numbers run through
  // neighbours in memory.
  struct Articulated {
    Pose X_RB;
    Matrix6x3 S;
    Matrix18x6 Pt;  // Pᵀ
    Matrix18x3 U;
    Matrix6x3 G;                // P U + the turning of the subtree's own wrench with the joint
    Eigen::Matrix3d M_inverse;  // zero beyond the joint's freedoms
    Matrix18x3 Nt;              // (M⁻¹ Sᵀ P)ᵀ
  };

  template <int n>
  bool FactorJoint(int i, const Eigen::VectorXd& xi, double c_v, double c_a);
  bool FactorCoupling();
  void CalcCoupling();
  // The tree's own solves, in R. SolveTree takes the constant wrenches in b_ and leaves the perturbations in z_; the
  // transposed one takes cotangents of z in z_ and leaves minus the virtual twists in b_. Both overwrite both.
  void SolveTree(const Eigen::VectorXd& rhs, Eigen::VectorXd* x);
  void SolveTreeTransposed(const Eigen::VectorXd& rhs, Eigen::VectorXd* x);
  void StartArticulated(int i);

  void CalcJointForces();
  // Both pull-backs; `lambda` null for one of kinematics alone.
  void PullBackTree(const Eigen::VectorXd* lambda, std::vector<BodyCotangent>* bodies, JointCotangents* out,
                    ParameterCotangents* parameters) const;
  void PullBackJointForces(const Eigen::VectorXd& lambda, JointCotangents* out, ParameterCotangents* parameters) const;
  void PullBackInertia(int i, BodyParameterCotangent* out) const;

  const Tree* tree_;
  Eigen::VectorXd controls_;
  Eigen::VectorXd q_, v_, vdot_;  // as given to CalcKinematics
  std::vector<JointForce> joint_forces_;
  Eigen::VectorXd by_control_;  // dtau/du of each actuator
  std::vector<bool> dynamic_;
  std::vector<int> dof_;
  std::vector<int> root_;  // of a dynamic body: the first dynamic body on its path from the world
  std::vector<Eigen::Matrix<double, 6, 3>> S_;
  std::vector<PrescribedState> prescribed_;  // of prescribed joints, at prescribed_time_
  double prescribed_time_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<BodyKinematics> kinematics_;
  std::vector<ExternalWrench> external_;
  std::vector<Vector6d> F_;
  std::vector<Vector6d> F_magnitude_;
  std::vector<Articulated> articulated_;
  std::vector<Vector6d> b_;
  std::vector<Vector18d> z_;
  std::vector<Vector6d> W_;
  std::vector<BodyCotangent> bars_;
  std::vector<CrossWrench> cross_;
  std::vector<int> slot_;             // of a body: which six rows of the coupling are its own, −1 none
  std::vector<int> coupled_;          // the bodies with a slot, in the order of their indices
  DenseLu coupling_;                  // 1 − V J_tree⁻¹ U, 6 rows a slot
  Eigen::VectorXd zero_;              // nv
  Eigen::VectorXd coupling_x_;        // scratch, nv
  std::vector<Vector6d> coupling_s_;  // a slot's part of s, and of its transposed twin
};

}  // namespace knap
