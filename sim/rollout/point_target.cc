#include "sim/rollout/point_target.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace knap {

using Eigen::Vector3d;

namespace {

// The target that counts when step `begin` does.
const Vector3d& FindTarget(const PointTargetLoss& loss, double step, int begin) {
  const auto later = std::find_if(loss.targets.begin() + 1, loss.targets.end(), [&](const TimedTarget& target) {
    return std::ceil(target.from / step - 1e-9) > begin;  // a time of a whole number of steps, but for rounding
  });
  return (later - 1)->position;
}

}  // namespace

double EvaluatePointTarget(const PointTargetLoss& loss, double step, const Trajectory& trajectory, int body,
                           Dynamics* dynamics, std::vector<StateCotangent>* states, Vector3d* bar_point) {
  const int stride = static_cast<int>(std::llround(loss.sample_period / step));
  const double scale = loss.weight / loss.length_unit;
  double sum = 0.0;
  for (int n = stride; n <= trajectory.whole_steps(); n += stride) {
    const int k = trajectory.state_of_step(n);
    dynamics->CalcKinematics(trajectory.q(k), trajectory.v(k), trajectory.vdot(k), trajectory.time(k));
    const Pose& X_WB = dynamics->kinematics()[static_cast<std::size_t>(body)].X_WB;
    const Vector3d arm_W = X_WB.R * loss.point;
    const Vector3d offset = X_WB.p + arm_W - FindTarget(loss, step, n - stride);
    const double distance = offset.norm();
    sum += distance;
    if (distance == 0.0) continue;
    StateCotangent cotangent;
    cotangent.state = k;
    cotangent.body = body;
    cotangent.p_W = scale / distance * offset;
    cotangent.r_W = arm_W.cross(cotangent.p_W);
    states->push_back(cotangent);
    *bar_point += X_WB.R.transpose() * cotangent.p_W;
  }
  return scale * sum;
}

}  // namespace knap
