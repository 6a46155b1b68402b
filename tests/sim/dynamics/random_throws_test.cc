// Nothing passes in silence: whatever is thrown at whatever, it ends outside with no more energy than it had, or the
// certificate names it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "tests/sim/contact/designed_meshes.h"
#include "tests/sim/dynamics/pair_scene.h"

namespace knap {
namespace random_throws_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::PairScene;

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }
  bool Flip() { return Uniform(0.0, 1.0) < 0.5; }
  Quaterniond Turn() {
    std::normal_distribution<double> normal;
    return Quaterniond(normal(generator_), normal(generator_), normal(generator_), normal(generator_)).normalized();
  }

 private:
  std::mt19937_64 generator_;
};

TriangleMesh MakeMeshBox(const Vector3d& half) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(), (i & 4 ? 1 : -1) * half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// A shape with what the test itself has to know of it.
struct Thing {
  std::string name;
  ContactGeometry shape;
  double reach = 0.0;       // radius of the ball around it [m]
  double volume = 0.0;      // [m³]
  Vector3d unit_moments{};  // of 1 kg, about its axes [m²]
  // How deep a point is inside; negative outside.
  std::function<double(const Vector3d&)> depth;
};

constexpr int kKinds = 5;

Thing MakeThing(int kind, Random* random) {
  const double size = random->LogUniform(1e-3, 50e-3);
  if (kind == 0) {
    const double r = 0.5 * size;
    return {"ball",
            SphereGeometry{r, Vector3d::Zero()},
            r,
            4.0 / 3.0 * std::numbers::pi * r * r * r,
            Vector3d::Constant(0.4 * r * r),
            [r](const Vector3d& x) { return r - x.norm(); }};
  }
  if (kind == 1) {
    const double r = 0.5 * size;
    const double half = r * random->Uniform(0.5, 4.0);
    const double across = (3.0 * r * r + 4.0 * half * half) / 12.0;
    return {"capsule",
            CapsuleGeometry{r, half, Vector3d::Zero()},
            r + half,
            std::numbers::pi * r * r * (2.0 * half + 4.0 / 3.0 * r),
            {across, across, 0.5 * r * r},
            [r, half](const Vector3d& x) {
              return r - Vector3d(x.x(), x.y(), x.z() - std::clamp(x.z(), -half, half)).norm();
            }};
  }
  if (kind == 2) {
    const double r = 0.5 * size;
    const double half = r * random->Uniform(0.1, 4.0);
    const double across = r * r / 4.0 + half * half / 3.0;
    return {"cylinder",
            CylinderGeometry{r, half},
            std::hypot(r, half),
            2.0 * std::numbers::pi * r * r * half,
            {across, across, 0.5 * r * r},
            [r, half](const Vector3d& x) { return std::min(r - x.head<2>().norm(), half - std::abs(x.z())); }};
  }
  const Vector3d half = 0.5 * size * Vector3d(1.0, random->Uniform(0.3, 1.0), random->Uniform(0.3, 1.0));
  const Vector3d s2 = 4.0 * half.cwiseAbs2();
  Thing box{"box",
            BoxGeometry{half, Vector3d::Zero()},
            half.norm(),
            8.0 * half.prod(),
            Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y()) / 12.0,
            [half](const Vector3d& x) { return (half - x.cwiseAbs()).minCoeff(); }};
  if (kind == 3) {
    box.name = "mesh";
    box.shape = test::MakeDesigned(MakeMeshBox(half));
  }
  return box;
}

struct Throw {
  std::string text;
  bool named = false;
  bool through = false;  // the thrown thing's middle was inside the target
  bool ends_outside = false;
  double gained = 0.0;  // energy, as a share of what it had
  bool sticks = false;
};

