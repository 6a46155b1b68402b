#include "sim/geometry/print_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sim/geometry/ray_caster.h"
#include "sim/geometry/shape_measures.h"

namespace knap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Points that are looked at lie about two nozzles apart, as long as they are no more than these.
constexpr double kMostPoints = 100000.0;
constexpr double kOnTheBed = 0.1e-3;  // [m]
// Faces that open at more than 60 degrees are edges and corners, at which there is nothing to be held apart.
constexpr double kLeastFacing = 0.5;
constexpr double kSteep = std::numbers::sqrt2 / 2.0;  // sine of the angle at which walls begin to hang over

struct Patch {
  Vector3d center, normal;
  double area = 0.0;
};

Patch MakePatch(const TriangleMesh& mesh, const Vector3i& t) {
  const Vector3d& a = mesh.vertices[t[0]];
  const Vector3d& b = mesh.vertices[t[1]];
  const Vector3d& c = mesh.vertices[t[2]];
  const Vector3d cross = (b - a).cross(c - a);
  return {(a + b + c) / 3.0, cross.stableNormalized(), 0.5 * cross.norm()};
}

// Calls visit(point) at the centres of n² equal parts of a triangle.
template <class Visit>
void VisitParts(const TriangleMesh& mesh, const Vector3i& t, int n, const Visit& visit) {
  const Vector3d& a = mesh.vertices[t[0]];
  const Vector3d u = (mesh.vertices[t[1]] - a) / n;
  const Vector3d v = (mesh.vertices[t[2]] - a) / n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      visit(Vector3d(a + (i + 1.0 / 3.0) * u + (j + 1.0 / 3.0) * v));
      if (i + j + 1 < n) visit(Vector3d(a + (i + 2.0 / 3.0) * u + (j + 2.0 / 3.0) * v));
    }
  }
}

class NarrowSearch {
 public:
  NarrowSearch(const RayCaster& caster, double nozzle, RayCaster::Crossing crossing)
      : caster_(caster), nozzle_(nozzle), crossing_(crossing) {}

  void Look(const Vector3d& p, const Patch& patch, int triangle, double area) {
    const bool inward = crossing_ == RayCaster::Crossing::kLeaving;
    const auto hit =
        caster_.FindNext(p, inward ? Vector3d(-patch.normal) : patch.normal, triangle, crossing_, &scratch_);
    if (!hit || hit->facing < kLeastFacing) return;
    const double w = CalcWall(*hit);
    if (w < nozzle_) narrow_area_ += area;
    if (!found_ || w < found_->width) found_ = NarrowPlace{w, p, 0.0};
  }

  std::optional<NarrowPlace> Finish(double surface) const {
    std::optional<NarrowPlace> out = found_;
    if (out) out->share = narrow_area_ / surface;
    return out;
  }

 private:
  const RayCaster& caster_;
  const double nozzle_;
  const RayCaster::Crossing crossing_;
  std::vector<int> scratch_;
  std::optional<NarrowPlace> found_;
  double narrow_area_ = 0.0;
};

void FindNarrow(const TriangleMesh& mesh, const std::vector<Patch>& patches, double surface, double nozzle,
                PrintCheck* out) {
  const RayCaster caster(mesh);
  NarrowSearch walls(caster, nozzle, RayCaster::Crossing::kLeaving);
  NarrowSearch gaps(caster, nozzle, RayCaster::Crossing::kEntering);
  // A part of a triangle, of half the square of the points' distance.
  const double part = std::max(2.0 * nozzle * nozzle, surface / kMostPoints);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(patches[i].area / part))));
    VisitParts(mesh, mesh.triangles[i], n, [&](const Vector3d& p) {
      walls.Look(p, patches[i], static_cast<int>(i), patches[i].area / (n * n));
      gaps.Look(p, patches[i], static_cast<int>(i), patches[i].area / (n * n));
    });
  }
  out->wall = walls.Finish(surface);
  out->gap = gaps.Finish(surface);
  const auto tell = [&](const std::optional<NarrowPlace>& narrow, const char* kind, const char* what) {
    if (!narrow || narrow->width >= nozzle) return;
    out->findings.push_back(
        {kind, false,
         fmt::format("{} {:.3g} mm across, less than the nozzle's {:.3g} mm, as {:.2g}% of the surface", what,
                     1e3 * narrow->width, 1e3 * nozzle, 100.0 * narrow->share),
         narrow->place});
  };
  tell(out->wall, "wall", "a wall is");
  tell(out->gap, "gap", "a gap is");
}

void CheckSize(const Vector3d& size, const Vector3d& bed, PrintCheck* out) {
  const auto fits = [&](double x, double y, double z) { return x <= bed.x() && y <= bed.y() && z <= bed.z(); };
  const auto stands = [&](double x, double y, double z) { return fits(x, y, z) || fits(y, x, z); };
  const double x = size.x(), y = size.y(), z = size.z();
  if (stands(x, y, z)) return;
  const bool lies = stands(x, z, y) || stands(y, z, x);
  out->findings.push_back(
      {"size", false,
       fmt::format("{:.4g} x {:.4g} x {:.4g} mm do not fit on the bed, {:.4g} x {:.4g} x {:.4g} mm{}", 1e3 * x, 1e3 * y,
                   1e3 * z, 1e3 * bed.x(), 1e3 * bed.y(), 1e3 * bed.z(),
                   lies ? "; lying on another side they do" : "")});
}

void FindOverhangs(const std::vector<Patch>& patches, double surface, double lowest, PrintCheck* out) {
  double area = 0.0, lowest_normal = 0.0, largest = 0.0;
  Vector3d place = Vector3d::Zero();
  for (const Patch& patch : patches) {
    const double down = -patch.normal.z();
    // 1e-9: a face at 45 degrees, rounded, does not hang over.
    if (down <= kSteep + 1e-9 || patch.center.z() < lowest + kOnTheBed) continue;
    area += patch.area;
    lowest_normal = std::max(lowest_normal, std::min(down, 1.0));
    if (patch.area > largest) {
      largest = patch.area;
      place = patch.center;
    }
  }
  if (area == 0.0) return;
  out->overhang = area / surface;
  out->steepest = std::asin(lowest_normal);
  out->findings.push_back({"overhang", false,
                           fmt::format("{:.2g}% of the surface hangs over by more than 45 degrees, up to {:.0f}",
                                       100.0 * out->overhang, out->steepest * 180.0 / std::numbers::pi),
                           place});
}

}  // namespace

PrintCheck CheckPrint(const TriangleMesh& mesh, const Printer& printer) {
  PrintCheck out;
  const MeshDefects defects = FindDefects(mesh);
  if (!defects.empty()) {
    out.findings.push_back({"mesh", true, defects.Describe(), defects.place});
    return out;
  }
  out.volume = CalcSignedVolume(mesh);
  out.box = CalcBoundingBox(mesh);
  std::vector<Patch> patches;
  double surface = 0.0;
  for (const Vector3i& t : mesh.triangles) {
    patches.push_back(MakePatch(mesh, t));
    surface += patches.back().area;
  }
  FindNarrow(mesh, patches, surface, printer.nozzle, &out);
  CheckSize(out.box.sizes(), printer.bed, &out);
  FindOverhangs(patches, surface, out.box.min().z(), &out);
  return out;
}

}  // namespace knap
