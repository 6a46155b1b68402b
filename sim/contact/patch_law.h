// From what is elastic in a patch of contact to the whole wrench: damping, friction, rolling resistance.
//
// All in the field's frame S. F, M elastic; N = |F|, n = F/N, c = m1/W, Q = m2/W − c cᵀ; (w, v0) the twist of the
// touching body B relative to S about So, u = v0 + w × c, and k the lever of a twist about n:
//
//   D = ramp(1 − d n·u)            Hunt-Crossley damping, never adhesive [Hunt & Crossley 1975]
//   rocking    −D N d J w/√(1 + d² w·J w)                    J = mean of (r × n)(r × n)ᵀ, r = x − c
//   slip       s = ((I − n nᵀ) u, k w·n)                     k = (2√2/3) √tr Q: a disc's bound of torsion is 2/3 μ N R
//   bristle    z: bristle.h, of bound z_s;  tau = −μ z/z_s
//   or without tau = −μ s/√(|s|² + v_s²)                     stick_distance z_s = 0: slip_speed v_s alone counts
//   friction   force D N tau_123 at c, moment D N k tau_4 n
//   rolling    −c_r r D N w_t/√(|w_t|² + (v_s/r)²)           w_t = (I − n nᵀ) w, r of a round body
//
// Force and torsion together lie in one cone |(f, m/k)| ≤ μ D N; slip and spin at once are off by 0.12 μ N at most
// against a pressure's own integral. One law a patch and not a point: summed over points with normals of their own, it
// would brake a frictionless bar on ridges, and give 1.41 μ N in a groove of 45°.
//
// A bristle is carried from step to step in S. It fades out where N falls below N_light, so that letting go of a
// surface and touching it again is smooth.
#pragma once

#include <Eigen/Core>

#include "sim/contact/bristle.h"
#include "sim/contact/patch_integrals.h"
#include "sim/math/pose.h"

namespace knap {

struct ContactMaterial {
  double stiffness = 0.0;           // E, pressure per depth [N/m³]
  double damping = 0.0;             // d [s/m]
  double friction = 0.0;            // mu [-]
  double rolling_resistance = 0.0;  // c_r, resisting moment over r N [-]
  double slip_speed = 1e-3;         // v_s, where regularised friction reaches 1/√2 of its bound [m/s]
  double stick_distance = 0.0;      // z_s [m]; 0: regularised friction
};

struct PatchLawInput {
  const ContactMaterial* material = nullptr;
  double rolling_radius = 0.0;  // 0: no rolling resistance
  double N_light = 1.0;         // > 0 [N]
  double h = 0.0;               // of the implicit step [s]
  Bristle bristle = Bristle::Zero();
  Vector6d nu = Vector6d::Zero();
};

class PatchLaw {
 public:
  // `patch` is active; false where its forces cancel, and nothing acts.
  bool Evaluate(const PatchIntegrals& patch, const PatchLawInput& input);

  const Vector6d& wrench() const { return wrench_; }    // on B, about So
  const Bristle& bristle() const { return bristle_; }   // for the next step; zero under regularised friction
  const Eigen::Vector3d& center() const { return c_; }  // c

  // Cotangents under bar_wrench · wrench() + bar_bristle · bristle() of the last Evaluate; added.
  void PullBack(const Vector6d& bar_wrench, const Bristle& bar_bristle, PatchCotangent* bar_patch, Vector6d* bar_nu,
                Bristle* bar_previous) const;

 private:
  const PatchIntegrals* patch_ = nullptr;
  PatchLawInput in_;
  Vector6d wrench_ = Vector6d::Zero();
  Bristle bristle_ = Bristle::Zero();
  // As named in the header.
  double N_ = 0.0, D_ = 0.0, dD_ = 0.0, k_ = 0.0, w_n_ = 0.0, u_n_ = 0.0;
  double rocking_root_ = 1.0;
  double slow_ = 1.0;  // √(|s|² + v_s²)
  double rolling_root_ = 1.0;
  double fade_ = 0.0, dfade_ = 0.0;
  Eigen::Vector3d n_, c_, u_, s_t_, p_, Qp_, rock_, w_t_, roll_;
  Eigen::Matrix3d Q_;
  Bristle s_, tau_, base_;
  BristleStep step_;
};

}  // namespace knap
