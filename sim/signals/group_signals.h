// The common centre of mass C of some bodies, p_WoC = Σ m p_WBcm / Σ m:
//
//   coordinate   e_A · p_AoC_A
//   drift        n · (p_WoC(t) − X_WA(t) X_WA(s)⁻¹ p_WoC(s)): how far along n it is from where a body A would have
//                carried it since the time s
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/multibody/tree.h"
#include "sim/signals/signal_function.h"

namespace knap {

// Masses and centres of some bodies of a tree.
class Group {
 public:
  Group(const Tree& tree, const std::vector<int>& bodies);

  template <class GetPose>  // GetPose(body): X_WB
  Eigen::Vector3d CalcCenter(const GetPose& get_pose) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Member& m : members_) sum += m.mass * (get_pose(m.body) * m.p_BoBcm);
    return sum / mass_;
  }

  // What `bar_W`, the cotangent of the centre at state k, puts on the bodies there.
  template <class GetPose>
  void PullBack(int k, const Eigen::Vector3d& bar_W, const GetPose& get_pose, SignalCotangents* out) const {
    for (const Member& m : members_) {
      StateCotangent& c = out->states.emplace_back();
      c.state = k;
      c.body = m.body;
      c.p_W = m.mass / mass_ * bar_W;
      c.r_W = (get_pose(m.body).R * m.p_BoBcm).cross(c.p_W);
    }
  }

 private:
  struct Member {
    int body = 0;
    double mass = 0.0;
    Eigen::Vector3d p_BoBcm;
  };
  std::vector<Member> members_;
  double mass_ = 0.0;
};

// `axis_A` is a unit vector of body `in` or of the world.
std::unique_ptr<SignalFunction> MakeCenterSignal(const Group& group, int in, const Eigen::Vector3d& axis_A);
// `carrier` is a body or negative, the world; `since` a whole number of steps.
std::unique_ptr<SignalFunction> MakeDriftSignal(const Group& group, int carrier, double since,
                                                const Eigen::Vector3d& axis_W);

}  // namespace knap
