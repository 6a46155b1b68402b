// A simulated rollout as signals see it: its states one by one, and what a state does not tell.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <vector>

#include "sim/integrators/trajectory.h"
#include "sim/rollout/build_signals.h"
#include "sim/signals/signal_function.h"

namespace knap {

// Forces of contacts, at the start and after every accepted step.
struct ForceRecord {
  std::vector<double> time;
  std::vector<std::vector<Eigen::Vector3d>> f_W;  // of each of SignalSet::forces(): on the contacts' first body [N]
};
void AddToRecord(double time, const std::vector<ForceSeries>& series, const ContactModel& contacts,
                 ForceRecord* record);

class RolloutTrack final : public Track {
 public:
  // `trajectory` and `dynamics` must outlive it; the dynamics' state changes with every look. `commands`: a row for
  // each driven actuator (FindCommandRow), a column an interval.
  RolloutTrack(const Trajectory& trajectory, Dynamics* dynamics, double step, const std::vector<double>& remembered,
               Eigen::MatrixXd commands, ForceRecord forces);

  // Holds until another state is looked at.
  Moment At(int k);
  double Calc(const SignalFunction& signal, int k) { return signal.Calc(At(k)); }

  const Trajectory& trajectory() const { return trajectory_; }
  int last_state() const { return trajectory_.size() - 1; }

  int FindState(double time) const override;
  const std::vector<Pose>& GetPoses(int k) const override { return poses_.at(k); }
  Eigen::Index FindInterval(int k) const override;
  double GetCommand(int row, Eigen::Index interval) const override { return commands_(row, interval); }
  int FindForce(int k) const override;
  const Eigen::Vector3d& GetForce(int series, int k) const override;

 private:
  void Look(int k);
  std::size_t FindRecord(int k) const;

  const Trajectory& trajectory_;
  Dynamics* dynamics_;
  double step_;
  Eigen::MatrixXd commands_;
  ForceRecord forces_;
  std::map<int, std::vector<Pose>> poses_;  // of remembered states
  int at_ = -1;                             // the state that the dynamics are at; −1: unknown
  Eigen::VectorXd q_, v_, vdot_;
};

}  // namespace knap
