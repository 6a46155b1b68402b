// Whether a mesh can be printed: as a body, and by a nozzle on a bed.
//
// Errors, which no slicer can mend for sure: what FindDefects finds. The rest is told, and a person decides:
//
//   wall      the least w of shape_measures.h, looked at from many points of the surface; below the nozzle's width a
//             slicer drops it or makes it thicker
//   gap       likewise outwards, from one part of the surface to another; below the nozzle's width it is filled
//   size      the bed is too small for it as it stands, also turned by 90 degrees
//   overhang  what faces down by more than 45 degrees from a wall that stands, and does not lie on the bed (its
//             lowest 0.1 mm): it needs support, or another side down
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/geometry/triangle_mesh.h"

namespace knap {

struct Printer {
  double nozzle = 0.4e-3;                    // its width [m]
  Eigen::Vector3d bed{0.250, 0.210, 0.210};  // width, depth and height [m]
};

struct PrintFinding {
  std::string kind;  // "mesh", "wall", "gap", "size" or "overhang"
  bool is_error = false;
  std::string text;                        // one line without a full stop
  std::optional<Eigen::Vector3d> place{};  // in the mesh's frame [m]; none where all of it is meant
};

// A thickness and the place where it is [m].
struct NarrowPlace {
  double width = 0.0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double share = 0.0;  // of the surface where it is below the nozzle's
};

struct PrintCheck {
  std::vector<PrintFinding> findings;  // errors first, and alone where there are any
  // Without meaning for a mesh with errors.
  double volume = 0.0;                       // [m³]
  Eigen::AlignedBox3d box{};                 // [m]
  std::optional<NarrowPlace> wall{}, gap{};  // none where nothing faces anything
  double overhang = 0.0;                     // share of the surface
  double steepest = 0.0;  // of it: the largest angle from a wall that stands, 90° for a ceiling [rad]

  bool HasErrors() const { return !findings.empty() && findings.front().is_error; }
};

// `mesh` stands with z up. Any content is allowed, also indices out of range. Takes seconds for 50,000 triangles.
PrintCheck CheckPrint(const TriangleMesh& mesh, const Printer& printer);

}  // namespace knap
