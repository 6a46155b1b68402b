#include "sim/transfer/bullet_shapes.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "sim/math/overloaded.h"
#include "sim/rollout/build_body.h"
#include "sim/transfer/bullet_units.h"

namespace knap {
namespace {

using Eigen::Vector3d;

// Bullet's convex shapes with a sharp surface put a rounding of this share of the half width inside of it.
constexpr double kBoxMargin = 0.1;

Pose Invert(const Pose& X) { return {X.R.transpose(), -(X.R.transpose() * X.p)}; }

// Shapes in a compound, each at its place in P.
class ShapeList {
 public:
  void Add(std::unique_ptr<btCollisionShape> shape, const Pose& X_PG, double half_width) {
    half_width_ = std::min(half_width_, half_width);
    places_.push_back(ToUnits(X_PG));
    shapes_.push_back(std::move(shape));
  }

  void AddBox(const Vector3d& size, const Pose& X_PG) {
    const Vector3d half = 0.5 * size;
    auto box = std::make_unique<btBoxShape>(ToUnits(half));
    box->setMargin(kBoxMargin * kUnitsPerMetre * half.minCoeff());
    box->initializePolyhedralFeatures();
    Add(std::move(box), X_PG, half.minCoeff());
  }

  void AddHull(const TriangleMesh& piece, const Pose& X_PB) {
    auto hull = std::make_unique<btConvexHullShape>();
    Vector3d lower = piece.vertices.front(), upper = lower;
    for (const Vector3d& v : piece.vertices) {
      hull->addPoint(ToUnits(v), false);
      lower = lower.cwiseMin(v);
      upper = upper.cwiseMax(v);
    }
    // What is beyond the margin of the other body is found by Bullet's search for penetration.
    hull->setMargin(0.0);
    hull->recalcLocalAabb();
    hull->initializePolyhedralFeatures();
    Add(std::move(hull), X_PB, 0.5 * (upper - lower).minCoeff());
  }

  BulletShape Finish() {
    BulletShape out;
    if (shapes_.empty()) return out;
    out.half_width = half_width_;
    // Bullet's rules for pairs of shapes know a plane better alone than within a compound.
    if (shapes_.size() == 1 && places_.front() == btTransform::getIdentity()) {
      out.whole = std::move(shapes_.front());
      return out;
    }
    auto compound = std::make_unique<btCompoundShape>(true, static_cast<int>(shapes_.size()));
    for (std::size_t i = 0; i < shapes_.size(); ++i) compound->addChildShape(places_[i], shapes_[i].get());
    out.whole = std::move(compound);
    out.parts = std::move(shapes_);
    return out;
  }

 private:
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<btTransform> places_;
  double half_width_ = std::numeric_limits<double>::infinity();
};

}  // namespace

BulletShape MakeBulletShape(const Body& body, const MeshPieces& pieces, const Pose& X_BP) {
  const Pose X_PB = Invert(X_BP);
  ShapeList list;
  for (std::size_t i = 0; i < body.shapes.size(); ++i) {
    const Pose X_PG = X_PB * MakePose(body.shapes[i]);
    const auto add_pieces = [&] {
      for (const TriangleMesh& piece : pieces.at({body.name, i})) list.AddHull(piece, X_PB);
    };
    std::visit(
        Overloaded{[&](const HalfSpaceShape&) {
                     const Vector3d n = X_PG.R.col(2);
                     list.Add(std::make_unique<btStaticPlaneShape>(ToBullet(n), kUnitsPerMetre * n.dot(X_PG.p)), Pose{},
                              std::numeric_limits<double>::infinity());
                   },
                   [&](const SphereShape& s) {
                     list.Add(std::make_unique<btSphereShape>(kUnitsPerMetre * s.radius), X_PG, s.radius);
                   },
                   [&](const CapsuleShape& s) {
                     list.Add(std::make_unique<btCapsuleShapeZ>(kUnitsPerMetre * s.radius, kUnitsPerMetre * s.length),
                              X_PG, s.radius);
                   },
                   [&](const CylinderShape& s) {
                     const double half = std::min(s.radius, 0.5 * s.length);
                     auto cylinder =
                         std::make_unique<btCylinderShapeZ>(ToUnits(Vector3d(s.radius, s.radius, 0.5 * s.length)));
                     cylinder->setMargin(kBoxMargin * kUnitsPerMetre * half);
                     list.Add(std::move(cylinder), X_PG, half);
                   },
                   [&](const BoxShape& s) { list.AddBox(s.size, X_PG); },
                   [&](const DesignedMeshShape&) { add_pieces(); }, [&](const MeshShape&) { add_pieces(); }},
        body.shapes[i].kind);
  }
  return list.Finish();
}

BulletShape MakeBulletShape(const Rope& rope, const Pose& X_BP) {
  ShapeList list;
  list.AddBox(Vector3d(rope.pitch - rope.gap, rope.thickness, rope.thickness),
              Invert(X_BP) * Pose{Eigen::Matrix3d::Identity(), Vector3d(0.5 * rope.pitch, 0.0, 0.0)});
  return list.Finish();
}

}  // namespace knap
