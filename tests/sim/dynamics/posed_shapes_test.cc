// A shape with a pose in its body does what the same shape does at the origin of a body that is fixed there.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sim/contact/convex_field.h"
#include "sim/math/so3.h"
#include "tests/sim/contact/convex_meshes.h"
#include "tests/sim/contact/designed_meshes.h"
#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace posed_shapes_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::PairScene;

constexpr int kKinds = 7;
const char* const kNames[kKinds] = {"Sphere", "Capsule", "Cylinder", "Box", "Hull", "Mesh", "HalfSpace"};

TriangleMesh Move(const Pose& X, TriangleMesh mesh) {
  for (Vector3d& v : mesh.vertices) v = X * v;
  return mesh;
}

ContactGeometry MakeShape(int kind, const Pose& X) {
  switch (kind) {
    case 0:
      return SphereGeometry{0.008, X.p};
    case 1:
      return CapsuleGeometry{0.006, 0.012, X.p, X.R.col(2)};
    case 2:
      return CylinderGeometry{0.007, 0.009, X.p, X.R.col(2)};
    case 3:
      return BoxGeometry{Vector3d(0.012, 0.008, 0.006), X.p, X.R};
    case 4:
      return *MakeConvexMesh(Move(X, test::MakePyramid()));
    case 5:
      return test::MakeDesigned(Move(X, test::MakeWedge()));
    default:
      return HalfSpaceGeometry{{X.R.col(2), X.R.col(2).dot(X.p)}};
  }
}

// A prism that stands for a cylinder begins at some angle, which a pose may change.
bool HasPrism(int a, int b) { return (a == 2 && b <= 2) || (b == 2 && a <= 2); }

struct Flight {
  VectorXd q;
  double depth = 0.0;
};

// A body whose shape `a` lies at X_BG flies at shape `b`, which lies at X_FS of a body that turns.
Flight Throw(int a, int b, const Pose& X_BG, const Pose& X_FS, bool in_shape) {
  PairScene s;
  s.tree.gravity.setZero();
  const int still = b == 6;
  const Quaterniond turn = ExpSo3(Vector3d(0.3, -0.2, 0.4));
  // Where the shapes' own frames begin: one above the other, already in touch.
  const Pose X_WS{turn.toRotationMatrix(), Vector3d(0.01, 0.02, 0.03)};
  const double reach[kKinds] = {0.008, 0.006, 0.009, 0.006, 0.003, 0.004, 0.0};
  const Pose X_SG{ExpSo3(Vector3d(0.05, 0.08, 0.2)).toRotationMatrix(), Vector3d(0.001, -0.0015,
                                                                                 reach[a] +
                                                                                     (b == 4   ? 0.009
                                                                                      : b == 5 ? 0.006
                                                                                      : b == 1 ? 0.018
                                                                                               : reach[b]) -
                                                                                     0.0008 + (a == 1 ? 0.012 : 0.0))};
  const auto invert = [](const Pose& X) { return Pose{X.R.transpose(), -(X.R.transpose() * X.p)}; };
  const Pose X_WB = X_WS * X_SG * invert(X_BG);
  const Pose X_WF = X_WS * invert(X_FS);
  const auto add = [&](const Pose& X, const Vector3d& w) {
    return s.AddFree(0.02, Vector3d(2e-6, 3e-6, 2.5e-6), X.p, Quaterniond(X.R), Vector3d(0.02, 0.03, 0.0), w);
  };
  int body = add(X_WB, Vector3d(1.0, -2.0, 0.5));
  int other = still != 0 ? s.AddFixed(X_WF) : add(X_WF, Vector3d(-0.5, 1.0, 0.3));
  const auto fix = [&](int parent, const Pose& X) {
    TreeBody child;
    child.parent = parent;
    child.X_PF = X;
    return s.tree.AddBody(child);
  };
  if (!in_shape) {
    body = fix(body, X_BG);
    other = fix(other, X_FS);
  }
  s.Touch(body, MakeShape(a, in_shape ? X_BG : Pose{}), other, MakeShape(b, in_shape ? X_FS : Pose{}),
          {2e7, 1.0, 0.4, 0.02, 1e-3, 2e-5});
  Dynamics dynamics(s.tree);
  ContactModel contacts(s.contacts);
  SimulationOptions options;
  options.step = 5e-4;
  options.steps = 40;
  options.newton_tolerance = 1e-13;
  options.newton_max_iterations = 60;
  const Trajectory t = Simulator(&dynamics, &contacts).Run(s.q0(), s.v0(), options);
  EXPECT_TRUE(t.certificate.converged);
  return {t.q(t.size() - 1), t.certificate.penetration};
}

TEST(PosedShapes, TouchAsBodiesThatArePosed) {
  const Pose X_BG{ExpSo3(Vector3d(0.7, -0.4, 1.1)).toRotationMatrix(), Vector3d(0.004, -0.006, 0.009)};
  const Pose X_FS{ExpSo3(Vector3d(-0.9, 0.5, 0.3)).toRotationMatrix(), Vector3d(-0.007, 0.003, 0.005)};
  for (int a = 0; a < kKinds - 1; ++a) {
    for (int b = 0; b < kKinds; ++b) {
      if (HasPrism(a, b)) continue;
      SCOPED_TRACE(std::string(kNames[a]) + " and " + kNames[b]);
      const Flight posed = Throw(a, b, X_BG, X_FS, true);
      const Flight held = Throw(a, b, X_BG, X_FS, false);
      EXPECT_GT(posed.depth, 1e-3);
      // How thin a mesh without a field is, is read off its box along the axes of its body.
      if (a != 5 && b != 5) {
        EXPECT_NEAR(posed.depth, held.depth, 1e-7 * held.depth);
      }
      // Newton's tolerance over 40 steps of bodies that turn by some 0.1 rad.
      EXPECT_LE((posed.q - held.q).cwiseAbs().maxCoeff(), 1e-8);
    }
  }
}

}  // namespace posed_shapes_test
}  // namespace knap
