// Measures of a body's shape, and how they change with its vertices.
//
//   volume     V, in closed form (mass_properties.h); exact and smooth
//   extent     the largest coordinate along an axis less the least. Exact; its gradient is that of the two vertices
//              which are farthest, the first ones where several are
//   thickness  a smooth least of the walls' thicknesses, as follows
//
// The wall behind triangle i is met by the ray from its centre p against its outward normal n, which leaves the body
// through a triangle of normal m at the distance t. Where both faces are parallel, t is the wall's thickness. Where
// they open at an angle alpha, with c = −n·m = cos alpha, they are the less a wall:
//
//   w_i = t / c²        t at 0°, 1.3 t at 30°, 2 t at 45°, 4 t at 60°; at 90° an edge of the body, not a wall
//
//   T = Σ A_i e_i w_i / Σ A_i e_i,   e_i = exp(−(w_i − min w)/blend)
//
// over all triangles, A their areas. T lies between the least w and a few blends above it, and is the wall's thickness
// where there is one. It is smooth but where a ray passes from one triangle to its neighbour, where its slope may jump,
// or slips off an edge of what it met, where w itself does: only triangles' centres are looked at, so that a mesh has
// to be as fine as what is to be measured.
#pragma once

#include <Eigen/Core>

#include "sim/geometry/ray_caster.h"
#include "sim/geometry/triangle_mesh.h"

namespace knap {

struct ShapeMeasure {
  double value = 0.0;
  Eigen::Matrix3Xd gradient;  // dvalue/dvertex, 3 × vertices
};

// Of a mesh that FindDefects finds sound. Volume [m³], extent along x, y or z (0, 1, 2) [m], and thickness with a blend
// of more than 0 [m].
ShapeMeasure MeasureVolume(const TriangleMesh& mesh);
ShapeMeasure MeasureExtent(const TriangleMesh& mesh, int axis);
ShapeMeasure MeasureThickness(const TriangleMesh& mesh, double blend);

// w as above for any hit.
inline double CalcWall(const RayCaster::Hit& hit) { return hit.distance / (hit.facing * hit.facing); }

}  // namespace knap
