// A ball that slides, rolls and stands on a plane, against closed forms of a rigid sphere with Coulomb friction.
//
// They hold in two limits, each shown by convergence: a stiff foundation (the contact lies d below the sphere's
// surface, so its lever is r − d, and d/r ∝ E^(−1/2) at rest) and a small slip speed v_s, below which friction is not
// fully developed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace pea_oracle_test {

using Eigen::Vector3d;
using test::BallSample;
using test::BallScene;

constexpr double kG = 9.81;
constexpr double kFriction = 0.4;

// d/r of a ball pressed on by `g`: its weight is π E r d² for small depths.
double CalcRelativeDepth(double stiffness, double g) {
  const BallScene scene;
  return std::sqrt(scene.mass * g / (std::acos(-1.0) * stiffness * scene.radius)) / scene.radius;
}

enum class Floor { kHalfSpace, kCoarseMesh, kFineMesh };  // on the coarse one the path lies in one triangle

// A ball at rest height on a floor tilted by `slope` about y, so that it runs towards +x of the floor.
struct Incline {
  BallScene scene;
  Vector3d down;  // along the slope
  Vector3d normal;

  // It starts with the speed `v` down the slope and spins at `spin` in the sense of rolling down it.
  Incline(const ContactMaterial& material, double slope, Floor floor, double v, double spin) {
    Pose tilt;
    tilt.R = Eigen::AngleAxisd(slope, Vector3d::UnitY()).toRotationMatrix();
    down = tilt.R.col(0);
    normal = tilt.R.col(2);
    std::shared_ptr<const ContactMesh> mesh;
    if (floor != Floor::kHalfSpace) {
      // 3 mm cells, about the width of the patch, or one cell for all.
      const double c = 0.03;
      mesh = std::make_shared<ContactMesh>(floor == Floor::kFineMesh ? test::MakeBar(0.15, 0.02, c, 100, 10)
                                                                     : test::MakeBar(0.15, 0.02, c, 1, 1));
      scene.AddGround(tilt * test::MakeFloorPose(c));
    } else {
      scene.AddGround(tilt);
    }
    scene.AddBall();
    scene.Touch(scene.ground, material, mesh);
    const double height = test::FindRestingHeight(scene, material, kG * std::cos(slope));
    scene.Start(height * normal + 0.01 * tilt.R.col(1), v * down, spin * tilt.R.col(1));
  }
};

// ---- Sliding start ------------------------------------------------------------------------------------------------

struct Slide {
  double final_speed;
  double time;      // when the slip of the lowest point falls below twice the slip speed
  double distance;  // covered until then
};

Slide RunSlide(double stiffness, double slip_speed, double v0, Floor floor) {
  const ContactMaterial material{stiffness, 0.0, kFriction, 0.0, slip_speed};
  const Incline incline(material, 0.0, floor, v0, 0.0);
  const auto samples = RunBall(incline.scene, test::MakeOptions(1e-4, 0.06, 2));
  Slide slide{samples.back().v.x(), 0.0, 0.0};
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const auto slip = [&](const BallSample& s) { return s.v.x() - s.w.y() * incline.scene.radius; };
    const double before = slip(samples[k - 1]);
    const double after = slip(samples[k]);
    if (after > 2.0 * slip_speed) continue;
    const double fraction = (before - 2.0 * slip_speed) / (before - after);
    slide.time = samples[k - 1].time + fraction * (samples[k].time - samples[k - 1].time);
    slide.distance = samples[k - 1].p.x() + fraction * (samples[k].p.x() - samples[k - 1].p.x());
    break;
  }
  return slide;
}

class FloorTest : public testing::TestWithParam<Floor> {};

TEST_P(FloorTest, ASlidingBallEndsAtFiveSeventhsOfItsSpeed) {
  const double v0 = 0.5;
  double previous = 0.0;
  for (const double stiffness : {1e8, 1e10, 1e12}) {
    const double error = std::abs(RunSlide(stiffness, 1e-4, v0, GetParam()).final_speed / v0 - 5.0 / 7.0);
    // v = v0/(1 + 2/5 r²/(r − d)²) differs from 5/7 v0 by 0.41 d/r v0 at first order.
    EXPECT_LT(error, 0.5 * CalcRelativeDepth(stiffness, kG) + 1e-6) << stiffness;
    if (previous > 0.0) {
      EXPECT_LT(error, 0.15 * previous) << stiffness;
    }
    previous = error;
  }
}

TEST_P(FloorTest, SlidingTimeAndDistanceApproachTheClosedForm) {
  const double v0 = 0.5;
  const double time = 2.0 * v0 / (7.0 * kFriction * kG);
  const double distance = 12.0 * v0 * v0 / (49.0 * kFriction * kG);
  double previous_time = 0.0;
  double previous_distance = 0.0;
  for (const double slip_speed : {4e-3, 1e-3, 2.5e-4}) {
    const Slide slide = RunSlide(1e12, slip_speed, v0, GetParam());
    // What remains when the slip is 2 v_s, at a deceleration of the slip of 7/2 μ g: first order in v_s.
    const double time_error = std::abs(slide.time / time - 1.0);
    const double distance_error = std::abs(slide.distance / distance - 1.0);
    EXPECT_LT(time_error, 3.0 * slip_speed / v0);
    EXPECT_LT(distance_error, 3.0 * slip_speed / v0);
    if (previous_time > 0.0) {
      EXPECT_LT(time_error, 0.4 * previous_time);
      EXPECT_LT(distance_error, 0.4 * previous_distance);
    }
    previous_time = time_error;
    previous_distance = distance_error;
  }
}

