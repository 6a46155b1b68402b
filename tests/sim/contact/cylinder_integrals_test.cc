// A cylinder in a half-space: against closed forms, against sums over a fine lattice of its volume, and derivatives
// against differences.
#include "sim/contact/cylinder_integrals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/contact/contact_mesh.h"
#include "tests/sim/contact/field_depth.h"
#include "tests/sim/contact/pair_sum.h"
#include "tests/sim/contact/patch_differences.h"
#include "tests/sim/contact/random_places.h"

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

PatchIntegrals Calc(const SolidCylinder& cylinder) {
  PatchIntegrals patch;
  CalcCylinder(cylinder, {Vector3d::UnitZ(), 0.0}, &patch, nullptr);
  return patch;
}

TEST(CylinderIntegralsTest, StandingItPressesLikeAColumn) {
  const double r = 0.012;
  const double depth = 3e-6;
  const PatchIntegrals patch = Calc({Vector3d(0.01, 0.02, 0.005 - depth), Vector3d::UnitZ(), 0.005, r});
  const double F = kPi * r * r * depth;
  EXPECT_NEAR(patch.F.z(), F, 1e-12 * F);
  EXPECT_LE(patch.F.head<2>().norm(), 1e-15 * F);
  EXPECT_NEAR(patch.M.x(), 0.02 * F, 1e-12 * F);
  EXPECT_NEAR(patch.M.y(), -0.01 * F, 1e-12 * F);
  EXPECT_NEAR(patch.depth, depth, 1e-15);
  // The spot is the disc: its spread is r²/4 about either axis.
  const Eigen::Matrix3d spread = patch.m2 / patch.W - patch.m1 * patch.m1.transpose() / (patch.W * patch.W);
  EXPECT_NEAR(spread(0, 0), 0.25 * r * r, 1e-3 * r * r);
}

TEST(CylinderIntegralsTest, LyingItDisplacesASegment) {
  const double r = 0.012;
  const double H = 0.02;
  for (const double depth : {1e-5, 1e-3, 0.012, 0.02, 0.03}) {
    const PatchIntegrals patch = Calc({Vector3d(0.0, 0.0, r - depth), Vector3d(0.6, 0.8, 0.0), H, r});
    const double c = std::clamp((r - depth) / r, -1.0, 1.0);
    const double area = r * r * (std::acos(c) - c * std::sqrt(1.0 - c * c));
    EXPECT_NEAR(patch.F.z(), 2.0 * H * area, 1e-10 * 2.0 * H * area) << depth;
    EXPECT_LE(patch.F.head<2>().norm(), 1e-13 * patch.F.z());
    EXPECT_LE(patch.M.norm(), 1e-13 * patch.F.z());
    EXPECT_NEAR(patch.depth, depth, 1e-12);
  }
}

class RandomCylinders {
 public:
  SolidCylinder MakeCylinder() {
    const double H = U(0.001, 0.02);
    const double r = U(0.002, 0.015);
    return {{U(-0.01, 0.01), U(-0.01, 0.01), U(-0.5, 0.9) * (H + r)},
            Vector3d(U(-1.0, 1.0), U(-1.0, 1.0), U(-1.0, 1.0)).normalized(),
            H,
            r};
  }
  double U(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }

 private:
  std::mt19937_64 generator_{3};
};

