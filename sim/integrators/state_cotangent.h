// Cotangents of one body's motion, of one joint coordinate or of one contact's force, at one state of a trajectory: how
// signals speak to the adjoint.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace knap {

struct StateCotangent {
  int state = 0;
  int body = -1;                                  // none
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // of p_WBo_W
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  // of v_WBo_W
  Eigen::Vector3d r_W = Eigen::Vector3d::Zero();  // of the orientation: of dr where dR_WB = [dr]× R_WB
  Eigen::Vector3d w_W = Eigen::Vector3d::Zero();  // of w_WB_W
  // Of the state's time, where whoever watches knows what another time would mean to him; without a value the time is
  // his, and the state stays where it is.
  std::optional<double> time{};
  // Of the state's time where it is read as a number. Whoever fills in `time` adds it there; else the state stays, and
  // so does its time.
  double clock = 0.0;
  // Of the joint coordinate with this index in v: of its pose and of its rate.
  int coordinate = -1;  // none
  double pose = 0.0;
  double rate = 0.0;
  // Of the force of the contact with this number (ContactReport::f_W), as the solve that led to the state has it.
  int contact = -1;  // none
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();
};

}  // namespace knap
