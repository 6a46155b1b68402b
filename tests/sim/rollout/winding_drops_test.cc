// Ropes let go around spools of any shape that configs/winding.yaml allows, gravity from anywhere: no link passes
// through the spool, and energy never grows.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "sim/scenarios/apply_variation.h"
#include "tests/sim/rollout/winding_scene.h"

namespace knap {
namespace winding_drops_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Section of the spool at x: rectangles at the four stations, straight lines between them.
bool IsInSpool(const VectorXd& theta, const Vector3d& p) {
  constexpr std::array<double, 4> kStations{-0.045, -0.015, 0.015, 0.045};
  if (std::abs(p.x()) >= kStations.back()) return false;
  int s = 0;
  while (p.x() >= kStations[s + 1]) ++s;
  const double share = (p.x() - kStations[s]) / (kStations[s + 1] - kStations[s]);
  const auto side = [&](int k) { return theta(2 * s + k) + share * (theta(2 * s + 2 + k) - theta(2 * s + k)); };
  return 2.0 * std::abs(p.y()) < side(0) && 2.0 * std::abs(p.z()) < side(1);
}

struct Drop {
  VectorXd theta;
  Scene scene;
};

// The index alone says which spool and which direction.
Drop DrawDrop(const RolloutModel& rollout, int index) {
  std::mt19937_64 generator(index);
  const auto draw = [&](double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(generator);
  };
  Drop drop{rollout.initial_theta(), rollout.scene()};
  ApplyVariation(drop.scene, std::vector{draw(0.0, 2.0 * std::acos(-1.0)), draw(-1.0, 1.0)});
  const std::vector<DesignParameter>& parameters = rollout.scene().design->parameters;
  for (int i = 0; i < drop.theta.size(); ++i) drop.theta(i) = draw(parameters[i].lower, parameters[i].upper);
  return drop;
}

// Calls visit(time, dynamics) at the start and at every state of the trajectory.
template <class Visit>
SimulationCertificate RunDrop(const RolloutModel& rollout, const Drop& drop, double step, double duration, int order,
                              const Visit& visit) {
  const SceneModel model = test::Build(rollout, drop.scene, drop.theta);
  Dynamics dynamics(model.tree);
  ContactModel contacts(model.contacts);
  Simulator simulator(&dynamics, &contacts);
  SimulationOptions options;
  options.step = step;
  options.steps = static_cast<int>(std::lround(duration / step));
  options.order = order;
  dynamics.CalcKinematics(model.q0, model.v0, model.v0, 0.0);
  visit(model, dynamics);
  simulator.observer = [&](double) { visit(model, dynamics); };
  return simulator.Run(model.q0, model.v0, options).certificate;
}

// Points on the middle line of each link, 4 mm inside it, followed from state to state along straight lines: none ever
// is in the spool.
void ExpectNoLinkInSpool(int begin, int end, double duration) {
  constexpr int kPoints = 6, kBetween = 5;
  const RolloutModel rollout = test::LoadWinding({});
  double fastest = 0.0;
  for (int index = begin; index < end; ++index) {
    const Drop drop = DrawDrop(rollout, index);
    std::vector<Vector3d> before;
    int inside = 0;
    const auto visit = [&](const SceneModel& model, const Dynamics& dynamics) {
      std::vector<Vector3d> now;
      for (const int i : model.links.at("rope")) {
        const BodyKinematics& link = dynamics.kinematics()[i];
        for (int n = 0; n < kPoints; ++n) now.push_back(link.X_WB * Vector3d(0.03 * n / (kPoints - 1), 0.0, 0.0));
        fastest = std::max(fastest, link.V.tail<3>().norm());
      }
      if (before.empty()) before = now;
      for (std::size_t n = 0; n < now.size(); ++n) {
        for (int k = 1; k <= kBetween; ++k) {
          inside += IsInSpool(drop.theta, before[n] + (now[n] - before[n]) * k / kBetween);
        }
      }
      before = std::move(now);
    };
    EXPECT_TRUE(RunDrop(rollout, drop, 2e-3, duration, 2, visit).converged) << "drop " << index;
    EXPECT_EQ(inside, 0) << "drop " << index;
  }
  EXPECT_GT(fastest, 1.5);  // [m/s]: ropes do fall off
}

TEST(WindingDrops, NoLinkPassesThroughTheSpool) { ExpectNoLinkInSpool(0, 25, 0.6); }

// A few minutes: ctest -C slow -R thousand_rope_drops
TEST(WindingDrops, DISABLED_NoLinkPassesThroughTheSpoolInAThousand) { ExpectNoLinkInSpool(0, 1000, 1.0); }

// Kinetic energy and that of the links' weight. What the contacts store besides comes back to them within a bounce, so
// from one tenth of a second to the next the largest value must not rise.
TEST(WindingDrops, EnergyNeverGrows) {
  const RolloutModel rollout = test::LoadWinding({});
  for (const int order : {1, 2}) {
    for (int index = 0; index < 6; ++index) {
      std::vector<double> energies;
      const auto visit = [&](const SceneModel& model, const Dynamics& dynamics) {
        double energy = 0.0;
        for (const int i : model.links.at("rope")) {
          const Matrix6d& M = model.tree.bodies()[i].M;
          const BodyKinematics& link = dynamics.kinematics()[i];
          const Vector3d center = link.X_WB * Vector3d(0.015, 0.0, 0.0);
          energy += 0.5 * link.V.dot(M * link.V) - M(3, 3) * model.tree.gravity.dot(center);
        }
        energies.push_back(energy);
      };
      ASSERT_TRUE(RunDrop(rollout, DrawDrop(rollout, index), 2e-3, 0.5, order, visit).converged);
      const double scale = 15 * 0.0015 * 9.81 * 0.05;  // the rope's weight, lifted by the size of the spool [J]
      const std::size_t window = energies.size() / 5;
      double before = energies.front();
      for (std::size_t begin = 0; begin + window <= energies.size(); begin += window) {
        const double now = *std::max_element(energies.begin() + begin, energies.begin() + begin + window);
        EXPECT_LE(now, before + 1e-4 * scale) << "BDF" << order << ", drop " << index << ", state " << begin;
        before = now;
      }
    }
  }
}

}  // namespace winding_drops_test
}  // namespace knap
