// What bodies touch with, in the body's frame B, and the depth below a shape's surface as a smooth field.
//
// A field phi(x) is negative inside. Its gradient has at most unit length (exactly 1 on faces), so −phi is a depth.
//   half-space   phi = z − offset
//   rounded core, a box of half extents a (each ≥ 0) inflated by r:
//                phi = (|e|² − r²)/(2 r),  e_i = sign(x_i) smax(|x_i| − a_i, 0), e_i = x_i where a_i = 0
//                a sphere for a = 0, a capsule for a along z; distances from it to first order, valid above the core
//   solid box    phi = smax(smax(q_x, q_y), q_z), q_i = |x_i| − half_i: valid at any depth, edges rounded by smax
//
// smax(p, q) = (p + q + sabs(p − q))/2, sabs(t) = b (3 + 6 s² − s⁴)/8 for |s| ≤ 1, s = t/b, |t| beyond: C², convex, and
// exact where p and q differ by more than the blend b. So faces are flat and only edges and corners are rounded.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <variant>
#include <vector>

namespace knap {

class ContactMesh;

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

// Edges and corners are rounded by about `rounding`, > 0 and at most the least half extent.
struct BoxGeometry {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double rounding = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// A closed mesh whose vertices are given in B.
struct MeshGeometry {
  std::shared_ptr<const ContactMesh> mesh;
};

using ContactGeometry = std::variant<HalfSpaceGeometry, SphereGeometry, CapsuleGeometry, BoxGeometry, MeshGeometry>;

struct FieldValue {
  double phi;
  Eigen::Vector3d gradient;
  Eigen::Matrix3d hessian;
};

class ShapeField {
 public:
  static ShapeField MakeHalfSpace(double offset);
  static ShapeField MakeRoundedCore(const Eigen::Vector3d& core_half, double radius, const Eigen::Vector3d& center);
  static ShapeField MakeSolidBox(const Eigen::Vector3d& half, double rounding, const Eigen::Vector3d& center);

  // False, and nothing written, where phi ≥ 0. x in B.
  bool Evaluate(const Eigen::Vector3d& x, FieldValue* value) const;

  // Of the box in B outside which phi ≥ 0; infinite for a half-space.
  const Eigen::Vector3d& reach() const { return reach_; }
  const Eigen::Vector3d& center() const { return center_; }

 private:
  enum class Kind { kHalfSpace, kRoundedCore, kSolidBox };
  Kind kind_ = Kind::kHalfSpace;
  Eigen::Vector3d half_ = Eigen::Vector3d::Zero();  // of the core or the box
  double radius_ = 0.0;                             // of the core; of a half-space its offset
  double blend_ = 0.0;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d reach_ = Eigen::Vector3d::Zero();
};

// Points of a shape that stand for its surface, each a ball of `radius` around p_B that touches the surface from
// inside, and each with the area it stands for.
struct FeaturePoints {
  std::vector<Eigen::Vector3d> p_B;
  std::vector<double> area;  // [m²]
  double radius = 0.0;
};

// A lattice over the surface of the box with spacing at most `spacing` (corners always; on edges and faces as needed).
// A face's area is shared among its points by the trapezoidal rule; a point on two or three faces stands for their
// mean, so that a cube lying on a face counts exactly that face's area. Balls of radius `ball`, 0 for bare points.
FeaturePoints MakeBoxFeatures(const BoxGeometry& box, double ball, double spacing);

// Balls along the capsule's segment; their areas add up to its projected area 4 r half_length + π r².
FeaturePoints MakeCapsuleFeatures(const CapsuleGeometry& capsule, double spacing);

}  // namespace knap
