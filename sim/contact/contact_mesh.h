// A surface of facets prepared for contact, in its body's frame.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "sim/contact/contact_shape.h"
#include "sim/contact/facet_regions.h"
#include "sim/geometry/triangle_bvh.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Immutable.
class ContactMesh {
 public:
  explicit ContactMesh(const TriangleMesh& mesh);
  // The six faces, without triangles.
  static ContactMesh MakeBox(const BoxGeometry& box);
  // A prism of kCylinderSides sides between flat ends, as large as the cylinder: the middles of its sides lie 0.01% of
  // the radius inside of it, its edges 0.02% outside.
  static ContactMesh MakeCylinder(const CylinderGeometry& cylinder);
  static constexpr int kCylinderSides = 128;

  const std::vector<Facet>& facets() const { return facets_; }
  // A ball around each facet: the middle of its corners' box and the farthest corner's distance.
  struct Ball {
    Eigen::Vector3d center;
    double radius = 0.0;
  };
  const std::vector<Ball>& balls() const { return balls_; }
  const std::vector<Eigen::Vector3i>& triangles() const { return triangles_; }  // of facets, by vertex
  int vertex_count() const { return vertex_count_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

  // Ascending; a superset of the facets that reach the box.
  void FindFacets(const Eigen::AlignedBox3d& box, std::vector<int>* facets) const;

 private:
  ContactMesh() = default;
  void AddFacet(std::span<const Eigen::Vector3d> corners);
  std::vector<Facet> facets_;
  std::vector<Ball> balls_;
  std::vector<Eigen::Vector3i> triangles_;
  int vertex_count_ = 0;
  Eigen::AlignedBox3d bounds_;
  std::unique_ptr<TriangleBvh> bvh_;  // null for a box
};

}  // namespace knap
