// What the force law of one patch must satisfy whatever its formula, on random patches and motions.
#include "sim/contact/contact_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sim/contact/elastic_point.h"
#include "sim/math/so3.h"

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.01;

struct SphereForce {
  Vector3d f;  // at the contact
  Vector3d m;  // about the sphere's centre
  Eigen::Matrix<double, 6, 10> jacobian = Eigen::Matrix<double, 6, 10>::Zero();
};

// A sphere pressed against a surface: what its integrals W and g and its motion make of the law.
struct Patch {
  ContactMaterial material;
  double W;
  Vector3d g;
  Vector3d u;
  Vector3d w;

  SphereForce Calc(bool want_jacobian = false) const {
    MeshIntegrals integrals;
    integrals.W = W;
    integrals.g = g;
    ElasticPoint e;
    IntegralJacobian d;
    CalcSphereOnMesh(integrals, material.stiffness, kRadius, &e, &d);
    PointForceJacobian j;
    const Vector3d at_point = u + w.cross(e.l);
    const PointForce force =
        CalcPointForce(material, e.N, e.N_light, e.n, at_point, Vector3d::Zero(), 0.0, want_jacobian ? &j : nullptr);
    const RollingMoment rolling = CalcRollingMoment(material, kRadius, force.N, e.n, w);
    SphereForce out{force.f, e.l.cross(force.f) + rolling.m};
    if (!want_jacobian) return out;
    // Columns: 0 W, 1–3 g, 4–6 u, 7–9 w.
    using Matrix3x10 = Eigen::Matrix<double, 3, 10>;
    using Row10 = Eigen::Matrix<double, 1, 10>;
    Row10 dNe = Row10::Zero();
    dNe(0) = d.dN_dW;
    dNe.segment<3>(1) = d.dN_dg.transpose();
    Matrix3x10 dn = Matrix3x10::Zero();
    dn.middleCols<3>(1) = d.dn_dg;
    Matrix3x10 dl = Matrix3x10::Zero();
    dl.col(0) = d.dl_dW;
    dl.middleCols<3>(1) = d.dl_dg;
    Matrix3x10 du = Skew(w) * dl;
    du.middleCols<3>(4) += Eigen::Matrix3d::Identity();
    du.middleCols<3>(7) -= Skew(e.l);
    const Row10 dN = j.dN_dNe * dNe + j.dN_dn.transpose() * dn + j.dN_du.transpose() * du;
    const Matrix3x10 df = j.df_dNe * dNe + j.df_dn * dn + j.df_du * du;
    Matrix3x10 dm = Skew(e.l) * df - Skew(force.f) * dl + rolling.dm_dN * dN + rolling.dm_dn * dn;
    dm.rightCols<3>() += rolling.dm_dw;
    out.jacobian << df, dm;
    return out;
  }
  Vector3d normal() const { return g.normalized(); }
  Vector3d lever() const { return -g / W; }
  Vector3d Slip() const {
    const Vector3d at_point = u + w.cross(lever());
    return at_point - normal() * normal().dot(at_point);
  }
  // The force without friction, rolling resistance and tangential motion.
  double NormalForce() const {
    Patch bare = *this;
    bare.material.friction = 0.0;
    bare.material.rolling_resistance = 0.0;
    return bare.Calc().f.norm();
  }
};

class RandomPatches {
 public:
  Patch Make() {
    Patch p;
    p.material = {1e8 * (1.5 + U()), 1.0 + U(), 0.5 + 0.5 * U(), 0.05 + 0.05 * U(), 1e-3 * (1.5 + U())};
    // A disc of about 1.3 mm, pressed 80 µm deep: W = π a⁴/2, a distance of the centre of pressure just under r.
    p.W = 4e-12 * std::exp(U());
    p.g = p.W * kRadius * (0.98 + 0.015 * U()) * Vector3d(U(), U(), U()).normalized();
    p.u = std::pow(10.0, -3.0 + 3.0 * U()) * Vector3d(U(), U(), U());
    p.w = std::pow(10.0, -1.0 + 3.0 * U()) * Vector3d(U(), U(), U());
    return p;
  }
  double U() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }

 private:
  std::mt19937_64 generator_{11};
};

