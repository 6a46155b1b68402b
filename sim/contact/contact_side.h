// One direction of a contact: a body B, the touching one, in the depth field of a body S.
//
//   a mesh or a box in any field         its facets                                              (facet_integrals.h)
//   a sphere or a capsule                in a half-space's or a round body's field: its axis      (axis_integrals.h)
//   a cylinder                           in a half-space's field: its surface                 (cylinder_integrals.h)
//                                        in another's: a prism's facets       (ContactMesh::MakeCylinder)
//
// and what the pairs of pair_rules.h are, with the share of the modulus E that each direction has. A mesh is a designed
// one, which has a field for other designed ones alone; a hull is a convex mesh that is not designed (convex_field.h):
//
//   any shape and a half-space             the shape in the half-space's field, E
//   mesh and sphere, capsule, cylinder, box, hull
//                                          the mesh in the shape's field, E
//   box or hull and sphere, capsule, cylinder
//                                          the box or hull in the shape's field, E
//   cylinder and sphere, capsule           the cylinder in the round field, E
//   box or hull and box or hull, cylinder and cylinder
//                                          each in the other's field, E/2
//   mesh and mesh                          each in the fields of the other's convex pieces, E/2  (moving_pieces.h)
//   round and round                        each in the other's field, E/2
#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/contact/axis_integrals.h"
#include "sim/contact/contact_mesh.h"
#include "sim/contact/contact_shape.h"
#include "sim/contact/cylinder_integrals.h"
#include "sim/contact/depth_field.h"
#include "sim/contact/patch_law.h"
#include "sim/math/pose.h"

namespace knap {

struct ContactPair {
  std::array<int, 2> bodies{-1, -1};  // indices in the tree
  std::array<ContactGeometry, 2> shapes;
  ContactMaterial material;
};

struct ContactSide {
  int pair = 0;                 // the contact it belongs to
  int body = 0;                 // A
  int field_body = 0;           // S
  int shape = 0;                // which of the contact's two shapes is B's
  int first_id = 0;             // of its patches, one a cell, which number all bristles of a model
  double modulus = 0.0;         // E's share [N/m³]
  double rolling_radius = 0.0;  // 0: no rolling resistance
  double size = 0.0;            // the least half width of what meets [m]
  double deepest = 0.0;         // the e at which the thinner of the two is used up [m]
  DepthField field;
  std::shared_ptr<const ContactMesh> facets;  // null where B is round or a cylinder
  std::optional<RoundAxis> axis;              // in B
  std::optional<SolidCylinder> cylinder;      // in B
  bool is_designed = false;                   // the facets are a designed mesh's
  // Of a designed mesh's field: which of its convex pieces has it.
  std::shared_ptr<const MovingPieces> pieces = nullptr;
  int piece = -1;

  bool depends_on_design() const { return is_designed || pieces != nullptr; }
  int num_cells() const { return CountCells(field); }
};

// In the order of the contacts. Throws std::invalid_argument naming the contact's number for what does not touch.
std::vector<ContactSide> MakeSides(const std::vector<ContactPair>& contacts);

// The facets of one side near the field. Balls around both tell at once that most pairs are far apart; which facets are
// near is looked up by Bullet's tree, and kept while the bodies have moved little: a cache that changes no bit, because
// what is out of reach contributes nothing and facets are visited by ascending number.
class NearFacets {
 public:
  explicit NearFacets(const ContactSide& side);

  // Of a ball around B, in B.
  const Eigen::Vector3d& center_B() const { return center_B_; }
  double radius_B() const { return radius_B_; }
  // Of a ball around the field, in S; infinite for a half-space.
  Eigen::Vector3d center_S() const { return field_.center(); }
  double radius_S() const { return radius_S_; }
  // Whether the balls overlap: without it nothing touches.
  bool MayTouch(const Pose& X_WB, const Pose& X_WS) const;
  // Ascending, a superset of the facets that reach the field.
  const std::vector<int>& Find(const ContactSide& side, const Pose& X_SB);

 private:
  Eigen::Vector3d center_B_ = Eigen::Vector3d::Zero();  // of the ball around B
  double radius_B_ = 0.0;
  Eigen::AlignedBox3d field_;  // in S; empty for a half-space
  double radius_S_ = 0.0;      // infinite for a half-space
  FieldPlane plane_;           // of a half-space
  bool valid_ = false;
  Pose X_BS_;
  double margin_ = 0.0;
  std::vector<int> found_;
};

// One side at one relative pose: what follows is all made from the regions that its facets were cut into.
struct SidePatches {
  Pose X_SB;
  FacetRegions facets;                   // none where B has no facets
  std::vector<PatchIntegrals> patches;   // one a cell; E is in
  std::vector<PatchJacobian> jacobians;  // likewise
};

// Regions and patches.
void CalcPatches(const ContactSide& side, NearFacets* near, const Pose& X_SB, SidePatches* out);
// The jacobians of those.
void CalcPatchJacobians(const ContactSide& side, SidePatches* out);
// Adds to the cotangents of the designed meshes' vertices, each in its body, what follows from those of the patches:
// first B's, then S's; what is not designed has none.
void PullBackVertices(const ContactSide& side, const SidePatches& at, std::vector<PatchCotangent> bar,
                      Eigen::Matrix3Xd* bar_B, Eigen::Matrix3Xd* bar_S);

}  // namespace knap
