// A plane facet of one body's surface cut into the regions in which another body's depth field is > 0 and smooth.
//
// A region is a polygon cut by the walls of a cell, or by the circle, ellipse or strip in which the facet's plane meets
// a round field. All is done in the plane's own coordinates (u, w): a facet's corners never change there, however the
// body moves, and a cell's e is linear. A region has its origin at a corner of its own, or at the foot of a round
// field's centre, so that small regions of large facets lose no digits.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "sim/contact/depth_field.h"
#include "sim/contact/planar_moments.h"
#include "sim/math/pose.h"

namespace knap {

// x = o + u t + w m; t × m = n.
struct PlaneFrame {
  Eigen::Vector3d o, t, m, n;
  Eigen::Vector3d Place(const Eigen::Vector2d& s) const { return o + s.x() * t + s.y() * m; }
  Eigen::Vector2d Locate(const Eigen::Vector3d& x) const { return {t.dot(x - o), m.dot(x - o)}; }
};

// Three corners, or four in a plane; counter-clockwise as seen from outside, where n points. None for one without area.
struct Facet {
  static constexpr int kMaxCorners = 4;
  int size = 0;
  PlaneFrame frame;
  std::array<Eigen::Vector2d, kMaxCorners> corner;

  static Facet Make(std::span<const Eigen::Vector3d> corners);
  Eigen::Vector3d Place(int k) const { return frame.Place(corner[k]); }
};

// The facet of a body that moves: X its pose.
Facet Move(const Pose& X, const Facet& facet);

// e over the monomials 1, u, w, u², uw, w², and ∇e in S over 1, u, w.
struct FieldOnPlane {
  Eigen::Matrix<double, 6, 1> e;
  Eigen::Matrix3d gradient;
  bool linear = false;  // only the first three of e, and the first of the gradient
};

struct FacetRegion {
  int facet = 0;  // the caller's number
  int cell = 0;
  PlaneFrame frame;
  FieldOnPlane field;
  PlanarMoments moments;  // up to the third degree where the field is linear
  double depth = 0.0;     // the largest e, up to rounding on planes, estimated in round fields [m]
  Eigen::Vector2d peak = Eigen::Vector2d::Zero();  // the place of that, a corner, where the field is linear
  int first_wall = 0;                              // of FacetRegions::walls
  int num_walls = 0;
};

// An edge of a region on the wall w·x ≤ b to another cell, `beyond`.
struct WallEdge {
  int beyond = 0;
  Eigen::Vector2d begin, end;
  Eigen::Vector3d w;
  double in_plane = 0.0;  // |w_t|, the part of w in the facet's plane
};

// a + b u + c w.
struct LinearOnPlane {
  double a = 0.0, b = 0.0, c = 0.0;
  double At(const Eigen::Vector2d& s) const { return a + b * s.x() + c * s.y(); }
  LinearOnPlane operator-(const LinearOnPlane& other) const { return {a - other.a, b - other.b, c - other.c}; }
};

// A convex polygon; wall[k]: the inner wall of a cell that edge k lies on, −1 where it is the facet's own or on the
// field's surface.
struct WalledPolygon {
  std::vector<Eigen::Vector2d> corner;
  std::vector<int> wall;
  int size() const { return static_cast<int>(corner.size()); }
  void clear() {
    corner.clear();
    wall.clear();
  }
  void Push(const Eigen::Vector2d& s, int on) {
    corner.push_back(s);
    wall.push_back(on);
  }
};

// The depth under one plane of a field, over a facet.
struct FacetDepth {
  LinearOnPlane e;
  std::array<double, Facet::kMaxCorners> at;  // its corners
  double least = 0.0, most = 0.0;             // of those
};

struct FacetRegions {
  std::vector<FacetRegion> regions;
  std::vector<WallEdge> walls;
  // Scratch of the facet that is cut.
  std::vector<FacetDepth> depths;
  std::vector<int> near;  // the planes whose cells may have a part of the facet
  WalledPolygon polygon, clipped;
  std::vector<double> inside;  // at the polygon's corners
  std::vector<Eigen::Vector2d> turned;
  void clear() {
    regions.clear();
    walls.clear();
  }
};

// (r² − |P (x − c)|²)/(2 r) on a plane.
FieldOnPlane MakeRoundField(const PlaneFrame& plane, const Eigen::Vector3d& c, const Eigen::Matrix3d& P, double r);

// A number for each cell of the field.
int CountCells(const DepthField& field);

// Appends those of one facet, in the order of the cells.
void CutFacet(int number, const Facet& facet, const DepthField& field, FacetRegions* out);

}  // namespace knap
