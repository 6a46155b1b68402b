// The tree's residual, its O(n) solves and its pull-back, each against differences and a dense factorisation, on random
// trees with every kind of joint.
#include "sim/multibody/dynamics.h"

#include <gtest/gtest.h>

#include <random>

namespace knap {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class RandomTree {
 public:
  explicit RandomTree(std::uint64_t seed) : generator_(seed) {
    const int count = 3 + static_cast<int>(generator_() % 5);
    for (int i = 0; i < count; ++i) {
      TreeBody body;
      body.parent = i == 0 ? -1 : static_cast<int>(generator_() % (i + 1)) - 1;
      const JointType kinds[] = {JointType::kRevolute, JointType::kPrismatic,  JointType::kTranslation,
                                 JointType::kBall,     JointType::kPrescribed, JointType::kFixed};
      body.joint = kinds[generator_() % 6];
      if (i == 0) body.joint = JointType::kBall;
      body.X_PF = {ExpSo3(Vec()).toRotationMatrix(), Vec()};
      body.axis = Vec().normalized();
      body.law.damping = 0.3 * (1.0 + U());
      body.motion = [](double t) {
        PrescribedState s;
        s.X_FB.p = Vector3d(std::sin(t), t * t, 0.0);
        s.V.tail<3>() = Vector3d(std::cos(t), 2.0 * t, 0.0);
        s.A.tail<3>() = Vector3d(-std::sin(t), 2.0, 0.0);
        return s;
      };
      const Eigen::Matrix3d a = Eigen::Matrix3d::Random();
      body.M = MakeSpatialInertia(1.0 + 0.5 * U(), 0.3 * Vec(), a * a.transpose() + Eigen::Matrix3d::Identity());
      tree.AddBody(body);
    }
    tree.gravity = Vec() * 9.0;
    q = tree.MakeDefaultPositions();
    VectorXd shift(tree.nv());
    for (int k = 0; k < tree.nv(); ++k) shift(k) = U();
    const VectorXd start = q;
    tree.AddIncrement(start, shift, &q);
    xi_prev = 0.3 * VectorXd::NullaryExpr(tree.nv(), [&] { return U(); });
    xi = 0.5 * VectorXd::NullaryExpr(tree.nv(), [&] { return U(); });
    external_slope.resize(tree.size());
    for (auto& m : external_slope) m = Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return U(); });
  }
  // `count` wrenches between any two bodies, those without freedom and one body with itself included.
  void Couple(int count) {
    for (int i = 0; i < count; ++i) {
      Coupling c;
      c.body = static_cast<int>(generator_() % tree.size());
      c.other = static_cast<int>(generator_() % tree.size());
      c.by_position = Eigen::Matrix<double, 6, 3>::NullaryExpr([&] { return 30.0 * U(); });
      c.by_turn = Eigen::Matrix<double, 6, 3>::NullaryExpr([&] { return 30.0 * U(); });
      c.by_twist = Matrix6d::NullaryExpr([&] { return 3.0 * U(); });
      c.marker = Vec();
      couplings.push_back(c);
    }
  }
  double U() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }
  Vector3d Vec() { return Vector3d(U(), U(), U()); }

  Tree tree;
  VectorXd q;  // at the step's start
  VectorXd xi_prev;
  VectorXd xi;
  // F_body += by_position p_WO + by_turn R_WO marker + by_twist V_O, with O the other body.
  struct Coupling {
    int body = 0;
    int other = 0;
    Eigen::Matrix<double, 6, 3> by_position;
    Eigen::Matrix<double, 6, 3> by_turn;
    Matrix6d by_twist;
    Vector3d marker;
  };
  std::vector<Coupling> couplings;
  std::vector<Matrix6d> external_slope;  // an outside wrench linear in the twist, so that dF_dV is exercised

 private:
  std::mt19937_64 generator_;
};

constexpr double kCv = 3.0;
constexpr double kCa = 7.0;

// The residual as a function of free pose increment, rates and accelerations, evaluated afresh.
struct Point {
  VectorXd pose;
  VectorXd v;
  VectorXd vdot;
};

VectorXd EvalResidual(const RandomTree& test, Dynamics* dynamics, const Point& at) {
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

}  // namespace
}  // namespace knap
