// All contacts of a scene: spheres on one body against a plane or a mesh on another, as wrenches with derivatives.
//
// The surface's body must be fixed or prescribed; only the sphere's body then feels the wrench as an unknown. The
// contact is evaluated in the surface body's frame S, where its mesh is constant:
//
//   c = X_SW p_WC,  u = velocity of the sphere's centre relative to S,  w = relative angular velocity     (all in S)
//
// and the force law (contact_law.h) is summed over the triangles that the sphere reaches, in the order of their
// numbers. The wrench on the sphere's body B, its derivatives in the perturbation (eta, dV) of B, and the cotangents of
// the mesh's vertices follow by the chain rule.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/contact/sphere_triangle.h"
#include "sim/geometry/triangle_bvh.h"
#include "sim/geometry/triangle_mesh.h"
#include "sim/multibody/dynamics.h"

namespace knap {

// A triangle mesh prepared for contact, in its body's frame. Immutable.
class ContactMesh {
 public:
  explicit ContactMesh(const TriangleMesh& mesh);
  const std::vector<TriangleFrame>& frames() const { return frames_; }
  const std::vector<Eigen::Vector3i>& triangles() const { return triangles_; }
  int vertex_count() const { return vertex_count_; }
  const TriangleBvh& bvh() const { return *bvh_; }

 private:
  std::vector<TriangleFrame> frames_;
  std::vector<Eigen::Vector3i> triangles_;
  int vertex_count_ = 0;
  std::unique_ptr<TriangleBvh> bvh_;
};

struct SphereContact {
  int sphere_body = -1;                                 // index in the tree
  Eigen::Vector3d p_BC = Eigen::Vector3d::Zero();       // the sphere's centre in its body's frame [m]
  double radius = 0.0;                                  // [m]
  int surface_body = -1;
  std::shared_ptr<const ContactMesh> mesh;              // null: the half-space below z = 0 of the surface's body
  ContactMaterial material;
};

// What one contact did at the last evaluation, for onset counts, reports and tests.
struct ContactReport {
  bool active = false;
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  // on the sphere, at its centre [N]
  Eigen::Vector3d m_W = Eigen::Vector3d::Zero();  // about its centre [N m]
};

class ContactModel {
 public:
  explicit ContactModel(std::vector<SphereContact> contacts);

  const std::vector<SphereContact>& contacts() const { return contacts_; }

  // Adds every contact's wrench, and its derivatives when wanted, to dynamics->external().
  void AddWrenches(Dynamics* dynamics, bool want_jacobian);

  const std::vector<ContactReport>& reports() const { return reports_; }

  // Adds to bar_vertices[contact] (3 × vertices of its mesh) the cotangents under Σ_i bar_wrench[i] · F_i, the wrenches
  // of the last AddWrenches at the same kinematics.
  void PullBackVertices(const Dynamics& dynamics, const std::vector<Vector6d>& bar_wrench,
                        std::vector<Eigen::Matrix3Xd>* bar_vertices);

 private:
  // The sphere as the surface's body sees it.
  struct RelativeMotion {
    Eigen::Matrix3d R_SB;
    Eigen::Vector3d c;
    Eigen::Vector3d u;
    Eigen::Vector3d w;
    Eigen::Vector3d v_C_B;  // velocity of the centre in the world, expressed in B
  };
  RelativeMotion CalcRelativeMotion(const Dynamics& dynamics, const SphereContact& contact) const;
  const std::vector<int>& FindCandidates(int index, const Eigen::Vector3d& c);

  // Triangles near a sphere: valid while the sphere stays within `box`. A cache that changes no result, because a
  // triangle out of reach contributes nothing.
  struct Candidates {
    Eigen::AlignedBox3d box;
    std::vector<int> triangles;
  };

  std::vector<SphereContact> contacts_;
  std::vector<ContactReport> reports_;
  std::vector<Candidates> candidates_;
};

}  // namespace knap
