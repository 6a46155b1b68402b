// One patch's law: the cone, a disc's torsion, no adhesion, dissipation, and its cotangents against differences.
#include "sim/contact/patch_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/sim/contact/patch_differences.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const ContactMaterial kBristle{1e8, 3.0, 0.5, 0.05, 1e-3, 1e-4};
const ContactMaterial kSlip{1e8, 3.0, 0.5, 0.05, 1e-2, 0.0};

// A disc of radius R pressed evenly with N about c.
PatchIntegrals MakeDisc(double N, double R, const Vector3d& n, const Vector3d& c) {
  PatchIntegrals patch;
  patch.W = N / 1e8;
  patch.F = N * n;
  patch.M = c.cross(patch.F);
  patch.m1 = patch.W * c;
  const Matrix3d in_plane = Matrix3d::Identity() - n * n.transpose();
  patch.m2 = patch.W * (c * c.transpose() + 0.25 * R * R * in_plane);
  return patch;
}

TEST(PatchLawTest, TorsionOfADiscIsTwoThirds) {
  const double R = 0.02;
  const PatchIntegrals disc = MakeDisc(3.0, R, Vector3d::UnitZ(), Vector3d::Zero());
  PatchLawInput in;
  in.material = &kBristle;
  in.h = 1e-3;
  in.nu << 0.0, 0.0, 5.0, 0.0, 0.0, 0.0;
  PatchLaw law;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(law.Evaluate(disc, in));
    in.bristle = law.bristle();
  }
  EXPECT_NEAR(law.wrench()(2), -2.0 / 3.0 * 0.5 * 3.0 * R, 1e-3 * 0.5 * 3.0 * R);
}

TEST(PatchLawTest, NeverPullsAndStaysInItsCone) {
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector3d n = Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
    const PatchIntegrals disc = MakeDisc(2.0, 0.01, n, Vector3d(0.01, 0.02, -0.03));
    PatchLawInput in;
    in.material = trial % 2 == 0 ? &kBristle : &kSlip;
    in.h = 1e-3;
    for (int i = 0; i < 6; ++i) in.nu(i) = normal(generator);
    PatchLaw law;
    ASSERT_TRUE(law.Evaluate(disc, in));
    const Vector3d f = law.wrench().tail<3>();
    const double N = n.dot(f);
    EXPECT_GE(N, 0.0);
    EXPECT_LE((f - N * n).norm(), 0.5 * N * (1.0 + 1e-12));
    // What the law takes away from the elastic power is never negative.
    Vector6d elastic;
    elastic << disc.M, disc.F;
    EXPECT_LE((law.wrench() - elastic).dot(in.nu), in.bristle.isZero(0.0) ? 1e-12 : 1e-3);
  }
}

TEST(PatchLawTest, Cotangents) {
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 60; ++trial) {
    const Vector3d n = Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
    PatchIntegrals patch = MakeDisc(2.0, 0.01, n, 0.02 * Vector3d(normal(generator), normal(generator), 0.5));
    patch.m2 += 1e-5 * patch.W * Vector3d(1.0, 2.0, 3.0).asDiagonal().toDenseMatrix();
    PatchLawInput in;
    in.material = trial % 2 == 0 ? &kBristle : &kSlip;
    in.h = 1e-3;
    in.rolling_radius = 0.01;
    in.N_light = trial % 3 == 0 ? 4.0 : 1e-6;
    const double speed = trial % 5 == 0 ? 0.3 : 0.03;
    for (int i = 0; i < 6; ++i) in.nu(i) = speed * (i < 3 ? 30.0 : 1.0) * normal(generator);
    for (int i = 0; i < 4; ++i) in.bristle(i) = 4e-5 * normal(generator);
    Vector6d bar;
    Bristle bar_bristle;
    for (int i = 0; i < 6; ++i) bar(i) = (i < 3 ? 50.0 : 1.0) * normal(generator);
    for (int i = 0; i < 4; ++i) bar_bristle(i) = 1e4 * normal(generator);
    PatchLaw law;
    ASSERT_TRUE(law.Evaluate(patch, in));
    PatchCotangent bar_patch;
    Vector6d bar_nu = Vector6d::Zero();
    Bristle bar_previous = Bristle::Zero();
    law.PullBack(bar, bar_bristle, &bar_patch, &bar_nu, &bar_previous);

    const auto value = [&](const PatchIntegrals& p, const PatchLawInput& i) {
      PatchLaw other;
      other.Evaluate(p, i);
      return bar.dot(other.wrench()) + bar_bristle.dot(other.bristle());
    };
    const auto slope = [&](const auto& change, double h) {
      const auto at = [&](double s) {
        PatchIntegrals p = patch;
        PatchLawInput i = in;
        change(&p, &i, s * h);
        return value(p, i);
      };
      return (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
    };
    const auto expect = [&](double got, double difference, double scale) {
      EXPECT_NEAR(got, difference, 1e-6 * (std::abs(got) + scale)) << "trial " << trial;
    };
    for (int k = 0; k < 3; ++k) {
      expect(bar_patch.F(k), slope([k](PatchIntegrals* p, PatchLawInput*, double h) { p->F(k) += h; }, 1e-5), 1.0);
      expect(bar_patch.M(k), slope([k](PatchIntegrals* p, PatchLawInput*, double h) { p->M(k) += h; }, 1e-5), 1.0);
      expect(bar_patch.m1(k), slope([k](PatchIntegrals* p, PatchLawInput*, double h) { p->m1(k) += h; }, 1e-14), 1e9);
    }
    expect(bar_patch.W, slope([](PatchIntegrals* p, PatchLawInput*, double h) { p->W += h; }, 1e-13), 1e8);
    for (int k = 0; k < 6; ++k) {
      const auto [i, j] = PatchIntegrals::kPairs[k];
      expect(bar_patch.Pack()(10 + k),
             slope(
                 [i = i, j = j](PatchIntegrals* p, PatchLawInput*, double h) {
                   p->m2(i, j) += h;
                   if (i != j) p->m2(j, i) += h;
                 },
                 1e-16),
             1e11);
      expect(bar_nu(k), slope([k](PatchIntegrals*, PatchLawInput* in2, double h) { in2->nu(k) += h; }, 1e-6), 0.1);
    }
    if (in.material->stick_distance == 0.0) continue;
    for (int k = 0; k < 4; ++k) {
      expect(bar_previous(k), slope([k](PatchIntegrals*, PatchLawInput* in2, double h) { in2->bristle(k) += h; }, 1e-9),
             1e3);
    }
  }
}

}  // namespace
}  // namespace knap
