#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// One entry of the linear map from parameters to the cage: raising theta[parameter] by one unit moves cage
// vertex `cage_vertex` by `direction` [m per unit of the parameter].
struct VertexMove {
  int parameter;    // 0 <= parameter < d
  int cage_vertex;  // 0 <= cage_vertex < n_cage
  Eigen::Vector3d direction;
};

// A body whose shape follows d parameters theta through a cage:
//
//   c(theta) = c_0 + dc/dtheta (theta - theta_0),     m(theta) = m_0 + W (c(theta) - c_0),
//
// with the cage's vertices c, the mesh's vertices m, and the mean value weights W of m_0 in c_0. Everything
// is linear, so dm/dtheta is one constant matrix and the initial mesh is met exactly. Immutable.
class CageDesign {
 public:
  // `mesh` and `cage` are the shapes at theta_0, in one frame [m]; several moves may share a vertex and a
  // parameter (they add up). Throws std::invalid_argument with one line when mesh or cage is not closed,
  // manifold and outward oriented, when the mesh reaches out of the cage, when a move's indices are out of range or its
  // direction not finite, or when theta_0 is not finite. Costs n_mesh x (triangles of the cage) evaluations.
  CageDesign(TriangleMesh mesh, TriangleMesh cage, Eigen::VectorXd initial_theta, const std::vector<VertexMove>& moves);

  int num_parameters() const { return static_cast<int>(initial_theta_.size()); }
  int num_vertices() const { return static_cast<int>(mesh_.vertices.size()); }
  const TriangleMesh& initial_mesh() const { return mesh_; }
  const TriangleMesh& initial_cage() const { return cage_; }
  const Eigen::VectorXd& initial_theta() const { return initial_theta_; }

  // (3 n_mesh x d): row 3 i + k is the derivative of coordinate k of mesh vertex i.
  const Eigen::MatrixXd& dm_dtheta() const { return dm_dtheta_; }
  // (3 n_cage x d), likewise for the cage.
  const Eigen::MatrixXd& dc_dtheta() const { return dc_dtheta_; }

  // The mesh's vertices at theta (d), one a column [m].
  Eigen::Matrix3Xd CalcVertices(const Eigen::Ref<const Eigen::VectorXd>& theta) const;
  // The deformed mesh: these vertices with the initial triangles. Far from theta_0 it may fold; see FindDefects
  // and CalcSignedVolume.
  TriangleMesh CalcMesh(const Eigen::Ref<const Eigen::VectorXd>& theta) const;
  // The deformed cage.
  TriangleMesh CalcCage(const Eigen::Ref<const Eigen::VectorXd>& theta) const;

  // Derivative (3 x d) of a point that moves with the mesh as a vertex at p would; p in the initial shape's frame.
  Eigen::Matrix3Xd CalcPointDerivative(const Eigen::Vector3d& p) const;

  // (dm/dtheta)^T bar: turns the cotangent of the vertices, bar_vertices (3 x n_mesh, dL/dm), into that of
  // the parameters (d), dL/dtheta. The same for every theta.
  Eigen::VectorXd PullBack(const Eigen::Ref<const Eigen::Matrix3Xd>& bar_vertices) const;

 private:
  TriangleMesh mesh_;
  TriangleMesh cage_;
  Eigen::VectorXd initial_theta_;
  Eigen::MatrixXd dc_dtheta_;
  Eigen::MatrixXd dm_dtheta_;
};

}  // namespace knap
