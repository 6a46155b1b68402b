// How deep a point lies in a shape: e(x) > 0 inside [m], zero on the surface.
//
//   half-space, box, convex mesh
//                      e = min_i (d_i − n_i·x) over its faces; a cell is where one face is nearest, and e linear there
//   sphere, capsule    e = (r² − |P (x − c)|²)/(2 r), |P (x − c)| the distance from the axis or its nearer end
//   cylinder           e = min((r² − |P (x − c)|²)/(2 r), H − |a·(x − c)|), distance from the axis, depth under an end
//
// The energy of a body B in the field of a body S is E ∫_{B∩S} e dV, so that by the divergence theorem B's surface
// feels the pressure E e. On round shapes e is the depth to first order, r/2 at the middle. A round field is one cell,
// a cylinder's too.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <variant>
#include <vector>

namespace knap {

// Of a solid n·x ≤ d; n of unit length.
struct FieldPlane {
  Eigen::Vector3d n;
  double d = 0.0;
  double CalcHeight(const Eigen::Vector3d& x) const { return n.dot(x) - d; }
};

struct PolyhedralField {
  std::vector<FieldPlane> planes;                            // a cell each
  Eigen::AlignedBox3d bounds;                                // around the solid; empty where nothing bounds it
  double deepest = std::numeric_limits<double>::infinity();  // the largest e [m]

  static PolyhedralField MakeHalfSpace(const FieldPlane& plane = {Eigen::Vector3d::UnitZ(), 0.0});
  // Along the columns of R.
  static PolyhedralField MakeBox(const Eigen::Vector3d& half, const Eigen::Vector3d& center,
                                 const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity());
};

// A sphere where half_length is 0.
struct RoundField {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit
};

// Flat ends at ± half_length along the axis.
struct CylinderField {
  double radius = 0.0;
  double half_length = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  // unit
};

using DepthField = std::variant<PolyhedralField, RoundField, CylinderField>;

// e(x), negative outside.
double CalcDepth(const RoundField& field, const Eigen::Vector3d& x);
double CalcDepth(const CylinderField& field, const Eigen::Vector3d& x);

}  // namespace knap
