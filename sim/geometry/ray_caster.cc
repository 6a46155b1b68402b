#include "sim/geometry/ray_caster.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sim/geometry/bullet_memory.h"
#include "sim/geometry/leaf_ids.h"

namespace knap {
namespace {

using Eigen::Vector3d;

// Of the mesh's size: by which boxes and triangles are widened against rounding.
constexpr double kRounding = 1e-9;

}  // namespace

struct RayCaster::Tree {
  Tree() { UseThrowingBulletAllocator(); }
  TriangleMesh mesh;
  std::vector<Vector3d> normals;  // of unit length
  double size = 0.0;
  btDbvt dbvt;
};

RayCaster::RayCaster(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>()) {
  tree_->mesh = mesh;
  if (mesh.triangles.empty()) return;
  tree_->size = CalcBoundingBox(mesh).diagonal().norm();
  const Vector3d margin = Vector3d::Constant(kRounding * tree_->size);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const Vector3d& a = mesh.vertices[t[0]];
    tree_->normals.push_back((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNormalized());
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) box.extend(mesh.vertices[t[k]]);
    tree_->dbvt.insert(btDbvtVolume::FromMM(ToBullet(box.min() - margin), ToBullet(box.max() + margin)),
                       EncodeId(static_cast<int>(i)));
  }
  tree_->dbvt.optimizeTopDown(2);
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

const TriangleMesh& RayCaster::mesh() const { return tree_->mesh; }

std::optional<RayCaster::Hit> RayCaster::FindNext(const Vector3d& p, const Vector3d& direction, int from,
                                                  Crossing crossing, std::vector<int>* scratch) const {
  scratch->clear();
  CollectIds collect(scratch);
  const Vector3d end = p + 2.0 * tree_->size * direction;
  btDbvt::rayTest(tree_->dbvt.m_root, btVector3(p.x(), p.y(), p.z()), btVector3(end.x(), end.y(), end.z()), collect);
  std::optional<Hit> nearest;
  const double margin = kRounding * tree_->size;
  for (const int i : *scratch) {
    if (i == from) continue;
    const Vector3d& normal = tree_->normals[static_cast<std::size_t>(i)];
    const double along = normal.dot(direction);
    if (crossing == Crossing::kLeaving ? along <= 0.0 : along >= 0.0) continue;
    const Eigen::Vector3i& t = tree_->mesh.triangles[static_cast<std::size_t>(i)];
    const std::array<Vector3d, 3> corner{tree_->mesh.vertices[t[0]], tree_->mesh.vertices[t[1]],
                                         tree_->mesh.vertices[t[2]]};
    const double distance = normal.dot(corner[0] - p) / along;
    if (!(distance > 0.0) || (nearest && !(distance < nearest->distance))) continue;
    const Vector3d x = p + distance * direction;
    bool is_inside = true;
    for (std::size_t k = 0; k < 3 && is_inside; ++k) {
      const Vector3d edge = corner[(k + 1) % 3] - corner[k];
      is_inside = normal.dot(edge.cross(x - corner[k])) >= -margin * edge.norm();
    }
    if (is_inside) nearest = Hit{i, distance, std::abs(along)};
  }
  return nearest;
}

}  // namespace knap
