#include "sim/geometry/triangle_bvh.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <cstddef>

#include "sim/geometry/bullet_memory.h"
#include "sim/geometry/leaf_ids.h"

namespace knap {

struct TriangleBvh::Tree {
  Tree() { UseThrowingBulletAllocator(); }
  btDbvt dbvt;
  int num_triangles = 0;
};

TriangleBvh::TriangleBvh(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>()) {
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) box.extend(mesh.vertices[t[k]]);
    tree_->dbvt.insert(btDbvtVolume::FromMM(ToBullet(box.min()), ToBullet(box.max())),
                       EncodeId(tree_->num_triangles++));
  }
  // Insertion one by one leaves a lopsided tree; a rebuild from the top makes queries faster. All the way down: below a
  // threshold Bullet tries all pairs, which for its 128 leaves takes most of the time a new design costs.
  constexpr int kAllPairsBelow = 2;
  tree_->dbvt.optimizeTopDown(kAllPairsBelow);
}

TriangleBvh::~TriangleBvh() = default;
TriangleBvh::TriangleBvh(TriangleBvh&&) noexcept = default;
TriangleBvh& TriangleBvh::operator=(TriangleBvh&&) noexcept = default;

int TriangleBvh::num_triangles() const { return tree_->num_triangles; }

void TriangleBvh::FindTriangles(const Eigen::AlignedBox3d& box, std::vector<int>* triangles) const {
  triangles->clear();
  if (box.isEmpty()) return;
  CollectIds collect(triangles);
  // collideTV keeps its stack of nodes in automatic storage, so the call is const, reentrant and free of
  // allocation for any tree a mesh of this size makes.
  tree_->dbvt.collideTV(tree_->dbvt.m_root, btDbvtVolume::FromMM(ToBullet(box.min()), ToBullet(box.max())), collect);
  std::sort(triangles->begin(), triangles->end());
}

}  // namespace knap
