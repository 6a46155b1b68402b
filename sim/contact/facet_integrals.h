// A plane facet of one body's surface in the depth field of another: what it adds to a patch, exactly.
//
//   F = −E ∫ e n dA   M = −E ∫ e x × n dA   W = ∫ e dA   m1 = ∫ e x dA   m2 = ∫ e x xᵀ dA
//
// over the part of the facet where e > 0, cell by cell, n the facet's outward normal. That part is a polygon cut by the
// cell's walls, or by the circle, ellipse or strip in which its plane meets a round field; e and its gradient are
// polynomials there, so that all integrals are sums of the region's moments (planar_moments.h).
//
// Derivatives when the facet's points move with velocity v, the field standing still:
//
//   d ∫ e ψ dA = ∫ (∇e·v) ψ + e dψ dA + ∫ e ψ d(dA) − Σ_walls ∮ e ψ (v·w)/|w_t| dl
//
// The last term is what flows through a wall w·x ≤ b between two cells, w_t the part of w in the facet's plane: it
// cancels in sums over all cells, but not in the patch of one. On the field's surface e = 0, and nothing flows.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/contact/depth_field.h"
#include "sim/contact/patch_integrals.h"

namespace knap {

// Three corners, or four in a plane; counter-clockwise as seen from outside.
struct Facet {
  static constexpr int kMaxCorners = 4;
  int size = 3;
  std::array<Eigen::Vector3d, kMaxCorners> corner;
};

// A number for each cell of the field: patches.size() = CountCells(field). `jacobians` of the same size, or null. All
// added, E left out (as if 1), and what turns rigidly with B left to FinishJacobian.
int CountCells(const DepthField& field);
void AddFacet(const Facet& facet, const DepthField& field, std::vector<PatchIntegrals>* patches,
              std::vector<PatchJacobian>* jacobians);

// Of all facets' sums: adds how F, M, m1 and m2 move because normals and places move with B.
void FinishJacobian(const PatchIntegrals& patch, PatchJacobian* jacobian);

// Cotangents of a triangle's corners in S, added, from those of the patches of all cells (E left out likewise).
void PullBackFacet(const Facet& triangle, const DepthField& field, const std::vector<PatchCotangent>& bar,
                   std::array<Eigen::Vector3d, 3>* bar_corners);

}  // namespace knap
