#include "sim/morphology/cage_design.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "sim/morphology/cage_fit.h"
#include "sim/morphology/mean_value_coordinates.h"

namespace knap {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void CheckMove(const VertexMove& move, Index num_parameters, size_t num_cage_vertices) {
  if (move.parameter < 0 || move.parameter >= num_parameters) {
    throw std::invalid_argument(
        fmt::format("a cage move names parameter {}; there are {}, counted from 0", move.parameter, num_parameters));
  }
  if (move.cage_vertex < 0 || static_cast<size_t>(move.cage_vertex) >= num_cage_vertices) {
    throw std::invalid_argument(fmt::format("a move of parameter {} names cage vertex {}; there are {}, counted from 0",
                                            move.parameter, move.cage_vertex, num_cage_vertices));
  }
  if (!move.direction.allFinite()) {
    throw std::invalid_argument(
        fmt::format("a move of parameter {} at cage vertex {} has a direction that is not finite", move.parameter,
                    move.cage_vertex));
  }
}

TriangleMesh Displace(const TriangleMesh& mesh, const VectorXd& displacement) {
  TriangleMesh displaced = mesh;
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    displaced.vertices[i] += displacement.segment<3>(static_cast<Index>(3 * i));
  }
  return displaced;
}

}  // namespace

CageDesign::CageDesign(TriangleMesh mesh, TriangleMesh cage, VectorXd initial_theta,
                       const std::vector<VertexMove>& moves)
    : mesh_(std::move(mesh)), cage_(std::move(cage)), initial_theta_(std::move(initial_theta)) {
  const MeshDefects defects = FindDefects(mesh_);
  if (!defects.empty()) {
    throw std::invalid_argument(
        fmt::format("a body's mesh must be closed and face outwards; this one has {}", defects.Describe()));
  }
  CheckCage(cage_);
  const std::string misfit = DescribeMisfit(mesh_, cage_);
  if (!misfit.empty()) throw std::invalid_argument(misfit);
  if (!initial_theta_.allFinite()) throw std::invalid_argument("an initial parameter is not finite");
  const MatrixXd weights = CalcMeanValueWeights(cage_, mesh_);

  const Index d = initial_theta_.size();
  dc_dtheta_.setZero(static_cast<Index>(3 * cage_.vertices.size()), d);
  for (const VertexMove& move : moves) {
    CheckMove(move, d, cage_.vertices.size());
    dc_dtheta_.col(move.parameter).segment<3>(3 * move.cage_vertex) += move.direction;
  }
  // A column holds the vertices' derivatives one after the other: as a 3 x n matrix, mesh = cage * W^T.
  dm_dtheta_.resize(static_cast<Index>(3 * mesh_.vertices.size()), d);
  for (Index j = 0; j < d; ++j) {
    const Map<const Matrix3Xd> dc(dc_dtheta_.col(j).data(), 3, weights.cols());
    Map<Matrix3Xd>(dm_dtheta_.col(j).data(), 3, weights.rows()).noalias() = dc * weights.transpose();
  }
}

Matrix3Xd CageDesign::CalcVertices(const Eigen::Ref<const VectorXd>& theta) const {
  const VectorXd displacement = dm_dtheta_ * (theta - initial_theta_);
  Matrix3Xd vertices = Map<const Matrix3Xd>(displacement.data(), 3, num_vertices());
  for (int i = 0; i < num_vertices(); ++i) vertices.col(i) += mesh_.vertices[static_cast<size_t>(i)];
  return vertices;
}

TriangleMesh CageDesign::CalcMesh(const Eigen::Ref<const VectorXd>& theta) const {
  return Displace(mesh_, dm_dtheta_ * (theta - initial_theta_));
}

TriangleMesh CageDesign::CalcCage(const Eigen::Ref<const VectorXd>& theta) const {
  return Displace(cage_, dc_dtheta_ * (theta - initial_theta_));
}

Matrix3Xd CageDesign::CalcPointDerivative(const Eigen::Vector3d& p) const {
  const VectorXd weights = CalcMeanValueCoordinates(cage_, p);
  Matrix3Xd out(3, num_parameters());
  for (Index j = 0; j < out.cols(); ++j) {
    out.col(j) = Map<const Matrix3Xd>(dc_dtheta_.col(j).data(), 3, weights.size()) * weights;
  }
  return out;
}

VectorXd CageDesign::PullBack(const Eigen::Ref<const Matrix3Xd>& bar_vertices) const {
  // Column-major order makes element (k, i) of bar the row 3 i + k of dm/dtheta.
  const Matrix3Xd bar = bar_vertices;
  return dm_dtheta_.transpose() * Map<const VectorXd>(bar.data(), bar.size());
}

}  // namespace knap
