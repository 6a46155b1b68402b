#include "sim/rollout/vertex_groups.h"

#include <Eigen/Geometry>
#include <cstddef>

namespace knap {

std::vector<std::int64_t> ListVertices(const VertexGroup& group, const TriangleMesh& cage) {
  if (!group.box && !group.plane) return group.vertices;
  const double margin = 1e-9 * CalcBoundingBox(cage).diagonal().norm();
  std::vector<std::int64_t> vertices;
  for (std::size_t i = 0; i < cage.vertices.size(); ++i) {
    const Eigen::Vector3d& p = cage.vertices[i];
    const bool is_in = group.box ? (p.array() >= group.box->lower.array() - margin).all() &&
                                       (p.array() <= group.box->upper.array() + margin).all()
                                 : group.plane->normal.normalized().dot(p - group.plane->point) >= -margin;
    if (is_in) vertices.push_back(static_cast<std::int64_t>(i));
  }
  return vertices;
}

}  // namespace knap
