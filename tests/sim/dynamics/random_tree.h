// Random forests with every kind of joint, joint law and actuator, a state, and couplings between bodies.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <random>
#include <vector>

#include "sim/multibody/dynamics.h"
#include "sim/multibody/tree.h"

namespace knap::test {

class RandomTree {
 public:
  explicit RandomTree(std::uint64_t seed);

  // `count` wrenches between any two bodies, those without freedom and one body with itself included.
  void Couple(int count);

  double U() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }
  int Pick(int n) { return static_cast<int>(generator_() % static_cast<std::uint64_t>(n)); }
  Eigen::Vector3d Vec() {
    const double x = U();
    const double y = U();
    return Eigen::Vector3d(x, y, U());
  }
  Eigen::VectorXd Values(int n, double scale) {
    return scale * Eigen::VectorXd::NullaryExpr(n, [this] { return U(); });
  }

  // The tree anew from changed bodies.
  static Tree Rebuild(const std::vector<TreeBody>& bodies, const std::vector<Actuator>& actuators,
                      const Eigen::Vector3d& gravity);

  Tree tree;
  Eigen::VectorXd q;  // at the step's start
  Eigen::VectorXd xi_prev;
  Eigen::VectorXd xi;
  Eigen::VectorXd controls;
  // F_body += by_position p_WO + by_turn R_WO marker + by_twist V_O, with O the other body.
  struct Coupling {
    int body = 0;
    int other = 0;
    Eigen::Matrix<double, 6, 3> by_position;
    Eigen::Matrix<double, 6, 3> by_turn;
    Matrix6d by_twist;
    Eigen::Vector3d marker;
  };
  std::vector<Coupling> couplings;
  std::vector<Matrix6d> external_slope;  // an outside wrench linear in the twist, so that dF_dV is exercised

 private:
  TreeBody MakeBody(int i);

  std::mt19937_64 generator_;
};

}  // namespace knap::test
