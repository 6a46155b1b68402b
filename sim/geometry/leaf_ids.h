// Numbers of triangles at the leaves of one of Bullet's trees, which keeps a pointer with each that no one
// dereferences.
#pragma once

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace knap {

inline btVector3 ToBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

inline void* EncodeId(int id) { return reinterpret_cast<void*>(static_cast<std::intptr_t>(id)); }
inline int DecodeId(void* data) { return static_cast<int>(reinterpret_cast<std::intptr_t>(data)); }

// Of the leaves that a search meets.
struct CollectIds final : btDbvt::ICollide {
  explicit CollectIds(std::vector<int>* ids_in) : ids(ids_in) {}
  void Process(const btDbvtNode* leaf) override { ids->push_back(DecodeId(leaf->data)); }
  std::vector<int>* ids;
};

}  // namespace knap
