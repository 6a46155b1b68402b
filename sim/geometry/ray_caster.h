#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

// Where rays from a closed mesh's own surface cross it next. A tree of bounding boxes (Bullet's btDbvt), as wide as
// rounding needs, so that no triangle is missed. Immutable; queries may run on several threads at once.
class RayCaster {
 public:
  // Copies the mesh, whose indices must be in range and whose vertices must be finite.
  explicit RayCaster(const TriangleMesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  const TriangleMesh& mesh() const;

  struct Hit {
    int triangle = 0;
    double distance = 0.0;  // along the ray, more than 0 [m]
    double facing = 0.0;    // |direction · normal|, from 0 to 1
  };

  enum class Crossing { kLeaving, kEntering };  // the material that the mesh encloses

  // The nearest crossing of this kind of the ray from p, a point of triangle `from`, along a unit vector; edges count
  // as both triangles'. None where there is none. `scratch` spares an allocation.
  std::optional<Hit> FindNext(const Eigen::Vector3d& p, const Eigen::Vector3d& direction, int from, Crossing crossing,
                              std::vector<int>* scratch) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace knap