Throw ThrowOne(unsigned seed) {
  Random random(seed);
  const Thing thing = MakeThing(static_cast<int>(random.Uniform(0.0, kKinds)), &random);
  const Thing target = MakeThing(static_cast<int>(random.Uniform(0.0, kKinds)), &random);
  const double speed = random.LogUniform(0.05, 20.0);
  ContactMaterial material;
  material.stiffness = random.LogUniform(1e8, 1e10);
  material.damping = random.Flip() ? 0.0 : 10.0;
  material.friction = random.Flip() ? 0.0 : 0.4;
  material.stick_distance = random.Flip() ? 0.0 : 2e-5;

  PairScene scene;
  scene.tree.gravity.setZero();
  const Pose X_WT{random.Turn().toRotationMatrix(), Vector3d::Zero()};
  const int fixed = scene.AddFixed(X_WT);
  const double gap = random.Uniform(1e-4, 0.5) * (thing.reach + target.reach) + 1e-3;
  const double aside = 0.7 * (thing.reach + target.reach);
  const double mass = 1000.0 * thing.volume;
  const Vector3d start(-(thing.reach + target.reach + gap), random.Uniform(-aside, aside),
                       random.Uniform(-aside, aside));
  const Vector3d moments = mass * thing.unit_moments;
  const int body = scene.AddFree(
      mass, moments, start, random.Turn(), {speed, 0.0, 0.0},
      speed / thing.reach * Vector3d(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0)));
  scene.Touch(body, thing.shape, fixed, target.shape, material);

  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  Simulator simulator(&dynamics, &contacts);
  const double step = 4e-3;
  SimulationOptions options;
  options.step = step;
  options.tolerance = 1e-3;
  options.steps = std::clamp(static_cast<int>(std::ceil(3.0 * (-start.x() + thing.reach) / (speed * step))), 2, 2000);
  const Trajectory t = simulator.Run(scene.q0(), scene.v0(), options);
  const SimulationCertificate& certificate = t.certificate;

  Throw out;
  out.sticks = material.friction > 0.0 && material.stick_distance > 0.0;
  out.text = "seed " + std::to_string(seed) + ": " + thing.name + " at " + target.name + ", " + std::to_string(speed) +
             " m/s, sizes " + std::to_string(thing.reach) + " and " + std::to_string(target.reach) +
             " m, penetration " + std::to_string(certificate.penetration) + ", steps " +
             std::to_string(certificate.steps);
  out.named = !certificate.converged || certificate.passed_contact >= 0 || certificate.penetration > 0.5;
  const auto energy = [&](int k) {
    const Eigen::VectorXd v = t.v(k);
    return 0.5 * mass * v.head<3>().squaredNorm() + 0.5 * moments.dot(v.tail<3>().cwiseAbs2());
  };
  const double before = energy(0);
  out.gained = (energy(t.size() - 1) - before) / before;
  out.ends_outside = !(target.depth(X_WT.ApplyInverse(Vector3d(t.q(t.size() - 1).head<3>()))) > 0.0);
  for (int k = 0; k + 1 < t.size(); ++k) {
    const Vector3d a = t.q(k).head<3>();
    const Vector3d b = t.q(k + 1).head<3>();
    for (int i = 0; i < 64; ++i) {
      if (target.depth(X_WT.ApplyInverse(Vector3d(a + i / 64.0 * (b - a)))) > 0.0) out.through = true;
    }
  }
  return out;
}

TEST(RandomThrows, EndOutsideWithoutMoreEnergyOrAreNamed) {
  int named = 0;
  double most_gained = 0.0;
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    const Throw one = ThrowOne(seed);
    if (one.named) {
      ++named;
      continue;
    }
    EXPECT_FALSE(one.through) << one.text;
    EXPECT_TRUE(one.ends_outside) << one.text;
    // The steps' own error: a share of 1e-3 of the speed each, of which an impact takes some ten. A bristle is a spring
    // whose stiffness grows with the load: bent while the load grows it gains energy, 2% here at the worst and 9% with
    // the steps' error (docs/method.md).
    EXPECT_LE(one.gained, one.sticks ? 0.1 : 5e-3) << one.text;
    most_gained = std::max(most_gained, one.gained);
  }
  RecordProperty("named", named);
  RecordProperty("most_gained", std::to_string(most_gained));
  // Heavy things at high speed go through small ones, and are named; most bounce.
  EXPECT_LT(named, 1000);
}

}  // namespace random_throws_test
}  // namespace knap
