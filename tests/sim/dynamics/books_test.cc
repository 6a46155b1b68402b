// Momentum and energy books of a ball's run, from the reported contact wrenches alone.
//
// BDF1 obeys M (V_{k+1} − V_k) = h F_{k+1} exactly, in the world for the linear part and, because the rates of a ball
// joint are components in the moving body, in the body for the angular part; so those sums close to the Newton
// tolerance. Everything else closes in the limit of small steps.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace books_test {

using Eigen::Vector3d;
using test::BallSample;
using test::BallScene;

// A ball thrown obliquely onto a half-space: it bounces, slips, rolls and spins about the normal.
BallScene MakeThrow(const ContactMaterial& material) {
  BallScene scene;
  scene.AddGround({});
  scene.AddBall();
  scene.Touch(scene.ground, material);
  scene.Start(Vector3d(0, 0, 0.012), Vector3d(0.2, 0.1, -0.1), Vector3d(30, -5, 10));
  return scene;
}

// Elastic energy of a ball pressed into a half-space: E times the depth, summed over what is below, π (r δ³/3 − δ⁴/12).
double CalcElasticEnergy(const BallScene& scene, const ContactMaterial& material, const Vector3d& p) {
  const double r = scene.radius;
  const double depth = std::max(0.0, r - p.z());
  return material.stiffness * std::numbers::pi * depth * depth * depth * (r / 3.0 - depth / 12.0);
}

double CalcEnergy(const BallScene& scene, const ContactMaterial& material, const BallSample& s) {
  return 0.5 * scene.mass * s.v.squaredNorm() + 0.5 * scene.inertia() * s.w.squaredNorm() +
         scene.mass * 9.81 * s.p.z() + CalcElasticEnergy(scene, material, s.p);
}

const ContactMaterial kRough{1.3e8, 2.0, 0.4, 0.03, 1e-3};
const ContactMaterial kIdeal{1.3e8, 0.0, 0.0, 0.0, 1e-3};

TEST(Books, LinearMomentumClosesToTheNewtonTolerance) {
  const BallScene scene = MakeThrow(kRough);
  const double h = 1e-3;
  const auto samples = RunBall(scene, test::MakeOptions(h, 0.3, 1));
  const Vector3d weight(0, 0, -9.81 * scene.mass);
  Vector3d impulse = Vector3d::Zero();
  double turnover = 0.0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    impulse += h * (samples[k].f + weight);
    turnover += h * (samples[k].f.norm() + weight.norm()) + 2.0 * scene.mass * samples[k].v.norm();
  }
  const Vector3d change = scene.mass * (samples.back().v - samples.front().v);
  EXPECT_GT(change.norm(), 1e-4);
  // Each step leaves at most 1e-11 of the terms it sums, momentum included.
  EXPECT_LT((impulse - change).norm(), 1e-11 * turnover);
}

TEST(Books, AngularMomentumClosesStepByStepInTheBody) {
  const BallScene scene = MakeThrow(kRough);
  const double h = 1e-3;
  const auto samples = RunBall(scene, test::MakeOptions(h, 0.3, 1));
  double largest = 0.0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const Vector3d before = samples[k - 1].R.transpose() * samples[k - 1].w;
    const Vector3d after = samples[k].R.transpose() * samples[k].w;
    const Vector3d change = scene.inertia() * (after - before);
    const Vector3d impulse = h * (samples[k].R.transpose() * samples[k].m);
    // The scale of a residual counts momentum and moment by component: √3 at most, and rounding.
    EXPECT_LT((change - impulse).norm(), 3e-11 * (scene.inertia() * after.norm() + impulse.norm())) << k;
    largest = std::max(largest, change.norm());
  }
  EXPECT_GT(largest, 1e-8);
}

class BooksOrderTest : public testing::TestWithParam<int> {};

// Σ h m over the states of the trapezoidal rule, against the change of I w in the world.
TEST_P(BooksOrderTest, AngularMomentumInTheWorldClosesAsTheStepFalls) {
  const BallScene scene = MakeThrow(kRough);
  double previous = 0.0;
  for (const double h : {4e-4, 2e-4, 1e-4, 5e-5}) {
    const auto samples = RunBall(scene, test::MakeOptions(h, 0.1, GetParam()));
    Vector3d impulse = Vector3d::Zero();
    for (std::size_t k = 1; k < samples.size(); ++k) impulse += 0.5 * h * (samples[k - 1].m + samples[k].m);
    const double error = (scene.inertia() * (samples.back().w - samples.front().w) - impulse).norm() /
                         (scene.inertia() * samples.front().w.norm());
    if (h == 5e-5) {
      EXPECT_LT(error, GetParam() == 1 ? 5e-3 : 1e-4);
    }
    if (previous > 0.0) {
      EXPECT_LT(error, (GetParam() == 1 ? 0.65 : 0.45) * previous) << h;
    }
    previous = error;
  }
}

