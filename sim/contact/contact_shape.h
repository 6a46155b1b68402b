// What bodies touch with, in the body's frame B.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <variant>

namespace knap {

class ContactMesh;
struct PolyhedralField;

struct HalfSpaceGeometry {};  // solid below z = 0

struct SphereGeometry {
  double radius = 0.0;  // [m]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// A cylinder along z of length 2·half_length with half a sphere on either end.
struct CapsuleGeometry {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// Along z, of length 2·half_length, with flat ends.
struct CylinderGeometry {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

struct BoxGeometry {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// A closed mesh whose vertices are given in B.
struct MeshGeometry {
  std::shared_ptr<const ContactMesh> mesh;
  bool is_designed = true;                                 // what its vertices do to a loss is asked for
  std::shared_ptr<const PolyhedralField> field = nullptr;  // of one that is convex and not designed, else null
};

using ContactGeometry =
    std::variant<HalfSpaceGeometry, SphereGeometry, CapsuleGeometry, CylinderGeometry, BoxGeometry, MeshGeometry>;

}  // namespace knap
