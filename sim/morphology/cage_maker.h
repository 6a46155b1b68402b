// A cage around a mesh, made of rings of vertices along an axis, with what may be learned about it.
//
// Rings, the stations, stand at equal distances from one end of the mesh to the other. A ring's outline is
//
//   box     the rectangle around the whole mesh, seen along the axis
//   prism   the octagon around it: closest where the tool is round
//   fitted  the rectangle around the mesh between the neighbouring stations: closest where it is thick here and thin
//   there
//
// all of it wider than the mesh by a margin, so that no vertex of the mesh comes near a face, where mean value
// coordinates belong to that face alone. Between two stations faces are flat, and the mesh lies within.
//
// Parameters, with a the axis and b < c the others in the order x, y, z:
//
//   length_i        between stations i and i + 1, along a; moves all stations after i
//   width_i         of station i, along b; both sides move by half of it
//   height_i        likewise along c
//   offset_i_b, _c  of station i as a whole
//
// i counts from 1. Values of a mesh as it is on file are its own measures, to four digits; bounds are 0.6 and 1.5 times
// that, and for offsets 0.3 times the distance of two stations to either side. Where the mesh ends in a point, twice
// the margin stands for its width.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/geometry/triangle_mesh.h"
#include "sim/morphology/cage_design.h"

namespace knap {

enum class CageShape { kBox, kPrism, kFitted };

struct CageOptions {
  int axis = 0;      // 0, 1, 2 for x, y, z
  int stations = 4;  // 2 or more
  CageShape shape = CageShape::kBox;
  double margin = 0.0;  // [m], more than 0
};

struct CageGroup {
  std::string name;           // "station_2", "station_2_high_y"
  std::vector<int> vertices;  // of the cage, ascending
};

struct CageParameter {
  std::string name;
  double initial = 0.0, lower = 0.0, upper = 0.0;  // [m]
  struct Move {
    int group = 0;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  };
  std::vector<Move> moves;
};

struct MadeCage {
  TriangleMesh cage;
  std::vector<CageGroup> groups;
  std::vector<CageParameter> parameters;

  // For CageDesign, by parameter and vertex, and its initial theta.
  std::vector<VertexMove> ListMoves() const;
  Eigen::VectorXd GetInitialTheta() const;
};

// The margin that is usual: a hundredth of the diagonal of the mesh's box.
double CalcUsualMargin(const TriangleMesh& mesh);

// The mesh is one that FindDefects finds sound. Throws std::invalid_argument with one line for fewer than two stations,
// and where the mesh does not lie in the cage that was made.
MadeCage MakeCage(const TriangleMesh& mesh, const CageOptions& options);

}  // namespace knap
