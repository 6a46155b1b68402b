// The tree's residual, its O(n) solves and its pull-back, each against differences and a dense factorisation, on random
// trees with every kind of joint.
#include "sim/multibody/dynamics.h"

#include <gtest/gtest.h>

#include "sim/math/so3.h"
#include "tests/sim/dynamics/random_tree.h"

namespace knap {
namespace dynamics_test {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::RandomTree;

constexpr double kCv = 3.0;
constexpr double kCa = 7.0;

// The residual as a function of free pose increment, rates and accelerations, evaluated afresh.
struct Point {
  VectorXd pose;
  VectorXd v;
  VectorXd vdot;
};

VectorXd EvalResidual(const RandomTree& test, Dynamics* dynamics, const Point& at) {
  dynamics->controls() = test.controls;
  VectorXd q(test.tree.nq());
  test.tree.AddIncrement(test.q, at.pose, &q);
  dynamics->CalcKinematics(q, at.v, at.vdot, 0.7);
  for (int i = 0; i < test.tree.size(); ++i) {
    dynamics->external()[i].F = test.external_slope[i] * dynamics->kinematics()[i].V;
    dynamics->external()[i].dF_dV = test.external_slope[i];
  }
  for (const RandomTree::Coupling& c : test.couplings) {
    const BodyKinematics& other = dynamics->kinematics()[c.other];
    dynamics->external()[c.body].F +=
        c.by_position * other.X_WB.p + c.by_turn * (other.X_WB.R * c.marker) + c.by_twist * other.V;
    CrossWrench cross{c.body, c.other, Matrix6d::Zero(), c.by_twist};
    cross.dF_deta.leftCols<3>() = -c.by_turn * other.X_WB.R * Skew(c.marker);
    cross.dF_deta.rightCols<3>() = c.by_position * other.X_WB.R;
    dynamics->cross().push_back(cross);
  }
  VectorXd r(test.tree.nv());
  VectorXd magnitude(test.tree.nv());
  dynamics->CalcResidual(0.0, &r, &magnitude);
  EXPECT_TRUE((r.cwiseAbs().array() <= magnitude.array() + 1e-12).all());
  return r;
}

Point PointAt(const RandomTree& test, const VectorXd& xi) {
  return {xi, kCv * (xi - test.xi_prev), kCa * (xi + test.xi_prev)};
}

class DynamicsTest : public testing::TestWithParam<int> {};

TEST_P(DynamicsTest, SolvesEqualTheDenseFactorisationOfDifferences) {
  RandomTree test(GetParam());
  test.Couple(GetParam() % 5);  // every fifth tree has none
  Dynamics dynamics(test.tree);
  const int nv = test.tree.nv();
  MatrixXd J(nv, nv);
  const double step = 1e-5;
  for (int k = 0; k < nv; ++k) {
    const VectorXd d = step * VectorXd::Unit(nv, k);
    J.col(k) = (EvalResidual(test, &dynamics, PointAt(test, test.xi + d)) -
                EvalResidual(test, &dynamics, PointAt(test, test.xi - d))) /
               (2.0 * step);
  }
  EvalResidual(test, &dynamics, PointAt(test, test.xi));
  ASSERT_TRUE(dynamics.Factor(test.xi, kCv, kCa));
  const VectorXd rhs = VectorXd::NullaryExpr(nv, [&] { return test.U(); });
  VectorXd x(nv);
  dynamics.Solve(rhs, &x);
  // Differences of a residual of order 1e2 with this step leave 1e-7.
  EXPECT_LT((J * x - rhs).norm(), 1e-6 * (1.0 + J.norm() * x.norm()));
  VectorXd y(nv);
  dynamics.SolveTransposed(rhs, &y);
  EXPECT_LT((J.transpose() * y - rhs).norm(), 1e-6 * (1.0 + J.norm() * y.norm()));
  // The two solves are each other's transposes to rounding.
  const VectorXd other = VectorXd::NullaryExpr(nv, [&] { return test.U(); });
  VectorXd z(nv);
  dynamics.Solve(other, &z);
  EXPECT_NEAR(y.dot(other), rhs.dot(z), 1e-11 * (1.0 + y.norm() * other.norm()));
}

TEST_P(DynamicsTest, PullBackEqualsDifferences) {
  RandomTree test(100 + GetParam());
  test.Couple(GetParam() % 5);
  Dynamics dynamics(test.tree);
  const int nv = test.tree.nv();
  const Point at = PointAt(test, test.xi);
  const VectorXd lambda = VectorXd::NullaryExpr(nv, [&] { return test.U(); });
  EvalResidual(test, &dynamics, at);
  JointCotangents bars{VectorXd(nv), VectorXd(nv), VectorXd(nv)};
  dynamics.PullBackResidual(lambda, &bars, nullptr);
  const double step = 1e-5;
  const auto difference = [&](const Point& plus, const Point& minus) {
    return (lambda.dot(EvalResidual(test, &dynamics, plus)) - lambda.dot(EvalResidual(test, &dynamics, minus))) /
           (2.0 * step);
  };
  // A pose increment d on top of xi: (q ⊕ xi) ⊕ d.
  RandomTree moved = test;
  VectorXd q_now(test.tree.nq());
  test.tree.AddIncrement(test.q, test.xi, &q_now);
  moved.q = q_now;
  for (int k = 0; k < nv; ++k) {
    const VectorXd d = step * VectorXd::Unit(nv, k);
    const double pose = (lambda.dot(EvalResidual(moved, &dynamics, {d, at.v, at.vdot})) -
                         lambda.dot(EvalResidual(moved, &dynamics, {-d, at.v, at.vdot}))) /
                        (2.0 * step);
    EXPECT_NEAR(bars.pose(k), pose, 1e-6 * (1.0 + std::abs(pose)));
    const double v = difference({at.pose, at.v + d, at.vdot}, {at.pose, at.v - d, at.vdot});
    EXPECT_NEAR(bars.v(k), v, 1e-6 * (1.0 + std::abs(v)));
    const double vdot = difference({at.pose, at.v, at.vdot + d}, {at.pose, at.v, at.vdot - d});
    EXPECT_NEAR(bars.vdot(k), vdot, 1e-6 * (1.0 + std::abs(vdot)));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, DynamicsTest, testing::Range(0, 40));

}  // namespace dynamics_test
}  // namespace knap
