// The elastic wrench of one pair at one pose, over all of its sides and patches.
#pragma once

#include "sim/contact/contact_side.h"

namespace knap::test {

struct Wrench {
  Eigen::Vector3d F = Eigen::Vector3d::Zero();
  Eigen::Vector3d M = Eigen::Vector3d::Zero();
};

// On the first body about the second's origin, in the second's frame.
inline Wrench CalcWrench(const ContactGeometry& a, const ContactGeometry& b, const Pose& X_BA) {
  ContactPair pair;
  pair.bodies = {0, 1};
  pair.shapes = {a, b};
  pair.material.stiffness = 1e9;
  Wrench out;
  for (const ContactSide& side : MakeSides({pair})) {
    NearFacets near(side);
    const bool first = side.body == 0;
    const Pose X_SB = first ? X_BA : Pose{X_BA.R.transpose(), -(X_BA.R.transpose() * X_BA.p)};
    SidePatches at;
    CalcPatches(side, &near, X_SB, &at);
    for (const PatchIntegrals& p : at.patches) {
      const Eigen::Vector3d F = first ? p.F : Eigen::Vector3d(-(X_BA.R * p.F));
      out.F += F;
      out.M += first ? p.M : Eigen::Vector3d(-(X_BA.R * p.M) + X_BA.p.cross(F));
    }
  }
  return out;
}

}  // namespace knap::test
