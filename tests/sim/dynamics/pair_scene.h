// Free, fixed and prescribed bodies with shapes, and runs of them, for tests of contact between any two shapes.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <utility>
#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/simulate.h"
#include "tests/sim/dynamics/scenes.h"

namespace knap::test {

inline constexpr double kGravity = 9.81;  // [m/s²]

inline BoxGeometry MakeBox(const Eigen::Vector3d& size) { return {0.5 * size, Eigen::Vector3d::Zero()}; }

inline MeshGeometry MakeMesh(const TriangleMesh& mesh) { return {std::make_shared<ContactMesh>(mesh)}; }

class PairScene {
 public:
  Tree tree;
  std::vector<ContactPair> contacts;
  std::vector<double> q, v;

  Eigen::VectorXd q0() const { return Eigen::Map<const Eigen::VectorXd>(q.data(), q.size()); }
  Eigen::VectorXd v0() const { return Eigen::Map<const Eigen::VectorXd>(v.data(), v.size()); }

  int AddFixed(const Pose& X_WB = {}) {
    TreeBody body;
    body.X_PF = X_WB;
    return tree.AddBody(body);
  }
  int AddPrescribed(PrescribedMotion motion) {
    TreeBody body;
    body.joint = JointType::kPrescribed;
    body.motion = std::move(motion);
    return tree.AddBody(body);
  }
  // `w` in the body's frame, `center` of mass likewise, moments about it.
  int AddFree(double mass, const Eigen::Vector3d& moments, const Eigen::Vector3d& p, const Eigen::Quaterniond& q_WB,
              const Eigen::Vector3d& velocity, const Eigen::Vector3d& w,
              const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
    TreeBody slide;
    slide.joint = JointType::kTranslation;
    TreeBody body;
    body.parent = tree.AddBody(slide);
    body.joint = JointType::kBall;
    body.M = MakeSpatialInertia(mass, center, moments.asDiagonal());
    q.insert(q.end(), {p.x(), p.y(), p.z(), q_WB.x(), q_WB.y(), q_WB.z(), q_WB.w()});
    v.insert(v.end(), {velocity.x(), velocity.y(), velocity.z(), w.x(), w.y(), w.z()});
    return tree.AddBody(body);
  }
  // A solid box.
  int AddFreeBox(const Eigen::Vector3d& size, double mass, const Eigen::Vector3d& p,
                 const Eigen::Quaterniond& q_WB = Eigen::Quaterniond::Identity(),
                 const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero(),
                 const Eigen::Vector3d& w = Eigen::Vector3d::Zero()) {
    const Eigen::Vector3d s2 = size.cwiseAbs2();
    const Eigen::Vector3d moments = mass / 12.0 * Eigen::Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y());
    return AddFree(mass, moments, p, q_WB, velocity, w);
  }
  void Touch(int a, ContactGeometry shape_a, int b, ContactGeometry shape_b, const ContactMaterial& material) {
    ContactPair pair;
    pair.bodies = {a, b};
    pair.shapes = {std::move(shape_a), std::move(shape_b)};
    pair.material = material;
    contacts.push_back(std::move(pair));
  }
};

}  // namespace knap::test
