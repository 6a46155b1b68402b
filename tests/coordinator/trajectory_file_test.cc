#include "coordinator/report/trajectory_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "sim/scenarios/csv_text.h"

namespace knap {
namespace trajectory_file_test {

using Eigen::Vector3d;

Recording MakeRecording() {
  Recording recording;
  recording.time = {0.0, 0.25, 0.5};
  Recording::Body body{"arm", true, {}};
  for (int k = 0; k < 3; ++k) {
    // Beyond half a turn, where a quaternion computed anew from each matrix changes its sign.
    const double angle = 3.0 + 0.2 * k;
    body.X_WB.push_back({Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(), Vector3d(0.1 * k, 0.0, 1.0)});
  }
  recording.bodies.push_back(body);
  recording.joints.push_back({"arm", "rad", {3.0, 3.2, 3.4}});
  recording.signals.push_back({"tip_speed", "m/s", {0.5, -0.25, 1e-7}});
  const Vector3d nowhere = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  recording.contacts.push_back({{"arm", "floor"},
                                {Vector3d::Zero(), Vector3d(0.0, 0.0, 2.0), Vector3d::Zero()},
                                {nowhere, Vector3d(1.0, 2.0, 0.0), nowhere},
                                {0.0, 1e-5, 0.0}});
  return recording;
}

TEST(TrajectoryFile, CsvHoldsAllOfIt) {
  const CsvTable table(FormatTrajectoryCsv(MakeRecording()));
  ASSERT_EQ(table.size(), 3U);
  double before = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(table.GetNumber(k, "time"), 0.25 * static_cast<double>(k));
    EXPECT_EQ(table.GetNumber(k, "arm.x"), 0.1 * static_cast<double>(k));
    const double half = 0.5 * (3.0 + 0.2 * static_cast<double>(k));
    EXPECT_NEAR(table.GetNumber(k, "arm.qw"), std::cos(half), 1e-12) << "smooth: no change of sign between rows";
    EXPECT_NEAR(table.GetNumber(k, "arm.qz"), std::sin(half), 1e-12);
    EXPECT_GT(table.GetNumber(k, "arm.joint"), before);
    before = table.GetNumber(k, "arm.joint");
  }
  EXPECT_EQ(table.GetNumber(1, "signal.tip_speed"), -0.25);
  EXPECT_EQ(table.GetNumber(2, "signal.tip_speed"), 1e-7);
  EXPECT_EQ(table.GetNumber(1, "arm|floor.fz"), 2.0);
  EXPECT_EQ(table.GetNumber(1, "arm|floor.py"), 2.0);
  EXPECT_EQ(table.GetNumber(1, "arm|floor.depth"), 1e-5);
  EXPECT_EQ(table.Get(0, "arm|floor.px"), "") << "no place while they do not touch";
  EXPECT_EQ(table.GetNumber(0, "arm|floor.fz"), 0.0);
}

TEST(TrajectoryFile, JsonHoldsTheSame) {
  const nlohmann::ordered_json json = MakeTrajectoryJson(MakeRecording());
  EXPECT_EQ(json["time"].size(), 3U);
  EXPECT_EQ(json["bodies"]["arm"]["position"][2][0], 0.2);
  EXPECT_NEAR(json["bodies"]["arm"]["orientation_wxyz"][2][3], std::sin(1.7), 1e-12);
  EXPECT_EQ(json["joints"]["arm"]["unit"], "rad");
  EXPECT_EQ(json["signals"]["tip_speed"]["unit"], "m/s");
  EXPECT_EQ(json["signals"]["tip_speed"]["values"][1], -0.25);
  EXPECT_EQ(json["contacts"][0]["between"][1], "floor");
  EXPECT_TRUE(json["contacts"][0]["place"][0].is_null());
  EXPECT_EQ(json["contacts"][0]["force"][1][2], 2.0);
}

}  // namespace trajectory_file_test
}  // namespace knap
