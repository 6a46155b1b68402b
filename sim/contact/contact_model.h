// All contacts of a scene: pairs of shapes on two bodies, as wrenches with derivatives; and its grips (grip.h).
//
// Each pair becomes one or two sides (point_side.h), points of one body against the surface of the other:
//
//   sphere against half-space or mesh      the exact integral over the surface, modulus E         (sphere_triangle.h)
//   sphere against sphere, capsule, box    its centre against the other's core, inflated by both radii, E
//   box, capsule against half-space        corners, ends, E
//   mesh against half-space                the mesh's samples, E
//   box, capsule against mesh              E/2 on the shape's features against the triangles, E/2 on the mesh's samples
//   box against box                        E/2 on the surface points of each against the other
//   capsule against capsule, box           its balls against the other's core, inflated by both radii, E
//
// The rule behind the halves: each of two surfaces carries half of the elastic foundation, with area weights of its
// own. A refined mesh spreads its half over more samples of the same total area and leaves the features' half as it is.
//
// Between steps every point in contact keeps a bristle (contact_law.h), expressed in the frame of the surface's body.
// Either body may move; where both do, cross() of the dynamics couples them.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "sim/contact/grip.h"
#include "sim/contact/make_sides.h"
#include "sim/contact/pair_wrench.h"
#include "sim/contact/point_side.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// What one contact did at the last evaluation, for onset counts, reports and tests.
struct ContactReport {
  bool active = false;
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  // on the first body [N]
  Eigen::Vector3d m_W = Eigen::Vector3d::Zero();  // about the first body's origin [N m]
};

using Bristle = Eigen::Vector3d;

// The bristles that are bent, by ascending number of their point.
struct Bristles {
  std::vector<int> id;
  std::vector<Eigen::Vector3d> z;  // [m]
  void Clear() {
    id.clear();
    z.clear();
  }
  int size() const { return static_cast<int>(id.size()); }
};

class ContactModel {
 public:
  // Throws as MakeSides does.
  explicit ContactModel(std::vector<ContactPair> contacts, std::vector<GripSpring> grips = {});

  const std::vector<ContactPair>& contacts() const { return contacts_; }
  const std::vector<GripSpring>& grips() const { return grips_; }
  bool has_bristles() const { return has_bristles_; }

  // The step that following evaluations belong to: its length and the bristles at its start.
  void BeginStep(double h, const Bristles& previous);

  // Adds the wrench of every contact, and of every grip that acts at the dynamics' time, to dynamics->external().
  void AddWrenches(Dynamics* dynamics);
  // Adds the derivatives of the wrenches added last to dynamics->external() and cross().
  void AddDerivatives(ContactDerivatives derivatives, Dynamics* dynamics);

  // Of the last AddWrenches.
  const std::vector<ContactReport>& reports() const { return reports_; }
  const Bristles& bristles() const { return bristles_; }

  // Cotangents, all added: of bodies' perturbations, of the bristles at the step's start (one each), of meshes, and of
  // the points of grips.
  struct Cotangents {
    std::vector<BodyCotangent> bodies;
    std::vector<Eigen::Vector3d> previous;
    std::vector<Eigen::Matrix3Xd> vertices;  // for each contact: of its mesh's, empty without a mesh
    std::vector<GripCotangent> grips;
  };
  Cotangents MakeCotangents(int num_bodies) const;

  // The three of one step, in this order, after AddDerivatives.
  // Under Σ bar_bristles · bristles(): bodies and previous; vertices are left to PullBackWrenches.
  void PullBackBristles(const std::vector<Eigen::Vector3d>& bar_bristles, Cotangents* out);
  // Under Σ_i bar_wrench[i] · F_i: previous, vertices and grips (the bodies' part is in the dynamics' own pull-back).
  void PullBackWrenches(const std::vector<Vector6d>& bar_wrench, const Dynamics& dynamics, Cotangents* out);
  // Samples' cotangents are gathered over all steps, and at the end passed on to the vertices.
  void FinishVertices(Cotangents* out);

 private:
  struct SampleCotangents {
    Eigen::Matrix3Xd positions;
    Eigen::VectorXd areas;
  };
  // One point in contact.
  struct Touch {
    int point = 0;
    int previous = -1;           // its bristle among those at the step's start
    Eigen::Vector3d c, a, u, z;  // z: that bristle
    ElasticPoint elastic;
    MeshIntegrals integrals;
    PointForce force;
    PointForceJacobian jacobian;
    ElasticCotangent bar;
  };
  // The touches of one side, and what they add up to.
  struct Patch {
    int begin = 0;
    int end = 0;
    PairWrench wrench;
  };
  void AddSide(int s, Dynamics* dynamics);
  bool Rolls(const PointSide& side) const;
  // One touch's cotangents: under bar_F · (wrench on B about So) + bar_bristle · bristle. bar_e and bar_nu may be null.
  void PullBackTouch(int s, const Vector6d& bar_F, const Eigen::Vector3d& bar_bristle, Touch* touch, Vector6d* bar_e,
                     Vector6d* bar_nu, Cotangents* out);

  std::vector<ContactPair> contacts_;
  std::vector<GripSpring> grips_;
  std::vector<PointSide> sides_;
  std::vector<NearPoints> near_;
  std::vector<SampleCotangents> bar_samples_;  // of a side with samples
  std::vector<ContactReport> reports_;
  bool has_bristles_ = false;
  double h_ = 0.0;
  Bristles previous_;
  // Of the last AddWrenches.
  std::vector<Touch> touches_;
  int num_touches_ = 0;         // the vector never shrinks
  std::vector<Patch> patches_;  // of each side
  Bristles bristles_;
};

}  // namespace knap
