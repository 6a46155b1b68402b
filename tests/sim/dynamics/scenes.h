// Small scenes that several tests share, built without YAML.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <utility>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/simulate.h"
#include "sim/multibody/tree.h"

namespace knap::test {

// A ball on a half-space (the body "ground", whose pose may be tilted or moving) and, if given, before a mesh.
struct BallScene {
  Tree tree;
  int ground = -1;
  int tool = -1;
  int ball = -1;
  double mass = 0.0042;
  double radius = 0.01;
  std::vector<ContactPair> contacts;
  Eigen::VectorXd q0;
  Eigen::VectorXd v0;

  double inertia() const { return 0.4 * mass * radius * radius; }

  // ball: translation then ball joint, as a free body.
  void AddBall() {
    TreeBody slide;
    slide.name = "ball translation";
    slide.joint = JointType::kTranslation;
    const int parent = tree.AddBody(slide);
    TreeBody body;
    body.name = "ball";
    body.parent = parent;
    body.joint = JointType::kBall;
    body.M = MakeSpatialInertia(mass, Eigen::Vector3d::Zero(), inertia() * Eigen::Matrix3d::Identity());
    ball = tree.AddBody(body);
  }
  void AddGround(const Pose& X_WG) {
    TreeBody body;
    body.name = "ground";
    body.X_PF = X_WG;
    ground = tree.AddBody(body);
  }
  void AddTool(PrescribedMotion motion) {
    TreeBody body;
    body.name = "tool";
    body.joint = JointType::kPrescribed;
    body.motion = std::move(motion);
    tool = tree.AddBody(body);
  }
  void Touch(int surface, const ContactMaterial& material, std::shared_ptr<const ContactMesh> mesh = nullptr) {
    ContactPair pair;
    pair.bodies = {ball, surface};
    pair.shapes[0] = SphereGeometry{radius, Eigen::Vector3d::Zero()};
    if (mesh) pair.shapes[1] = MeshGeometry{std::move(mesh)};
    pair.material = material;
    contacts.push_back(std::move(pair));
  }
  void Start(const Eigen::Vector3d& p, const Eigen::Vector3d& velocity, const Eigen::Vector3d& w) {
    q0 = tree.MakeDefaultPositions();
    v0 = Eigen::VectorXd::Zero(tree.nv());
    const int slide = tree.bodies()[ball].parent;
    q0.segment<3>(tree.bodies()[slide].q_start) = p;
    v0.segment<3>(tree.bodies()[slide].v_start) = velocity;
    v0.segment<3>(tree.bodies()[ball].v_start) = w;
  }
};

// A box [−a, a] × [−b, 0] × [0, c] whose front face y = 0 has nx × nz cells; closed and outward.
TriangleMesh MakeBar(double a, double b, double c, int nx, int nz);

// The same bar lying flat as a floor: its fine face is the plane z = 0 of the world, centred at the origin.
Pose MakeFloorPose(double c);

// The ball at one state, all in the world; f on it at its centre and m about it, summed over its contacts.
struct BallSample {
  double time = 0.0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d f = Eigen::Vector3d::Zero();
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
};

// Whole steps that fill `duration`, a tolerance near rounding.
SimulationOptions MakeOptions(double step, double duration, int order);

// All states of a run, the start included. Throws when a step fails or had to be cut.
std::vector<BallSample> RunBall(const BallScene& scene, const SimulationOptions& options);

// Height of a resting ball's centre: E π r d² … solved from the half-space's closed form by bisection.
double FindRestingHeight(const BallScene& scene, const ContactMaterial& material, double g);

}  // namespace knap::test