TEST(ContactLaw, FrictionStaysInTheConeOfTheNormalForceAndOpposesSlip) {
  RandomPatches patches;
  int active = 0;
  double fullest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Patch p = patches.Make();
    const SphereForce force = p.Calc();
    const double N = p.NormalForce();
    active += N > 0.0;
    const Vector3d f_t = force.f - p.normal() * p.normal().dot(force.f);
    EXPECT_NEAR(p.normal().dot(force.f), N, 1e-12 * N);
    EXPECT_LE(f_t.norm(), p.material.friction * N * (1.0 + 1e-12));
    if (N > 0.0) fullest = std::max(fullest, f_t.norm() / (p.material.friction * N));
    const Vector3d slip = p.Slip();
    EXPECT_LE(f_t.dot(slip), 0.0);
    EXPECT_LE(f_t.cross(slip).norm(), 1e-9 * f_t.norm() * slip.norm() + 1e-24);
    const Vector3d m_r = force.m - p.lever().cross(f_t);
    EXPECT_LE(m_r.norm(), p.material.rolling_resistance * kRadius * N * (1.0 + 1e-9) + 1e-14 * force.f.norm());
    EXPECT_NEAR(m_r.dot(p.normal()), 0.0, 1e-14 * force.f.norm());
    EXPECT_LE(m_r.dot(p.w), 1e-14 * force.f.norm() * p.w.norm());
    if (testing::Test::HasFailure()) FAIL() << "at patch " << i;
  }
  EXPECT_GT(active, 15000);
  EXPECT_GT(fullest, 0.9999);  // and the bound is reached
}

TEST(ContactLaw, NeverPullsAtAnySpeedOfSeparation) {
  RandomPatches patches;
  for (int i = 0; i < 2000; ++i) {
    Patch p = patches.Make();
    double previous = 1.0 / 0.0;
    for (double speed = -10.0; speed < 1e4; speed = speed < 10.0 ? speed + 0.05 : 2.0 * speed) {
      p.u = speed * p.normal();
      const double normal = p.normal().dot(p.Calc().f);
      EXPECT_GE(normal, 0.0);
      EXPECT_LE(normal, previous);  // damping: the faster apart, the weaker
      previous = normal;
    }
    EXPECT_EQ(previous, 0.0);
    if (testing::Test::HasFailure()) FAIL() << "at patch " << i;
  }
}

TEST(ContactLaw, FrictionIsHalfwayInSquareAtTheSlipSpeedAndFullFarAbove) {
  Patch p = RandomPatches().Make();
  p.w.setZero();
  const double bound = p.material.friction * p.NormalForce();
  const Vector3d direction = p.normal().unitOrthogonal();
  const auto friction = [&](double speed) {
    p.u = speed * direction;
    return p.Calc().f.dot(-direction);
  };
  // The normal force has no part in these motions, so its value at rest is the one that counts.
  p.u.setZero();
  const double at_rest = p.material.friction * p.NormalForce();
  EXPECT_GT(bound, 0.0);
  EXPECT_NEAR(friction(p.material.slip_speed), at_rest / std::sqrt(2.0), 1e-12 * at_rest);
  EXPECT_NEAR(friction(1e3 * p.material.slip_speed), at_rest, 1e-6 * at_rest);
}

TEST(ContactLaw, JacobianEqualsDifferences) {
  RandomPatches patches;
  for (int i = 0; i < 500; ++i) {
    Patch p = patches.Make();
    // Speeds about the slip speed, where the law bends most; the ramp's start, of jumping third derivative, is beyond.
    p.u = 3.0 * p.material.slip_speed * Vector3d(patches.U(), patches.U(), patches.U());
    p.w = 300.0 * p.material.slip_speed * Vector3d(patches.U(), patches.U(), patches.U());
    const SphereForce at = p.Calc(true);
    const double scales[] = {p.W, p.g.norm(), p.material.slip_speed, p.material.slip_speed / kRadius};
    const double force = at.f.norm();
    for (int column = 0; column < 10; ++column) {
      const double scale = scales[(column + 2) / 3];
      const double step = 1e-5 * scale;
      const auto moved = [&](double s) {
        Patch q = p;
        if (column == 0) q.W += s;
        if (column >= 1 && column < 4) q.g(column - 1) += s;
        if (column >= 4 && column < 7) q.u(column - 4) += s;
        if (column >= 7) q.w(column - 7) += s;
        const SphereForce f = q.Calc();
        Eigen::Matrix<double, 6, 1> wrench;
        wrench << f.f, f.m / kRadius;
        return wrench;
      };
      Eigen::Matrix<double, 6, 1> actual = at.jacobian.col(column) * scale;
      actual.tail<3>() /= kRadius;
      const Eigen::Matrix<double, 6, 1> expected = (moved(step) - moved(-step)) * (scale / (2.0 * step));
      // Truncation (1e-5)² and rounding 1e-16/1e-5, both times third derivatives of order 10.
      EXPECT_LT((actual - expected).norm(), 1e-8 * force) << "column " << column;
    }
    if (testing::Test::HasFailure()) FAIL() << "at patch " << i;
  }
}

TEST(ContactLaw, JacobianIsLeftOutUnlessWanted) {
  const Patch p = RandomPatches().Make();
  EXPECT_EQ(p.Calc(false).jacobian.norm(), 0.0);
  EXPECT_GT(p.Calc(true).jacobian.norm(), 0.0);
  EXPECT_EQ(p.Calc(false).f, p.Calc(true).f);
}

}  // namespace
}  // namespace knap