// Without friction and damping the energy is kept, but for the integrator.
TEST_P(BooksOrderTest, EnergyIsKeptWithoutFrictionAtTheIntegratorsOrder) {
  const BallScene scene = MakeThrow(kIdeal);
  const double start = CalcEnergy(scene, kIdeal, RunBall(scene, test::MakeOptions(1e-4, 0.0, 1)).front());
  double previous = 0.0;
  for (const double h : {2e-5, 1e-5, 5e-6}) {
    // One bounce: down at 11 ms, up again before 20 ms.
    const auto samples = RunBall(scene, test::MakeOptions(h, 0.03, GetParam()));
    bool touched = false;
    double worst = 0.0;
    for (const BallSample& s : samples) {
      touched = touched || s.f.z() > 0.0;
      worst = std::max(worst, std::abs(CalcEnergy(scene, kIdeal, s) / start - 1.0));
    }
    EXPECT_TRUE(touched);
    EXPECT_EQ(samples.back().f.norm(), 0.0);
    // Nothing turns it; each step may leave 1e-11 of the momentum.
    EXPECT_LT((samples.back().w - samples.front().w).norm(), 1e-11 * static_cast<double>(samples.size()) * 35.0);
    if (previous > 0.0) {
      EXPECT_NEAR(std::log2(previous / worst), GetParam(), 0.25) << h;
    }
    previous = worst;
  }
  EXPECT_LT(previous, GetParam() == 1 ? 2e-2 : 1e-3);
}

// What is lost is the work of friction, rolling resistance and damping: of the wrench less minus the gradient of the
// elastic energy.
TEST_P(BooksOrderTest, LossesAreTheWorkOfFrictionAndDamping) {
  const BallScene scene = MakeThrow(kRough);
  double previous = 0.0;
  for (const double h : {4e-5, 2e-5, 1e-5}) {
    const auto samples = RunBall(scene, test::MakeOptions(h, 0.1, GetParam()));
    const auto power = [&](const BallSample& s) {
      const double step = 1e-9;
      const Vector3d up(0, 0, step);
      const double slope =
          (CalcElasticEnergy(scene, kRough, s.p + up) - CalcElasticEnergy(scene, kRough, s.p - up)) / (2.0 * step);
      return (s.f + slope * Vector3d::UnitZ()).dot(s.v) + s.m.dot(s.w);
    };
    double work = 0.0;
    for (std::size_t k = 1; k < samples.size(); ++k) work += 0.5 * h * (power(samples[k - 1]) + power(samples[k]));
    const double start = CalcEnergy(scene, kRough, samples.front());
    const double lost = start - CalcEnergy(scene, kRough, samples.back());
    EXPECT_GT(lost, 0.1 * start);
    const double error = std::abs(lost + work) / start;
    if (previous > 0.0) {
      EXPECT_LT(error, (GetParam() == 1 ? 0.65 : 0.45) * previous) << h;
    }
    previous = error;
  }
  EXPECT_LT(previous, GetParam() == 1 ? 1e-2 : 3e-4);
}

INSTANTIATE_TEST_SUITE_P(Bdf, BooksOrderTest, testing::Values(1, 2));

// The foundation's energy is convex in the height, so implicit Euler never adds any, at any step.
TEST(Books, EnergyNeverGrowsUnderImplicitEuler) {
  for (const ContactMaterial& material : {kIdeal, kRough}) {
    for (const double h : {1e-5, 1e-3, 5e-3}) {
      const BallScene scene = MakeThrow(material);
      const auto samples = RunBall(scene, test::MakeOptions(h, 0.3, 1));
      for (std::size_t k = 1; k < samples.size(); ++k) {
        const double before = CalcEnergy(scene, material, samples[k - 1]);
        EXPECT_LE(CalcEnergy(scene, material, samples[k]), before * (1.0 + 1e-10)) << "step " << k << " of " << h;
      }
    }
  }
}

}  // namespace books_test
}  // namespace knap