INSTANTIATE_TEST_SUITE_P(Floors, FloorTest, testing::Values(Floor::kHalfSpace, Floor::kCoarseMesh, Floor::kFineMesh));

// ---- Incline ------------------------------------------------------------------------------------------------------

struct Accelerations {
  double linear;   // down the slope [m/s²]
  double angular;  // about the axis of rolling down it [rad/s²]
  double normal;   // away from the plane
};

Accelerations MeasureAccelerations(const ContactMaterial& material, double slope, Floor floor) {
  const Incline incline(material, slope, floor, 0.01, 1.0);  // rolling
  const auto samples = RunBall(incline.scene, test::MakeOptions(2e-4, 0.1, 2));
  const BallSample& a = samples[samples.size() / 2];
  const BallSample& b = samples.back();
  const double t = b.time - a.time;
  const Vector3d axis = incline.normal.cross(incline.down);
  return {incline.down.dot(b.v - a.v) / t, axis.dot(b.w - a.w) / t, incline.normal.dot(b.v - a.v) / t};
}

TEST_P(FloorTest, ABallOnAnInclineRollsBelowTheThresholdAndSlipsAbove) {
  const double threshold = std::atan(3.5 * kFriction);
  for (const double stiffness : {1e8, 1e10}) {
    const ContactMaterial material{stiffness, 0.0, kFriction, 0.0, 1e-4};
    for (const double share : {0.2, 0.6, 0.95, 1.05, 1.2, 1.5}) {
      const double slope = share * threshold;
      const Accelerations a = MeasureAccelerations(material, slope, GetParam());
      // The lever r − d changes the expected values by at most 0.57 d/r (rolling) and d/r (slipping); the part of
      // friction not developed is below (v_s/s)²/2 = 2e-5 at the slips reached.
      const double tolerance = 1.1 * CalcRelativeDepth(stiffness, kG * std::cos(slope)) + 3e-5;
      const bool rolls = share < 1.0;
      const double linear =
          rolls ? 5.0 / 7.0 * kG * std::sin(slope) : kG * (std::sin(slope) - kFriction * std::cos(slope));
      const double angular = rolls ? linear / 0.01 : 2.5 * kFriction * kG * std::cos(slope) / 0.01;
      EXPECT_NEAR(a.linear / linear, 1.0, tolerance) << share;
      EXPECT_NEAR(a.angular / angular, 1.0, tolerance) << share;
      EXPECT_NEAR(a.normal, 0.0, 1e-3 * kG) << share;
    }
  }
}

TEST_P(FloorTest, RollingResistanceBrakesAboveItsThreshold) {
  const double resistance = 0.03;
  for (const double stiffness : {1e8, 1e10}) {
    // The slip speed is far below the speeds reached, so that the resistance is fully developed.
    const ContactMaterial material{stiffness, 0.0, kFriction, resistance, 1e-5};
    for (const double share : {1.25, 2.0, 6.0}) {
      const double slope = std::atan(share * resistance);
      const Accelerations a = MeasureAccelerations(material, slope, GetParam());
      // Lever: 0.57 d/r of all, and d/r of the resistance, which is 1/(share − 1) of the difference.
      const double tolerance = (0.7 + 1.1 / (share - 1.0)) * CalcRelativeDepth(stiffness, kG) + 3e-5;
      EXPECT_NEAR(a.linear / (5.0 / 7.0 * kG * (std::sin(slope) - resistance * std::cos(slope))), 1.0, tolerance)
          << share << " at " << stiffness;
    }
  }
}

// Below its threshold only the regularisation creeps: friction and resistance reach the share x of their bounds at the
// speed v_s x/√(1 − x²), and the two creeps add up. Nothing accelerates, and the creep is proportional to v_s.
TEST_P(FloorTest, RollingResistanceHoldsBelowItsThresholdButForTheCreep) {
  const double resistance = 0.03;
  for (const double share : {0.3, 0.8}) {
    const double slope = std::atan(share * resistance);
    const double slip_share = share * resistance / kFriction;
    const double creep = share / std::sqrt(1.0 - share * share) + slip_share / std::sqrt(1.0 - slip_share * slip_share);
    // The lever changes x by d/r of itself, its creep by 1/(1 − x²) times that, and the speed by d/r once more.
    const double tolerance = 1.1 * (1.0 / (1.0 - share * share) + 1.0) * CalcRelativeDepth(1e10, kG);
    for (const double slip_speed : {1e-3, 1e-4}) {
      const Incline incline({1e10, 0.0, kFriction, resistance, slip_speed}, slope, GetParam(), slip_speed,
                            100.0 * slip_speed);
      const auto samples = RunBall(incline.scene, test::MakeOptions(1e-3, 0.5, 2));
      EXPECT_NEAR(incline.down.dot(samples.back().v) / (creep * slip_speed), 1.0, tolerance) << share;
      const double distance = incline.down.dot(samples.back().p - samples.front().p);
      EXPECT_LT(distance, 0.5 * std::max(1.0, creep) * slip_speed) << share;
    }
  }
}

}  // namespace pea_oracle_test
}  // namespace knap
