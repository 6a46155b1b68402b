// The depth of a place in a field as its header says it, cell and all, for what is found otherwise to be held against.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "sim/contact/depth_field.h"

namespace knap::test {

// Negative outside.
inline double CalcFieldDepth(const DepthField& field, const Eigen::Vector3d& x, int* cell) {
  *cell = 0;
  if (const auto* polyhedron = std::get_if<PolyhedralField>(&field)) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < static_cast<int>(polyhedron->planes.size()); ++i) {
      const double e = polyhedron->planes[i].d - polyhedron->planes[i].n.dot(x);
      if (e < least) {
        least = e;
        *cell = i;
      }
    }
    return least;
  }
  if (const auto* cylinder = std::get_if<CylinderField>(&field)) {
    const Eigen::Vector3d d = x - cylinder->center;
    const double z = cylinder->axis.dot(d);
    const double r = cylinder->radius;
    const double side = (r * r - (d - z * cylinder->axis).squaredNorm()) / (2.0 * r);
    return std::min(side, cylinder->half_length - std::abs(z));
  }
  const RoundField& round = std::get<RoundField>(field);
  const double along = std::clamp(round.axis.dot(x - round.center), -round.half_length, round.half_length);
  const double d2 = (x - round.center - along * round.axis).squaredNorm();
  return (round.radius * round.radius - d2) / (2.0 * round.radius);
}

}  // namespace knap::test
