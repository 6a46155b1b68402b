// What a region of a facet (facet_regions.h) adds to a patch, exactly, and how that moves.
//
//   F = −E ∫ e n dA   M = −E ∫ e x × n dA   W = ∫ e dA   m1 = ∫ e x dA   m2 = ∫ e x xᵀ dA
//
// over the region, n the facet's outward normal: e and its gradient are polynomials there, so that all integrals are
// sums of the region's moments (planar_moments.h).
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
#include <span>

#include "sim/contact/facet_regions.h"
#include "sim/contact/patch_integrals.h"

namespace knap {

// All three add, E left out (as if 1). `walls`: FacetRegions::walls that the region was made with.
void AddRegion(const FacetRegion& region, PatchIntegrals* patch);
// Leaves what turns rigidly with B to FinishJacobian.
void AddRegionJacobian(const FacetRegion& region, std::span<const WallEdge> walls, PatchJacobian* jacobian);

// Of all regions' sums: adds how F, M, m1 and m2 move because normals and places move with B.
void FinishJacobian(const PatchIntegrals& patch, PatchJacobian* jacobian);

// To the cotangents of the corners in S of the triangle that the region is of, from those of its cell's patch (E left
// out likewise).
void PullBackRegion(const FacetRegion& region, std::span<const WallEdge> walls, const Facet& triangle,
                    const PatchCotangent& bar, std::array<Eigen::Vector3d, 3>* bar_corners);

// To the cotangents of the field's planes, one a cell, whose d and n move: what PullBackRegion is to the corners.
//
//   d ∫ e ψ dA = ∫ δe ψ dA + Σ_walls ∮ e ψ (δe_beyond − δe)/|w_t| dl,   δe = δd − δn·x
void PullBackField(const FacetRegion& region, std::span<const WallEdge> walls, const PatchCotangent& bar,
                   std::span<FieldPlane> bar_planes);

}  // namespace knap
