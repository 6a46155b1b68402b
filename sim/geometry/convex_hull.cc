#include "sim/geometry/convex_hull.h"

#include <Eigen/Geometry>
#include <array>
#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>

// Last, for its macros.
#include <libqhull_r/qhull_ra.h>

namespace knap {
namespace {

using Eigen::Vector3d;

constexpr double kNoArea = 1e-12;  // of a triangle, of the size's square

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// Qhull's state of one computation.
class Qhull {
 public:
  Qhull() : errors_(std::fopen("/dev/null", "w")) {
    if (errors_ == nullptr) throw std::runtime_error("cannot open /dev/null");
    qh_zero(&qh_, errors_.get());
  }
  ~Qhull() {
    qh_freeqhull(&qh_, !qh_ALL);
    int kept = 0;
    int total = 0;
    qh_memfreeshort(&qh_, &kept, &total);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  // The hull's triangles, by point and turned either way; empty for points in a plane. `coordinates`: three a point.
  std::vector<Eigen::Vector3i> Run(std::vector<double>* coordinates) {
    char options[] = "qhull Qt Pp";
    const int failed = qh_new_qhull(&qh_, 3, static_cast<int>(coordinates->size() / 3), coordinates->data(), False,
                                    options, nullptr, errors_.get());
    if (failed == qh_ERRmem) throw std::bad_alloc();
    std::vector<Eigen::Vector3i> triangles;
    if (failed != qh_ERRnone) return triangles;
    for (facetT* facet = qh_.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
      std::array<int, 3> corners{};
      std::size_t count = 0;
      for (vertexT** vertex = SETaddr_(facet->vertices, vertexT); *vertex != nullptr && count < 3; ++vertex) {
        corners[count++] = qh_pointid(&qh_, (*vertex)->point);
      }
      if (count == 3) triangles.emplace_back(corners[0], corners[1], corners[2]);
    }
    return triangles;
  }

 private:
  std::unique_ptr<std::FILE, CloseFile> errors_;
  qhT qh_;
};

}  // namespace

std::optional<TriangleMesh> MakeConvexHull(const std::vector<Vector3d>& points) {
  if (points.size() < 4) return std::nullopt;
  std::vector<double> coordinates;
  Eigen::AlignedBox3d box;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points) {
    coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
    box.extend(p);
    middle += p / static_cast<double>(points.size());
  }
  const double size = box.diagonal().norm();
  std::vector<int> number(points.size(), -1);
  std::vector<Eigen::Vector3i> triangles;
  for (const Eigen::Vector3i& t : Qhull().Run(&coordinates)) {
    const Vector3d& a = points[t[0]];
    const Vector3d area = (points[t[1]] - a).cross(points[t[2]] - a);
    if (area.norm() < kNoArea * size * size) continue;
    const bool outward = area.dot(a - middle) > 0.0;
    triangles.emplace_back(t[0], outward ? t[1] : t[2], outward ? t[2] : t[1]);
    for (const int corner : t) number[corner] = 0;
  }
  if (triangles.empty()) return std::nullopt;
  TriangleMesh hull;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(hull.vertices.size());
    hull.vertices.push_back(points[i]);
  }
  for (const Eigen::Vector3i& t : triangles) hull.triangles.emplace_back(number[t[0]], number[t[1]], number[t[2]]);
  return hull;
}

}  // namespace knap
