// One direction of a contact: points of a body B against the surface of a body S.
//
// The points are a shape's features or a mesh's samples (contact_shape.h, contact_mesh.h), the surface a field or a
// mesh. Everything is evaluated in S, where
//
//   c = X_SB p_B,   nu = (w, v0) the twist of B relative to S about So,   u = v0 + w × a at the contact a = c + l.
//
// Balls around both tell at once that most pairs are far apart. Which points and triangles are near is looked up, in
// meshes by Bullet's tree, and kept while the bodies have moved little: a cache that changes no bit, because what is
// out of reach contributes nothing and points are visited by ascending number. Where nothing is near, the space that is
// asked about doubles from one question to the next, so that what flies far away is seldom asked about.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/contact/contact_mesh.h"
#include "sim/contact/contact_shape.h"
#include "sim/contact/elastic_point.h"
#include "sim/math/spatial.h"

namespace knap {

// S's pose and twist as seen from B and back.
struct RelativeMotion {
  Pose X_SB;
  Vector6d V_B_S = Vector6d::Zero();  // twist of B, about So in S
  Vector6d nu = Vector6d::Zero();     // that less the twist of S
  Pose X_BS() const { return {X_SB.R.transpose(), -(X_SB.R.transpose() * X_SB.p)}; }
  static RelativeMotion Make(const Pose& X_WB, const Vector6d& V_B, const Pose& X_WS, const Vector6d& V_S);
};

struct PointSide {
  enum class Law { kField, kBallOnMesh, kSphereOnMesh, kSphereOnPlane };

  int pair = 0;          // the contact it belongs to
  int point_body = 0;    // B
  int surface_body = 0;  // S
  int first_id = 0;      // of its points, which number all bristles of a model
  Law law = Law::kField;
  double modulus = 0.0;                             // E, or the share of it that these points carry [N/m³]
  double rho = 0.0;                                 // lever of the contact before the point [m]
  double rolling_radius = 0.0;                      // 0: no rolling resistance
  ShapeField field;                                 // kField
  std::shared_ptr<const ContactMesh> surface_mesh;  // kBallOnMesh, kSphereOnMesh
  std::shared_ptr<const ContactMesh> point_mesh;    // whose samples the points are; else `features`
  FeaturePoints features;

  const std::vector<Eigen::Vector3d>& points() const { return point_mesh ? point_mesh->samples() : features.p_B; }
  const std::vector<double>& areas() const { return point_mesh ? point_mesh->sample_areas() : features.area; }
};

// The points of one side near the surface, and the triangles near each point.
class NearPoints {
 public:
  explicit NearPoints(const PointSide& side);

  // Whether the balls around all points and around all that the surface reaches overlap: without it nothing touches.
  bool MayTouch(const Pose& X_WB, const Pose& X_WS) const;
  // Ascending, a superset of the points in contact.
  const std::vector<int>& FindPoints(const PointSide& side, const Pose& X_SB);
  // Of side.surface_mesh, ascending, a superset of those within rho of c, the place of point i in S.
  const std::vector<int>& FindTriangles(const PointSide& side, int i, const Eigen::Vector3d& c);

 private:
  struct NearTriangles {
    Eigen::AlignedBox3d box;  // valid while the ball lies in it
    double margin = 0.0;      // by which it was larger than the ball
    std::vector<int> triangles;
  };
  struct Ball {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0.0;
  };

  // Whether no triangle of side.surface_mesh is within reach of the points' ball.
  bool IsClear(const PointSide& side, const Pose& X_SB);
  void CollectPoints(const PointSide& side, const Pose& X_SB, const Pose& X_BS);

  Ball points_ball_;   // in B
  Ball surface_ball_;  // in S; infinite for a half-space
  // Of IsClear: the answer, which holds while the ball's centre is within clear_margin_ of clear_at_.
  bool clear_ = false;
  double clear_margin_ = -1.0;
  Eigen::Vector3d clear_at_ = Eigen::Vector3d::Zero();
  std::vector<int> none_;
  std::vector<int> points_;
  std::vector<int> found_;
  bool looks_up_ = false;  // where a field is touched by several points; else points_ has all
  bool valid_ = false;
  Pose X_BS_;
  double least_margin_ = 0.0;
  double margin_ = 0.0;
  double extent_ = 0.0;
  std::vector<NearTriangles> triangles_;
};

// The elastic response at point i of the side, c its place in S, less its derivatives; *integrals stays as it is where
// the surface is a field. False without contact.
bool CalcElasticPoint(const PointSide& side, NearPoints* near, int i, const Eigen::Vector3d& c,
                      MeshIntegrals* integrals, ElasticPoint* out);
// The derivatives, once that has returned true.
void CalcElasticDerivatives(const PointSide& side, int i, const Eigen::Vector3d& c, const MeshIntegrals& integrals,
                            ElasticPoint* out);

// Cotangents of a response.
struct ElasticCotangent {
  double N = 0.0;
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  Eigen::Vector3d l = Eigen::Vector3d::Zero();
};
// Adds to bar_vertices of side.surface_mesh what follows from those at point i.
void PullBackSurfaceMesh(const PointSide& side, NearPoints* near, int i, const Eigen::Vector3d& c,
                         const MeshIntegrals& integrals, const ElasticCotangent& bar, Eigen::Matrix3Xd* bar_vertices);

}  // namespace knap
