// How long a step of TR-BDF2 may be: the error of a step, and the next step that follows from it.
//
// With k the slopes (v, vdot) at the step's start, its inner stage and its end, the step and an embedded formula of
// third order differ by
//
//   delta = h Σ (b − b^) k,   b = (w, w, d),   b^ = ((1 − w)/3, (1 + 3w)/3, d/3)                    [Bank et al. 1985]
//   error = max over joints of sqrt(|delta_q|²/r² + |delta_v|²/V²) / tolerance
//
// r is a length of the scene, the least half width or radius of what moves or touches (what turns: 1 rad), V the
// largest speed of the last 50 ms, at least 20 mm/s (what turns: V/r). A step is accepted at error ≤ 1; the next one is
// 0.9 error^(−1/3) times as long, at least a fifth, at most twice, and no longer after a rejection.
//
// A body could also pass through another within one step, and no error would tell. So a step may be no longer than
//
//   (max(gap, 0) + w/2) / closing speed      w the smaller half width, gap and speed of the balls around both shapes
//
// Everything here is a function of states alone, made of exactly rounded operations and cbrt.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "sim/contact/contact_side.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// What the control carries from step to step.
struct StepChoice {
  double next = 0.0;   // length of the next step [s]
  double speed = 0.0;  // V [m/s]
  double shift = 0.0;  // where steps are given: by how much the nodes that move lie later here [s]
};

class StepControl {
 public:
  StepControl(const Tree& tree, const std::vector<ContactPair>& contacts);

  double length() const { return length_; }  // r [m]

  struct Slopes {
    const Eigen::Ref<const Eigen::VectorXd> v, vdot;
  };
  double CalcError(double h, double tolerance, double speed, const Slopes& start, const Slopes& stage,
                   const Slopes& end) const;

  // V after a step of length h to rates v.
  double CalcSpeed(double previous, double h, const Eigen::Ref<const Eigen::VectorXd>& v) const;

  // By which the next step differs from one with this error.
  static double CalcFactor(double error);

  // The longest step from these kinematics; infinite where nothing approaches.
  double CalcLongestStep(const std::vector<BodyKinematics>& kinematics) const;

 private:
  struct Joint {
    int start = 0;
    int size = 0;
    bool turns = false;
  };
  struct Ball {
    std::optional<FieldPlane> plane;                   // of a half-space
    bool round = false;                                // turning moves no point of its surface
    Eigen::Vector3d center = Eigen::Vector3d::Zero();  // in the body [m]
    double radius = 0.0;
    double half_width = 0.0;
  };
  struct Pair {
    int body[2] = {0, 0};
    Ball ball[2];
  };
  static Ball Enclose(const ContactGeometry& shape);

  std::vector<Joint> joints_;
  std::vector<Pair> pairs_;
  double length_ = 0.0;
};

}  // namespace knap
