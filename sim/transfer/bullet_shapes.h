// What a scene's bodies touch with in Bullet: one shape of Bullet's for each shape of the scene, and one for each
// convex piece of a mesh. Boxes are sharp, as in knap's own contact, up to Bullet's margin of a tenth of their half
// width.
#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <memory>
#include <vector>

#include "sim/math/pose.h"
#include "sim/scenarios/scene.h"
#include "sim/transfer/mesh_pieces.h"

namespace knap {

// A body's collision shape and what owns its parts; null without shapes. In units (bullet_units.h).
struct BulletShape {
  std::unique_ptr<btCollisionShape> whole;
  std::vector<std::unique_ptr<btCollisionShape>> parts;
  double half_width = 0.0;  // half the least extent of the body, as boxes around its shapes tell [m]; infinite of a
                            // half-space
};

// With the body's shapes seen from the frame P, in which Bullet has its centre of mass.
BulletShape MakeBulletShape(const Body& body, const MeshPieces& pieces, const Pose& X_BP);
// Of a link of a rope.
BulletShape MakeBulletShape(const Rope& rope, const Pose& X_BP);

}  // namespace knap
