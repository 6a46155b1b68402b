#include "sim/rollout/simulated_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace knap {

void AddToRecord(double time, const std::vector<ForceSeries>& series, const ContactModel& contacts,
                 ForceRecord* record) {
  record->time.push_back(time);
  record->f_W.resize(series.size());
  for (std::size_t i = 0; i < series.size(); ++i) {
    Eigen::Vector3d f_W = Eigen::Vector3d::Zero();
    for (const int contact : series[i].contacts) f_W += contacts.reports()[static_cast<std::size_t>(contact)].f_W;
    record->f_W[i].push_back(f_W);
  }
}

SimulatedTrack::SimulatedTrack(const Trajectory& trajectory, Dynamics* dynamics, double step,
                               const std::vector<double>& remembered, Eigen::MatrixXd commands, ForceRecord forces)
    : trajectory_(trajectory),
      dynamics_(dynamics),
      step_(step),
      commands_(std::move(commands)),
      forces_(std::move(forces)) {
  // What stopped early has no such states, and nobody judges it.
  if (!trajectory.certificate.converged) return;
  for (const double time : remembered) {
    const int k = FindState(time);
    Look(k);
    std::vector<Pose>& poses = poses_[k];
    for (const BodyKinematics& kin : dynamics_->kinematics()) poses.push_back(kin.X_WB);
  }
}

void SimulatedTrack::Look(int k) {
  if (k == at_) return;
  q_ = trajectory_.q(k);
  v_ = trajectory_.v(k);
  vdot_ = trajectory_.vdot(k);
  dynamics_->CalcKinematics(q_, v_, vdot_, trajectory_.time(k));
  at_ = k;
}

Moment SimulatedTrack::At(int k) {
  Look(k);
  return {k, trajectory_.time(k), q_, v_, dynamics_->kinematics(), this};
}

int SimulatedTrack::FindState(double time) const {
  return trajectory_.state_of_step(static_cast<int>(std::llround(time / step_)));
}

Eigen::Index SimulatedTrack::FindInterval(int k) const {
  // The first whole step that ends at the state or after it.
  int low = 0, high = trajectory_.whole_steps();
  while (low < high) {
    const int middle = (low + high) / 2;
    if (trajectory_.state_of_step(middle) < k) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return trajectory_.controls.IntervalOfStep(std::max(low - 1, 0));
}

std::size_t SimulatedTrack::FindRecord(int k) const {
  // A stage within a step has no entry of its own: what was before counts.
  const auto after = std::upper_bound(forces_.time.begin(), forces_.time.end(), trajectory_.time(k));
  return static_cast<std::size_t>(after - forces_.time.begin() - 1);
}

int SimulatedTrack::FindForce(int k) const {
  const double time = forces_.time[FindRecord(k)];
  while (trajectory_.time(k) > time) --k;
  return k;
}

const Eigen::Vector3d& SimulatedTrack::GetForce(int series, int k) const {
  return forces_.f_W[static_cast<std::size_t>(series)][FindRecord(k)];
}

}  // namespace knap
