#include "coordinator/report/rope_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace knap {
namespace {

constexpr double kFromAbove = 0.25;  // [rad]
constexpr double kFromTheEnd = 0.4;  // [rad]
constexpr int kPieces = 4;           // a link is cut so that faces are of like size, which sorting by depth needs

class FaceList {
 public:
  FaceList(const Eigen::Matrix3d& eye, std::vector<ShownFace>* faces) : eye_(eye), faces_(faces) {}

  // Corners in W, counter-clockwise seen from outside.
  void Add(const std::vector<Eigen::Vector3d>& corners_W, bool of_rope) {
    const Eigen::Vector3d normal =
        (eye_ * (corners_W[1] - corners_W[0]).cross(corners_W[2] - corners_W[0])).normalized();
    if (!(normal.z() > 1e-6)) return;
    ShownFace face;
    for (const Eigen::Vector3d& corner : corners_W) {
      const Eigen::Vector3d p = eye_ * corner;
      face.corners.emplace_back(p.x(), p.y());
      face.depth += p.z() / static_cast<double>(corners_W.size());
    }
    face.light = std::clamp(0.5 + 0.5 * normal.dot(Eigen::Vector3d(-0.4, 0.7, 0.6)), 0.0, 1.0);
    face.of_rope = of_rope;
    faces_->push_back(std::move(face));
  }

 private:
  Eigen::Matrix3d eye_;
  std::vector<ShownFace>* faces_;
};

void AddLink(const Pose& X_WL, const Rope& rope, FaceList* list) {
  const double half = 0.5 * rope.thickness;
  const std::array<Eigen::Vector2d, 4> section{
      Eigen::Vector2d(-half, -half), {half, -half}, {half, half}, {-half, half}};
  const double begin = 0.5 * rope.gap, length = rope.pitch - rope.gap;
  const auto at = [&](double x, int k) { return X_WL * Eigen::Vector3d(x, section[k].x(), section[k].y()); };
  for (int piece = 0; piece < kPieces; ++piece) {
    const double from = begin + length * piece / kPieces, to = begin + length * (piece + 1) / kPieces;
    for (int k = 0; k < 4; ++k) {
      const int next = (k + 1) % 4;
      list->Add({at(from, k), at(from, next), at(to, next), at(to, k)}, true);
    }
    if (piece == 0) list->Add({at(from, 3), at(from, 2), at(from, 1), at(from, 0)}, true);
    if (piece == kPieces - 1) list->Add({at(to, 0), at(to, 1), at(to, 2), at(to, 3)}, true);
  }
}

}  // namespace

Eigen::Matrix3d CalcEye(const Eigen::Vector3d& gravity_W) {
  const Eigen::Vector3d up = -gravity_W.normalized();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX() - up.x() * up;
  right = right.norm() > 1e-3 ? right.normalized() : up.unitOrthogonal();
  Eigen::Matrix3d upright;
  upright << right.transpose(), up.transpose(), right.cross(up).transpose();
  return (Eigen::AngleAxisd(kFromAbove, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(kFromTheEnd, Eigen::Vector3d::UnitY()))
             .toRotationMatrix() *
         upright;
}

std::vector<ShownFace> CalcShownFaces(const TriangleMesh& tool, const std::vector<Pose>& X_WL, const Rope& rope,
                                      const Eigen::Matrix3d& eye) {
  std::vector<ShownFace> faces;
  FaceList list(eye, &faces);
  for (const Eigen::Vector3i& t : tool.triangles) {
    list.Add({tool.vertices[t[0]], tool.vertices[t[1]], tool.vertices[t[2]]}, false);
  }
  for (const Pose& link : X_WL) AddLink(link, rope, &list);
  std::stable_sort(faces.begin(), faces.end(),
                   [](const ShownFace& a, const ShownFace& b) { return a.depth < b.depth; });
  return faces;
}

}  // namespace knap
