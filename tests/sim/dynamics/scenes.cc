#include "tests/sim/dynamics/scenes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace knap::test {

TriangleMesh MakeBar(double a, double b, double c, int nx, int nz) {
  TriangleMesh mesh;
  // Two sheets, y = 0 and y = −b, joined along their rims.
  for (const double y : {0.0, -b}) {
    for (int k = 0; k <= nz; ++k) {
      for (int i = 0; i <= nx; ++i) mesh.vertices.emplace_back(-a + 2.0 * a * i / nx, y, c * k / nz);
    }
  }
  const int sheet = (nx + 1) * (nz + 1);
  const auto front = [&](int i, int k) { return k * (nx + 1) + i; };
  const auto quad = [&](int p, int q, int r, int s) {
    mesh.triangles.emplace_back(p, q, r);
    mesh.triangles.emplace_back(p, r, s);
  };
  for (int k = 0; k < nz; ++k) {
    for (int i = 0; i < nx; ++i) {
      quad(front(i, k), front(i, k + 1), front(i + 1, k + 1), front(i + 1, k));
      quad(sheet + front(i, k), sheet + front(i + 1, k), sheet + front(i + 1, k + 1), sheet + front(i, k + 1));
    }
  }
  for (int i = 0; i < nx; ++i) {
    quad(front(i, 0), front(i + 1, 0), sheet + front(i + 1, 0), sheet + front(i, 0));
    quad(front(i, nz), sheet + front(i, nz), sheet + front(i + 1, nz), front(i + 1, nz));
  }
  for (int k = 0; k < nz; ++k) {
    quad(front(0, k), sheet + front(0, k), sheet + front(0, k + 1), front(0, k + 1));
    quad(front(nx, k), front(nx, k + 1), sheet + front(nx, k + 1), sheet + front(nx, k));
  }
  return mesh;
}

Pose MakeFloorPose(double c) {
  Pose X_WG;
  X_WG.R = Eigen::AngleAxisd(0.5 * std::acos(-1.0), Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WG.p.y() = 0.5 * c;
  return X_WG;
}

SimulationOptions MakeOptions(double step, double duration, int order) {
  SimulationOptions options;
  options.step = step;
  options.steps = static_cast<int>(std::lround(duration / step));
  options.order = order;
  options.newton_tolerance = 1e-11;
  return options;
}

std::vector<BallSample> RunBall(const BallScene& scene, const SimulationOptions& options) {
  Dynamics dynamics(scene.tree);
  ContactModel contacts(scene.contacts);
  Simulator simulator(&dynamics, &contacts);
  std::vector<BallSample> samples;
  const auto record = [&](double time) {
    const BodyKinematics& k = dynamics.kinematics()[scene.ball];
    BallSample sample{time, k.X_WB.p, k.X_WB.R * k.V.tail<3>(), k.X_WB.R * k.V.head<3>(), k.X_WB.R};
    for (const ContactReport& report : contacts.reports()) {
      sample.f += report.f_W;
      sample.m += report.m_W;
    }
    samples.push_back(sample);
  };
  simulator.observer = record;
  const Trajectory trajectory = simulator.Run(scene.q0, scene.v0, options);
  if (!trajectory.certificate.converged) throw std::runtime_error("a step of the ball's run failed");
  if (trajectory.certificate.subdivided_steps > 0) throw std::runtime_error("a step of the ball's run was cut");
  return samples;
}

double FindRestingHeight(const BallScene& scene, const ContactMaterial& material, double g) {
  // The volume below a half-space's plane, π d² (r − d/3); on a face of a mesh the ball's depth over the disc,
  // π (r² − h²)²/(4 r).
  const double r = scene.radius;
  const auto is_half_space = [](const ContactPair& contact) {
    return std::holds_alternative<HalfSpaceGeometry>(contact.shapes[0]) ||
           std::holds_alternative<HalfSpaceGeometry>(contact.shapes[1]);
  };
  const bool on_plane = std::any_of(scene.contacts.begin(), scene.contacts.end(), is_half_space);
  double low = 0.9 * r;
  double high = r;
  for (int i = 0; i < 200; ++i) {
    const double h = 0.5 * (low + high);
    const double d = r - h;
    const double volume = on_plane ? d * d * (r - d / 3.0) : std::pow(r * r - h * h, 2) / (4.0 * r);
    const double N = material.stiffness * std::acos(-1.0) * volume;
    (N > scene.mass * g ? low : high) = h;
  }
  return 0.5 * (low + high);
}

}  // namespace knap::test