// Buoyancy: F is the volume below the plane, M that volume's moment.
TEST(CylinderIntegralsTest, EqualsTheVolumeBelow) {
  RandomCylinders random;
  int compared = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const SolidCylinder c = random.MakeCylinder();
    const Vector3d b = c.direction.unitOrthogonal();
    const Vector3d d = c.direction.cross(b);
    constexpr int kN = 60;
    double volume = 0.0;
    Vector3d moment = Vector3d::Zero();
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j < 4 * kN; ++j) {
        for (int k = 0; k < kN; ++k) {
          const double radius = c.radius * std::sqrt((i + 0.5) / kN);  // rings of equal area
          const double angle = 2.0 * kPi * (j + 0.5) / (4 * kN);
          const double s = c.half_length * (2.0 * (k + 0.5) / kN - 1.0);
          const Vector3d x = c.center + s * c.direction + radius * (std::cos(angle) * b + std::sin(angle) * d);
          if (x.z() >= 0.0) continue;
          volume += 1.0;
          moment += x.cross(Vector3d::UnitZ());
        }
      }
    }
    const double part = kPi * c.radius * c.radius * 2.0 * c.half_length / (4.0 * kN * kN * kN);
    volume *= part;
    moment *= part;
    const double whole = kPi * c.radius * c.radius * 2.0 * c.half_length;
    if (volume < 0.01 * whole) continue;
    ++compared;
    const PatchIntegrals patch = Calc(c);
    EXPECT_NEAR(patch.F.z(), volume, 2e-3 * whole);
    EXPECT_LE(patch.F.head<2>().norm(), 1e-11 * whole) << "the plane pushes along its normal";
    EXPECT_LE((patch.M - moment).norm(), 2e-3 * whole * 0.03);
  }
  EXPECT_GE(compared, 10);
}

TEST(CylinderIntegralsTest, MovesAsDifferencesSay) {
  RandomCylinders random;
  int compared = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const SolidCylinder c = random.MakeCylinder();
    PatchIntegrals patch;
    PatchJacobian jacobian;
    CalcCylinder(c, {Vector3d::UnitZ(), 0.0}, &patch, &jacobian);
    if (!patch.active()) continue;
    ++compared;
    // Eight points an arc leave 1e-11 of the value, which smaller steps would show.
    test::ExpectJacobian(jacobian, Pose{}, 1e-5, 2e-5, [&](const Pose& X) { return Calc(c.Move(X)); });
  }
  EXPECT_GE(compared, 40);
}

// Moments of a standing cylinder are linear in the least tilts, where no direction across it is more level than others.
TEST(CylinderIntegralsTest, UprightIsNothingSpecial) {
  const double r = 0.007;
  const Vector3d about(0.6, 0.8, 0.0);
  const auto calc = [&](double tilt) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(tilt, about).toRotationMatrix();
    return Calc({Vector3d(0.0, 0.0, 0.002 - 2e-6), R * Vector3d::UnitZ(), 0.002, r});
  };
  // A disc's second moment times the slope of the depth, and the weight's lever over the tilting centre.
  const double slope = kPi * std::pow(r, 4) / 4.0 + kPi * r * r * 2e-6 * 0.002;
  for (const double tilt : {1e-14, 3e-13, 2e-12, 1e-10, 1e-8, 1e-6}) {
    const Vector3d M = calc(tilt).M;
    EXPECT_LE((M + slope * tilt * about).norm(), 2e-3 * slope * tilt + 1e-24) << tilt;
  }
}

// Of E ∫ e dV over what both share: the force on B is −E ∫ ∇e dV, here summed around B's axis.
Vector3d SumOverVolume(const CylinderField& B, const DepthField& S, const Pose& X_SB, double modulus) {
  constexpr int kParts = 100;
  constexpr double h = 1e-8;
  const Vector3d u = B.axis.unitOrthogonal();
  const Vector3d w = B.axis.cross(u);
  Vector3d F = Vector3d::Zero();
  int cell = 0;
  for (int i = 0; i < kParts; ++i) {
    const double r = (i + 0.5) / kParts * B.radius;
    const double dV = r * (B.radius / kParts) * (2.0 * kPi / kParts) * (2.0 * B.half_length / kParts);
    for (int j = 0; j < kParts; ++j) {
      const double angle = 2.0 * kPi * (j + 0.5) / kParts;
      for (int k = 0; k < kParts; ++k) {
        const double along = (2.0 * (k + 0.5) / kParts - 1.0) * B.half_length;
        const Vector3d x = X_SB * Vector3d(B.center + r * (std::cos(angle) * u + std::sin(angle) * w) + along * B.axis);
        if (test::CalcFieldDepth(S, x, &cell) <= 0.0) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3d d = h * Vector3d::Unit(axis);
          F(axis) -= modulus * dV / (2.0 * h) *
                     (test::CalcFieldDepth(S, x + d, &cell) - test::CalcFieldDepth(S, x - d, &cell));
        }
      }
    }
  }
  return F;
}

