// What knap simulated, as a track: states of the tree, forces that were recorded, commands.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <optional>
#include <vector>

#include "sim/integrators/trajectory.h"
#include "sim/rollout/build_signals.h"
#include "sim/rollout/rollout_track.h"

namespace knap {

// Forces of contacts, at the start and after every accepted step.
struct ForceRecord {
  std::vector<double> time;
  std::vector<std::vector<Eigen::Vector3d>> f_W;  // of each of SignalSet::forces(): on the contacts' first body [N]
};
void AddToRecord(double time, const std::vector<ForceSeries>& series, const ContactModel& contacts,
                 ForceRecord* record);

class SimulatedTrack final : public RolloutTrack {
 public:
  // `trajectory` and `dynamics` must outlive it; the dynamics' state changes with every look. `commands`: a row for
  // each driven actuator (FindCommandRow), a column an interval.
  SimulatedTrack(const Trajectory& trajectory, Dynamics* dynamics, double step, const std::vector<double>& remembered,
                 Eigen::MatrixXd commands, ForceRecord forces);

  int size() const override { return trajectory_.size(); }
  double time(int k) const override { return trajectory_.time(k); }
  bool IsStage(int k) const override { return trajectory_.formula(k).is_stage; }
  Moment At(int k) override;

  int FindState(double time) const override;
  const std::vector<Pose>& GetPoses(int k) const override { return poses_.at(k); }
  Eigen::Index FindInterval(int k) const override;
  double GetCommand(int row, Eigen::Index interval) const override { return commands_(row, interval); }
  int FindForce(int k) const override;
  const Eigen::Vector3d& GetForce(int series, int k) const override;
  std::optional<double> FindDepth(const std::vector<int>&, int) const override { return std::nullopt; }

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
