#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Finds the triangles of a fixed mesh that may touch a box: a tree of bounding boxes (Bullet's btDbvt).
// Immutable after construction; queries may run on several threads at once.
class TriangleBvh {
 public:
  // Copies what it needs of `mesh`, whose indices must be in range and whose vertices must be finite.
  // O(n log n) time. A mesh without triangles is allowed.
  explicit TriangleBvh(const TriangleMesh& mesh);
  ~TriangleBvh();
  TriangleBvh(TriangleBvh&&) noexcept;
  TriangleBvh& operator=(TriangleBvh&&) noexcept;

  // Replaces *triangles by the ids, ascending, of all triangles whose bounding boxes meet `box` (closed
  // boxes: touching counts), in the mesh's frame [m]. No others: the answer is that of testing every
  // triangle, to the bit, whatever the shape of the tree. An empty `box` meets nothing. Does not allocate
  // while *triangles has capacity for the answer; num_triangles() is always enough.
  void FindTriangles(const Eigen::AlignedBox3d& box, std::vector<int>* triangles) const;

  int num_triangles() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace knap