// Against balls, capsules and one another cylinders are prisms: what they press is theirs to the sum's accuracy.
TEST(CylinderIntegralsTest, APrismStandsForItAgainstRoundBodies) {
  const CylinderGeometry can{0.006, 0.008, {0.0, 0.001, 0.0}};
  const CylinderGeometry coin{0.011, 0.0025, {0.001, 0.0, 0.0}, Vector3d(0.6, 0.0, 0.8)};
  const SphereGeometry sphere{0.007, {0.0, 0.001, 0.0}};
  const CapsuleGeometry capsule{0.005, 0.012, {0.0, 0.0, 0.001}};
  const auto field_of = [](const CylinderGeometry& c) {
    return CylinderField{c.radius, c.half_length, c.center, c.axis};
  };
  test::RandomPlaces random(6);
  for (int trial = 0; trial < 4; ++trial) {
    for (const CylinderGeometry& cylinder : {can, coin}) {
      Pose X_SC = random.MakePose(1.5, 0.002);
      X_SC.p.z() += 0.006;
      const auto expect = [&](const ContactGeometry& other, const Vector3d& sum) {
        const test::Wrench found = test::CalcWrench(cylinder, other, X_SC);
        ASSERT_GT(sum.norm(), 1e-3);
        EXPECT_LE((found.F - sum).norm(), 0.003 * sum.norm()) << found.F.transpose() << " : " << sum.transpose();
      };
      expect(sphere, SumOverVolume(field_of(cylinder), RoundField{sphere.radius, 0.0, sphere.center}, X_SC, 1e9));
      expect(capsule,
             SumOverVolume(field_of(cylinder),
                           RoundField{capsule.radius, capsule.half_length, capsule.center, capsule.axis}, X_SC, 1e9));
      const Pose X_CS{X_SC.R.transpose(), -(X_SC.R.transpose() * X_SC.p)};
      expect(can, SumOverVolume(field_of(cylinder), field_of(can), X_SC, 0.5e9) -
                      X_SC.R * SumOverVolume(field_of(can), field_of(cylinder), X_CS, 0.5e9));
    }
  }
}

// The ripple of the prism's sides under a ball of half its radius is what a micrometre of depth to either side makes.
TEST(CylinderIntegralsTest, ABallRollsAroundAPrism) {
  const CylinderGeometry can{0.01, 0.008};
  const SphereGeometry ball{0.005};
  double least = 1e9, most = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2.0 * kPi / ContactMesh::kCylinderSides * i / 20.0;
    const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    const double F = -test::CalcWrench(can, ball, {Eigen::Matrix3d::Identity(), -(0.015 - 1e-4) * out}).F.dot(out);
    least = std::min(least, F);
    most = std::max(most, F);
  }
  const auto force_at = [&](double depth) {
    return test::CalcWrench(can, ball, {Eigen::Matrix3d::Identity(), Vector3d(-0.015 + depth, 0.0, 0.0)}).F.norm();
  };
  EXPECT_GT(least, 0.0);
  EXPECT_LE(most - least, force_at(1.01e-4) - force_at(0.99e-4));
}

TEST(CylinderIntegralsTest, AboveThePlaneNothingActs) {
  EXPECT_FALSE(Calc({Vector3d(0.0, 0.0, 0.0101), Vector3d::UnitX(), 0.02, 0.01}).active());
  EXPECT_TRUE(Calc({Vector3d(0.0, 0.0, 0.0099), Vector3d::UnitX(), 0.02, 0.01}).active());
}

}  // namespace
}  // namespace knap
