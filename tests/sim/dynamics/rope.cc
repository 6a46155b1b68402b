#include "tests/sim/dynamics/rope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace knap::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TriangleMesh MakeSpool(double side, double end_side) {
  constexpr double kLength = 0.09;
  const Eigen::Vector3i n(12, 5, 5);  // cells along each axis
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  const auto vertex = [&](const Eigen::Vector3i& at) {
    const auto [found, is_new] = index.emplace(std::array{at.x(), at.y(), at.z()}, mesh.vertices.size());
    if (is_new) {
      const Vector3d unit = at.cast<double>().cwiseQuotient(n.cast<double>()).array() - 0.5;
      const double from_middle = std::max(0.0, 3.0 * std::abs(unit.x()) - 0.5);
      const double size = side + (end_side - side) * from_middle;
      mesh.vertices.push_back(unit.cwiseProduct(Vector3d(kLength, size, size)));
    }
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const bool far : {false, true}) {
      for (int i = 0; i < n(u); ++i) {
        for (int j = 0; j < n(v); ++j) {
          std::array<int, 4> corner;
          for (int k = 0; k < 4; ++k) {
            Eigen::Vector3i at;
            at(axis) = far ? n(axis) : 0;
            at(u) = i + (k == 1 || k == 2);
            at(v) = j + (k >= 2);
            corner[far ? k : 3 - k] = vertex(at);
          }
          mesh.triangles.emplace_back(corner[0], corner[1], corner[2]);
          mesh.triangles.emplace_back(corner[0], corner[2], corner[3]);
        }
      }
    }
  }
  return mesh;
}

WoundRope MakeWoundRope(const TriangleMesh& spool, const ContactMaterial& material) {
  constexpr int kLinks = 15;
  constexpr double kPitch = 0.03;
  constexpr double kThickness = 0.008;
  constexpr double kAdvance = 0.01 / 8.0;  // a link; eight links a turn
  constexpr double kMass = 0.0015;
  WoundRope out;
  PairScene& scene = out.scene;
  out.spool = scene.AddFixed();
  const Vector3d size(kPitch - 0.001, kThickness, kThickness);
  const BoxGeometry box{0.5 * size, Vector3d(0.5 * kPitch, 0.0, 0.0)};
  const MeshGeometry mesh = MakeMesh(spool);
  const double along = std::sqrt(kPitch * kPitch - kAdvance * kAdvance);  // in the helix's cross-section
  const double reach = 0.025 + 0.001 + 0.5 * kThickness;
  const Vector3d s2 = size.cwiseAbs2();
  const Matrix3d I = (kMass / 12.0 * Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y())).asDiagonal();
  Matrix3d R_WP = Matrix3d::Identity();
  for (int i = 0; i < kLinks; ++i) {
    // Sides in turn, two links each; x of the link runs along it, z out of the spool.
    const double turn = 0.5 * std::acos(-1.0) * (i / 2);
    const Matrix3d side = Eigen::AngleAxisd(turn, Vector3d::UnitX()).toRotationMatrix();
    Matrix3d R_WB;
    R_WB.col(0) = side * Vector3d(kAdvance, -along, 0.0) / kPitch;
    R_WB.col(2) = side * Vector3d::UnitZ();
    R_WB.col(1) = R_WB.col(2).cross(R_WB.col(0));
    TreeBody link;
    link.joint = JointType::kBall;
    link.law.damping = i > 0 ? 2e-5 : 0.0;
    link.M = MakeSpatialInertia(kMass, box.center, I);
    if (i == 0) {
      TreeBody slide;
      slide.joint = JointType::kTranslation;
      link.parent = scene.tree.AddBody(slide);
      const Vector3d start(-0.5 * kLinks * kAdvance, along, reach);
      scene.q.insert(scene.q.end(), start.data(), start.data() + 3);
      scene.v.insert(scene.v.end(), 3, 0.0);
    } else {
      link.parent = out.links.back();
      link.X_PF.p.x() = kPitch;
    }
    const Eigen::Quaterniond q(Matrix3d(R_WP.transpose() * R_WB));
    scene.q.insert(scene.q.end(), {q.x(), q.y(), q.z(), q.w()});
    scene.v.insert(scene.v.end(), 3, 0.0);
    out.links.push_back(scene.tree.AddBody(link));
    scene.Touch(out.links.back(), box, out.spool, mesh, material);
    R_WP = R_WB;
  }
  return out;
}

}  // namespace knap::test
