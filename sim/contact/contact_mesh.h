// A triangle mesh prepared for contact, in its body's frame: frames of its triangles, and area-weighted sample points.
//
// Samples are lattice points of each triangle, cut into n × n parts, n the least with parts no longer than a spacing;
// vertices always, inner points of edges and faces where n > 1. Each part's area goes to its three corners in equal
// shares, so the weights add up to the mesh's area and a pressure that is linear on each part is summed exactly.
// Points that triangles share are merged. The choice of points is made once, on a reference shape: their barycentric
// coordinates and shares stay when the mesh deforms, so position and area follow the vertices smoothly.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <vector>

#include "sim/contact/sphere_triangle.h"
#include "sim/geometry/triangle_bvh.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

class SurfaceSampling {
 public:
  // `spacing` > 0 [m]; lengths are those of `reference`.
  SurfaceSampling(const TriangleMesh& reference, double spacing);

  struct Point {
    int triangle = 0;             // on which it lies (one of those that share it)
    Eigen::Vector3d barycentric;  // in that triangle's corners
  };
  struct Share {
    int point = 0;
    double of_area = 0.0;  // of the triangle's area
  };

  const std::vector<Point>& points() const { return points_; }
  // For each triangle, whose shares add up to 1.
  const std::vector<std::vector<Share>>& shares() const { return shares_; }

 private:
  std::vector<Point> points_;
  std::vector<std::vector<Share>> shares_;
};

// Immutable.
class ContactMesh {
 public:
  // Without samples: it can touch spheres only.
  explicit ContactMesh(const TriangleMesh& mesh);
  ContactMesh(const TriangleMesh& mesh, std::shared_ptr<const SurfaceSampling> sampling);

  const std::vector<TriangleFrame>& frames() const { return frames_; }
  const std::vector<Eigen::Vector3i>& triangles() const { return triangles_; }
  int vertex_count() const { return vertex_count_; }
  const TriangleBvh& bvh() const { return *bvh_; }

  bool has_samples() const { return sampling_ != nullptr; }
  const std::vector<Eigen::Vector3d>& samples() const { return samples_; }
  const std::vector<double>& sample_areas() const { return sample_areas_; }
  const TriangleBvh& sample_bvh() const { return *sample_bvh_; }  // its "triangles" are the samples

  // Adds to bar_vertices (3 × vertex_count) the cotangents under Σ bar_samples·samples + Σ bar_areas·sample_areas.
  void PullBackSamples(const Eigen::Matrix3Xd& bar_samples, const Eigen::VectorXd& bar_areas,
                       Eigen::Matrix3Xd* bar_vertices) const;

 private:
  std::vector<TriangleFrame> frames_;
  std::vector<Eigen::Vector3i> triangles_;
  int vertex_count_ = 0;
  std::unique_ptr<TriangleBvh> bvh_;
  std::shared_ptr<const SurfaceSampling> sampling_;
  std::vector<Eigen::Vector3d> samples_;
  std::vector<double> sample_areas_;
  std::unique_ptr<TriangleBvh> sample_bvh_;
};

}  // namespace knap
