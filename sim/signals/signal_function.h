// What a signal is to those who evaluate it: a number at a moment of a rollout, with its exact pull-back.
//
// A moment is a state of the tree. Most signals are functions of it alone; those that look at more, at what was before
// or at what forces and actuators did, ask the moment's track, which policies do not have.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <optional>
#include <vector>

#include "sim/integrators/state_cotangent.h"
#include "sim/math/pose.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// What a whole rollout did, for signals that need more than a state.
class Track {
 public:
  virtual ~Track() = default;
  // Poses of all bodies at state k; k is one of a drift's times.
  virtual const std::vector<Pose>& GetPoses(int k) const = 0;
  virtual int FindState(double time) const = 0;  // at a whole number of steps
  // The interval whose commands act in the step that leads to state k.
  virtual Eigen::Index FindInterval(int k) const = 0;
  virtual double GetCommand(int row, Eigen::Index interval) const = 0;  // −1 … 1, rows as in RolloutCommands
  // Of what was recorded (build_signals.h): the state at or before k that has a force of its own, and that force [N].
  virtual int FindForce(int k) const = 0;
  virtual const Eigen::Vector3d& GetForce(int series, int k) const = 0;
  // How deep the bodies of these of the model's contacts pressed into one another on the way to state k, where the
  // engine has rigid contacts and knows it otherwise than by its poses [m]; none: the poses tell.
  virtual std::optional<double> FindDepth(const std::vector<int>& contacts, int k) const = 0;
};

struct Moment {
  int state = 0;  // its index in the trajectory
  double time = 0.0;
  const Eigen::VectorXd& q;
  const Eigen::VectorXd& v;
  const std::vector<BodyKinematics>& kinematics;  // of q and v; accelerations are not to be used
  const Track* track = nullptr;                   // null where only the present is known
};

struct CommandCotangent {
  int row = 0;
  Eigen::Index interval = 0;
  double bar = 0.0;
};

struct VertexCotangent {
  int contact = 0;                                // of the model
  int shape = 0;                                  // which of its two, a designed mesh
  int vertex = 0;                                 // of that mesh
  Eigen::Vector3d bar = Eigen::Vector3d::Zero();  // in its B
};

// What signals put on a rollout; all added.
struct SignalCotangents {
  std::vector<StateCotangent> states;
  std::vector<Eigen::Vector3d> points;  // of each watched point (by its number), in its B
  std::vector<CommandCotangent> commands;
  std::vector<VertexCotangent> vertices;
  std::vector<double> measures;  // of each measure of a design's shape (by its number)
};

class SignalFunction {
 public:
  virtual ~SignalFunction() = default;
  virtual double Calc(const Moment& at) const = 0;
  // What the cotangent `bar` of Calc puts on the state.
  virtual void PullBack(const Moment& at, double bar, SignalCotangents* out) const = 0;
  // Its time derivative, where that is a signal too: what is between two states then follows a cubic curve, else a
  // straight line. Null where it is not.
  virtual std::unique_ptr<SignalFunction> MakeRate() const { return nullptr; }
};

using SignalPointer = std::shared_ptr<const SignalFunction>;

}  // namespace knap
