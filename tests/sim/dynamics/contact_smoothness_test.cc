// The wrench is C¹ along any line of the sphere's centre over a bent mesh: across faces, concave creases, convex edges,
// vertices, and onset. A jump J of the slope shows in second differences as J/δ, of the value as J/δ²: both grow
// without bound as the sweep is refined; those of a C¹ function with bounded curvature do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/sim/dynamics/scenes.h"

namespace knap {
namespace contact_smoothness_test {

using Eigen::Vector3d;
using test::BallScene;

class Probe {
 public:
  Probe(const TriangleMesh& mesh, const ContactMaterial& material) : mesh_(std::make_shared<ContactMesh>(mesh)) {
    scene_.AddGround({});
    scene_.AddBall();
    scene_.Touch(scene_.ground, material, mesh_);
    scene_.Start(Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero());
    dynamics_ = std::make_unique<Dynamics>(scene_.tree);
    contacts_ = std::make_unique<ContactModel>(scene_.contacts);
  }
  // Force and moment over the radius [N].
  Vector6d At(const Vector3d& c, const Vector3d& v, const Vector3d& w) {
    scene_.q0.head<3>() = c;
    scene_.v0.head<3>() = v;
    scene_.v0.tail<3>() = w;
    dynamics_->CalcKinematics(scene_.q0, scene_.v0, Eigen::VectorXd::Zero(6), 0.0);
    contacts_->AddWrenches(dynamics_.get());
    Vector6d wrench;
    wrench << contacts_->reports()[0].f_W, contacts_->reports()[0].m_W / scene_.radius;
    return wrench;
  }

 private:
  std::shared_ptr<const ContactMesh> mesh_;
  BallScene scene_;
  std::unique_ptr<Dynamics> dynamics_;
  std::unique_ptr<ContactModel> contacts_;
};

// A bar whose front has a concave crease at x = 0 and convex ones at x = ±8 mm, 20° each.
TriangleMesh MakeBentBar() {
  TriangleMesh mesh = test::MakeBar(0.024, 0.012, 0.02, 12, 5);
  for (Vector3d& v : mesh.vertices) {
    const double x = std::abs(v.x());
    v.y() += 0.36 * std::min(x, 0.008) - 0.36 * std::max(0.0, x - 0.016);
  }
  return mesh;
}

struct Line {
  const char* name;
  Vector3d from;
  Vector3d to;
};

class LineTest : public testing::TestWithParam<Line> {};

TEST_P(LineTest, WrenchIsContinuousWithItsSlope) {
  Probe probe(MakeBentBar(), {1.3e8, 2.0, 0.4, 0.03, 1e-2});
  const Vector3d v(0.03, -0.01, 0.02);
  const Vector3d w(2.0, -1.0, 3.0);
  const Line& line = GetParam();
  const double length = (line.to - line.from).norm();
  double coarse = 0.0;
  double force = 0.0;
  for (const int n : {1000, 4000, 16000}) {
    const double step = length / n;
    const auto at = [&](int i) { return probe.At(line.from + (line.to - line.from) * i / n, v, w); };
    Vector6d before = at(0);
    Vector6d here = at(1);
    double worst = 0.0;
    for (int i = 2; i <= n; ++i) {
      const Vector6d next = at(i);
      worst = std::max(worst, (next - 2.0 * here + before).norm() / (step * step));
      force = std::max(force, here.head<3>().norm());
      before = here;
      here = next;
    }
    if (n == 1000) coarse = worst;
    // A jump of the slope by even 1% of its greatest value would grow fourfold at each refinement. Curvature itself
    // peaks over lengths of the triangles' overlap, which the coarsest sweep may miss by some.
    EXPECT_LT(worst, 2.0 * coarse) << n;
  }
  EXPECT_GT(force, 0.02);
}

// The face of the middle part is at y = 0 … 2.88 mm; the ball reaches in by about 0.1 to 0.3 mm.
INSTANTIATE_TEST_SUITE_P(
    Lines, LineTest,
    testing::Values(Line{"AcrossConcaveCrease", {-0.004, 0.0104, 0.0103}, {0.0037, 0.0104, 0.0091}},
                    Line{"AcrossConvexCrease", {0.004, 0.0122, 0.0103}, {0.02, 0.0126, 0.0111}},
                    Line{"OffTheEnd", {0.021, 0.0112, 0.0103}, {0.036, 0.005, 0.0111}},
                    Line{"OverTheTop", {0.0123, 0.0125, 0.012}, {0.0121, 0.0085, 0.029}},
                    Line{"Onset", {0.0123, 0.0132, 0.0093}, {0.0121, 0.0125, 0.0091}}),
    [](const auto& line) { return std::string(line.param.name); });

}  // namespace contact_smoothness_test
}  // namespace knap
