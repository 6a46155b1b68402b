#include "sim/contact/contact_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace knap {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

double CalcArea(const TriangleFrame& frame) {
  return 0.5 * (frame.v[1] - frame.v[0]).cross(frame.v[2] - frame.v[0]).norm();
}

// Names a lattice point so that triangles that share it agree: corner weights by vertex, those of zero left out.
using LatticeKey = std::array<int, 7>;

LatticeKey MakeKey(const Vector3i& triangle, const Vector3i& weights, int n, int triangle_index) {
  std::array<std::pair<int, int>, 3> used{};
  int count = 0;
  for (int k = 0; k < 3; ++k) {
    if (weights(k) > 0) used[count++] = {triangle[k], weights(k)};
  }
  std::sort(used.begin(), used.begin() + count);
  LatticeKey key;
  key.fill(-1);
  if (count == 1) {
    key[0] = used[0].first;
    return key;
  }
  key[6] = n;
  if (count == 3) key[5] = triangle_index;
  for (int k = 0; k < count; ++k) {
    key[k] = used[k].first;
    if (k < 2) key[3 + k] = used[k].second;
  }
  return key;
}

}  // namespace

SurfaceSampling::SurfaceSampling(const TriangleMesh& reference, double spacing) {
  std::map<LatticeKey, int> index;
  shares_.resize(reference.triangles.size());
  for (int t = 0; t < static_cast<int>(reference.triangles.size()); ++t) {
    const Vector3i& triangle = reference.triangles[t];
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, (reference.vertices[triangle[k]] - reference.vertices[triangle[(k + 1) % 3]]).norm());
    }
    const int n = std::max(1, static_cast<int>(std::ceil(longest / spacing * (1.0 - 1e-9))));
    // A lattice point is a corner of one part at a vertex, of three on an edge, of six inside.
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        const Vector3i weights(n - i - j, i, j);
        const LatticeKey key = MakeKey(triangle, weights, n, t);
        const auto [at, is_new] = index.emplace(key, static_cast<int>(points_.size()));
        if (is_new) points_.push_back({t, weights.cast<double>() / n});
        const int on_edges = (weights.array() == 0).count();
        const double parts = on_edges == 2 ? 1.0 : on_edges == 1 ? 3.0 : 6.0;
        shares_[t].push_back({at->second, parts / (3.0 * n * n)});
      }
    }
  }
}

ContactMesh::ContactMesh(const TriangleMesh& mesh)
    : triangles_(mesh.triangles),
      vertex_count_(static_cast<int>(mesh.vertices.size())),
      bvh_(std::make_unique<TriangleBvh>(mesh)) {
  frames_.reserve(mesh.triangles.size());
  for (const Vector3i& t : mesh.triangles) {
    frames_.push_back(TriangleFrame::Make(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
}

ContactMesh::ContactMesh(const TriangleMesh& mesh, std::shared_ptr<const SurfaceSampling> sampling)
    : ContactMesh(mesh) {
  sampling_ = std::move(sampling);
  if (sampling_ == nullptr) return;
  TriangleMesh cloud;  // a point is a triangle without extent
  for (const SurfaceSampling::Point& point : sampling_->points()) {
    const TriangleFrame& frame = frames_[point.triangle];
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) x += point.barycentric(k) * frame.v[k];
    const int id = static_cast<int>(samples_.size());
    samples_.push_back(x);
    cloud.triangles.emplace_back(id, id, id);
  }
  sample_areas_.assign(samples_.size(), 0.0);
  for (std::size_t t = 0; t < frames_.size(); ++t) {
    const double area = CalcArea(frames_[t]);
    for (const SurfaceSampling::Share& share : sampling_->shares()[t]) {
      sample_areas_[share.point] += share.of_area * area;
    }
  }
  cloud.vertices = samples_;
  sample_bvh_ = std::make_unique<TriangleBvh>(cloud);
}

void ContactMesh::PullBackSamples(const Eigen::Matrix3Xd& bar_samples, const Eigen::VectorXd& bar_areas,
                                  Eigen::Matrix3Xd* bar_vertices) const {
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const SurfaceSampling::Point& point = sampling_->points()[i];
    for (int k = 0; k < 3; ++k) {
      bar_vertices->col(triangles_[point.triangle][k]) += point.barycentric(k) * bar_samples.col(i);
    }
  }
  for (std::size_t t = 0; t < frames_.size(); ++t) {
    double bar_area = 0.0;
    for (const SurfaceSampling::Share& share : sampling_->shares()[t]) {
      bar_area += share.of_area * bar_areas(share.point);
    }
    // Pulling a vertex outward from the opposite edge widens the triangle by half that edge's length.
    const TriangleFrame& frame = frames_[t];
    for (int k = 0; k < 3; ++k) {
      const int opposite = (k + 1) % 3;
      bar_vertices->col(triangles_[t][k]) -= 0.5 * bar_area * frame.length[opposite] * frame.m[opposite];
    }
  }
}

}  // namespace knap
