// What bodies touch with: solids at their place in the body's frame B.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <variant>

#include "sim/contact/depth_field.h"

namespace knap {

class ContactMesh;
struct MovingPieces;

struct HalfSpaceGeometry {
  FieldPlane plane{Eigen::Vector3d::UnitZ(), 0.0};
};

struct SphereGeometry {
  double radius = 0.0;  // [m]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// A cylinder of length 2·half_length with half a sphere on either end.
struct CapsuleGeometry {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit
};

// Of length 2·half_length, with flat ends.
struct CylinderGeometry {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit
};

// Along the columns of R.
struct BoxGeometry {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
};

// A closed mesh whose vertices are given in B.
struct MeshGeometry {
  std::shared_ptr<const ContactMesh> mesh;
  // Of a convex one that is not designed. Null: a designed mesh; what its vertices do to a loss is asked for.
  std::shared_ptr<const PolyhedralField> field = nullptr;
  // Of a designed mesh, what another one is cut up in (moving_pieces.h). Null: it meets none.
  std::shared_ptr<const MovingPieces> pieces = nullptr;
  bool IsDesigned() const { return field == nullptr; }
};

using ContactGeometry =
    std::variant<HalfSpaceGeometry, SphereGeometry, CapsuleGeometry, CylinderGeometry, BoxGeometry, MeshGeometry>;

}  // namespace knap
