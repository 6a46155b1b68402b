#include "sim/contact/contact_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/contact/convex_field.h"
#include "sim/contact/facet_integrals.h"
#include "sim/contact/moving_pieces.h"
#include "sim/contact/pair_rules.h"
#include "sim/math/overloaded.h"

namespace knap {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
bool Is(const ContactGeometry& shape) {
  return std::holds_alternative<T>(shape);
}

TouchingKind GetKind(const ContactGeometry& shape) {
  return std::visit(Overloaded{[](const HalfSpaceGeometry&) { return TouchingKind::kHalfSpace; },
                               [](const SphereGeometry&) { return TouchingKind::kSphere; },
                               [](const CapsuleGeometry&) { return TouchingKind::kCapsule; },
                               [](const CylinderGeometry&) { return TouchingKind::kCylinder; },
                               [](const BoxGeometry&) { return TouchingKind::kBox; },
                               [](const MeshGeometry& mesh) {
                                 return mesh.IsDesigned() ? TouchingKind::kDesignedMesh : TouchingKind::kConvexMesh;
                               }},
                    shape);
}

bool IsRound(const ContactGeometry& shape) { return Is<SphereGeometry>(shape) || Is<CapsuleGeometry>(shape); }

RoundField MakeRound(const ContactGeometry& shape) {
  if (const auto* sphere = std::get_if<SphereGeometry>(&shape)) return {sphere->radius, 0.0, sphere->center};
  const CapsuleGeometry& capsule = std::get<CapsuleGeometry>(shape);
  return {capsule.radius, capsule.half_length, capsule.center, capsule.axis};
}

// The least half width; infinite where nothing bounds it.
double CalcHalfWidth(const ContactGeometry& shape) {
  if (IsRound(shape)) return MakeRound(shape).radius;
  if (const auto* cylinder = std::get_if<CylinderGeometry>(&shape)) {
    return std::min(cylinder->radius, cylinder->half_length);
  }
  if (const auto* box = std::get_if<BoxGeometry>(&shape)) return box->half.minCoeff();
  if (const auto* mesh = std::get_if<MeshGeometry>(&shape)) {
    return mesh->field ? mesh->field->deepest : 0.5 * mesh->mesh->bounds().sizes().minCoeff();
  }
  return kInfinity;
}

// `touching`: which of the contact's two is B. `piece` of the other, where that is a designed mesh.
ContactSide MakeSide(const ContactPair& contact, int touching, double share, int piece) {
  const ContactGeometry& shape = contact.shapes[touching];
  const ContactGeometry& other = contact.shapes[1 - touching];
  ContactSide side;
  side.body = contact.bodies[touching];
  side.field_body = contact.bodies[1 - touching];
  side.shape = touching;
  side.modulus = share * contact.material.stiffness;
  side.size = std::min(CalcHalfWidth(shape), CalcHalfWidth(other));
  side.deepest = side.size;
  for (const ContactGeometry* s : {&other, &shape}) {
    if (const auto* sphere = std::get_if<SphereGeometry>(s)) side.rolling_radius = sphere->radius;
  }
  if (const auto* box = std::get_if<BoxGeometry>(&other)) {
    side.field = PolyhedralField::MakeBox(box->half, box->center, box->R);
  } else if (const auto* solid = std::get_if<MeshGeometry>(&other)) {
    if (solid->IsDesigned()) {
      side.pieces = solid->pieces;
      side.piece = piece;
    }
    side.field = solid->IsDesigned() ? solid->pieces->fields[static_cast<std::size_t>(piece)] : *solid->field;
    side.deepest = std::min(side.size, std::get<PolyhedralField>(side.field).deepest);
  } else if (IsRound(other)) {
    side.field = MakeRound(other);
    side.deepest = std::min(side.size, 0.5 * CalcHalfWidth(other));
  } else if (const auto* cylinder = std::get_if<CylinderGeometry>(&other)) {
    side.field = CylinderField{cylinder->radius, cylinder->half_length, cylinder->center, cylinder->axis};
    side.deepest = std::min({side.size, 0.5 * cylinder->radius, cylinder->half_length});
  } else {
    side.field = PolyhedralField::MakeHalfSpace(std::get<HalfSpaceGeometry>(other).plane);
  }
  if (IsRound(shape)) {
    const RoundField round = MakeRound(shape);
    side.axis = RoundAxis{round.center, round.axis, round.half_length, round.radius};
    if (IsRound(other)) side.deepest = std::min(side.size, 0.5 * (round.radius + CalcHalfWidth(other)));
  } else if (const auto* cylinder = std::get_if<CylinderGeometry>(&shape)) {
    if (Is<HalfSpaceGeometry>(other)) {
      side.cylinder = SolidCylinder{cylinder->center, cylinder->axis, cylinder->half_length, cylinder->radius};
    } else {
      side.facets = std::make_shared<ContactMesh>(ContactMesh::MakeCylinder(*cylinder));
    }
  } else if (const auto* box = std::get_if<BoxGeometry>(&shape)) {
    side.facets = std::make_shared<ContactMesh>(ContactMesh::MakeBox(*box));
  } else {
    const MeshGeometry& mesh = std::get<MeshGeometry>(shape);
    side.facets = mesh.mesh;
    side.is_designed = mesh.IsDesigned();
  }
  return side;
}

// A designed mesh that should meet no other has none.
int CountFields(const ContactGeometry& shape) {
  const auto* mesh = std::get_if<MeshGeometry>(&shape);
  if (mesh == nullptr || !mesh->IsDesigned()) return 1;
  return mesh->pieces ? static_cast<int>(mesh->pieces->fields.size()) : 0;
}

// Of a half-space.
const FieldPlane& GetPlane(const DepthField& field) { return std::get<PolyhedralField>(field).planes.front(); }

// Whether a ball in S may reach the field.
bool MayReach(const PolyhedralField& field, const Vector3d& center, double radius) {
  for (const FieldPlane& plane : field.planes) {
    if (plane.CalcHeight(center) >= radius) return false;
  }
  return true;
}

bool MayReach(const RoundField& field, const Vector3d& center, double radius) {
  const Vector3d x = center - field.center;
  const double along = std::clamp(field.axis.dot(x), -field.half_length, field.half_length);
  const double reach = field.radius + radius;
  return (x - along * field.axis).squaredNorm() < reach * reach;
}

bool MayReach(const CylinderField& field, const Vector3d& center, double radius) {
  const Vector3d x = center - field.center;
  const double along = field.axis.dot(x);
  const double reach = field.radius + radius;
  return std::abs(along) < field.half_length + radius && x.squaredNorm() - along * along < reach * reach;
}

bool MayReach(const DepthField& field, const Vector3d& center, double radius) {
  return std::visit([&](const auto& f) { return MayReach(f, center, radius); }, field);
}

// Whether the circle in which a facet's plane meets a sphere may reach the facet, all in B: not if it lies outside of
// one of the edges. Of the facets near a sphere nine in ten are missed.
bool MayReach(const Facet& facet, const Vector3d& center_B, double radius) {
  const double h = facet.frame.n.dot(center_B - facet.frame.o);
  const double circle = radius * radius - h * h;  // its radius, squared
  if (circle <= 0.0) return false;
  const Vector2d s = facet.frame.Locate(center_B);
  for (int k = 0; k < facet.size; ++k) {
    const Vector2d edge = facet.corner[(k + 1) % facet.size] - facet.corner[k];
    const Vector2d to = s - facet.corner[k];
    const double inward = edge.x() * to.y() - edge.y() * to.x();
    if (inward < 0.0 && inward * inward > circle * edge.squaredNorm()) return false;
  }
  return true;
}

// The facets near the field are cut, ascending.
void CutNearFacets(const ContactSide& side, NearFacets* near, const Pose& X_SB, FacetRegions* out) {
  out->clear();
  const ContactMesh& mesh = *side.facets;
  const auto* round = std::get_if<RoundField>(&side.field);
  const bool is_sphere = round != nullptr && round->half_length == 0.0;
  const Vector3d center_B = is_sphere ? X_SB.ApplyInverse(round->center) : Vector3d::Zero();
  for (const int i : near->Find(side, X_SB)) {
    const Facet& facet = mesh.facets()[i];
    const ContactMesh::Ball& ball = mesh.balls()[i];
    const bool may_reach =
        is_sphere ? MayReach(facet, center_B, round->radius) : MayReach(side.field, X_SB * ball.center, ball.radius);
    if (may_reach) CutFacet(i, Move(X_SB, facet), side.field, out);
  }
}

}  // namespace

std::vector<ContactSide> MakeSides(const std::vector<ContactPair>& contacts) {
  std::vector<ContactSide> sides;
  int next_id = 0;
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    const ContactPair& contact = contacts[i];
    const auto& [a, b] = contact.shapes;
    const PairRule rule = FindPairRule(GetKind(a), GetKind(b));
    if (rule == PairRule::kNone) {
      throw std::invalid_argument(fmt::format("contact {}: {}", i, DescribeNoTouch(GetKind(a), GetKind(b))));
    }
    for (int touching = 0; touching < 2; ++touching) {
      if (rule == (touching == 0 ? PairRule::kSecond : PairRule::kFirst)) continue;
      const int fields = CountFields(contact.shapes[1 - touching]);
      if (fields == 0) throw std::invalid_argument(fmt::format("contact {}: a designed mesh without pieces", i));
      for (int piece = 0; piece < fields; ++piece) {
        ContactSide& side = sides.emplace_back(MakeSide(contact, touching, rule == PairRule::kBoth ? 0.5 : 1.0, piece));
        side.pair = i;
        side.first_id = next_id;
        next_id += side.num_cells();
      }
    }
  }
  return sides;
}

NearFacets::NearFacets(const ContactSide& side) {
  if (side.axis) {
    center_B_ = side.axis->center;
    radius_B_ = side.axis->half_length + side.axis->radius;
  } else if (side.cylinder) {
    center_B_ = side.cylinder->center;
    radius_B_ = (1.0 + 1e-9) * std::hypot(side.cylinder->half_length, side.cylinder->radius);
  } else {
    center_B_ = side.facets->bounds().center();
    radius_B_ = (1.0 + 1e-9) * 0.5 * side.facets->bounds().diagonal().norm();
    found_.reserve(side.facets->facets().size());
  }
  if (const auto* round = std::get_if<RoundField>(&side.field)) {
    const Vector3d reach = Vector3d::Constant(round->radius) + (round->half_length * round->axis).cwiseAbs();
    field_ = AlignedBox3d(round->center - reach, round->center + reach);
    radius_S_ = (1.0 + 1e-9) * (round->half_length + round->radius);
  } else if (const auto* cylinder = std::get_if<CylinderField>(&side.field)) {
    const Vector3d across = (Vector3d::Ones() - cylinder->axis.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    const Vector3d reach = cylinder->radius * across + cylinder->half_length * cylinder->axis.cwiseAbs();
    field_ = AlignedBox3d(cylinder->center - reach, cylinder->center + reach);
    radius_S_ = (1.0 + 1e-9) * std::hypot(cylinder->half_length, cylinder->radius);
  } else {
    const auto& polyhedron = std::get<PolyhedralField>(side.field);
    plane_ = polyhedron.planes.front();
    field_ = polyhedron.bounds;
    radius_S_ = field_.isEmpty() ? kInfinity : (1.0 + 1e-9) * 0.5 * field_.diagonal().norm();
  }
}

bool NearFacets::MayTouch(const Pose& X_WB, const Pose& X_WS) const {
  const Vector3d center = X_WB * center_B_;
  if (std::isinf(radius_S_)) return plane_.CalcHeight(X_WS.ApplyInverse(center)) < radius_B_;
  const double reach = radius_B_ + radius_S_;
  return (center - X_WS * field_.center()).squaredNorm() <= reach * reach;
}

const std::vector<int>& NearFacets::Find(const ContactSide& side, const Pose& X_SB) {
  const Pose X_BS{X_SB.R.transpose(), -(X_SB.R.transpose() * X_SB.p)};
  const bool infinite = std::isinf(radius_S_);
  // No place of either body that counts has moved by more than this against the other since the list was made.
  const Vector3d moved = infinite ? Vector3d(X_SB * center_B_ - X_BS_.ApplyInverse(center_B_))
                                  : Vector3d(X_BS * field_.center() - X_BS_ * field_.center());
  const double turned = (X_BS.R - X_BS_.R).norm() * (infinite ? radius_B_ : radius_S_);
  if (valid_ && moved.norm() + turned < margin_) return found_;
  valid_ = true;
  X_BS_ = X_BS;
  margin_ = 0.25 * side.size;
  if (infinite) {
    found_.clear();
    for (int i = 0; i < static_cast<int>(side.facets->facets().size()); ++i) {
      const ContactMesh::Ball& ball = side.facets->balls()[i];
      if (plane_.CalcHeight(X_SB * ball.center) < ball.radius + margin_) found_.push_back(i);
    }
    return found_;
  }
  const Vector3d half = X_BS.R.cwiseAbs() * (0.5 * field_.sizes()) + Vector3d::Constant(margin_);
  const Vector3d middle = X_BS * field_.center();
  side.facets->FindFacets(AlignedBox3d(middle - half, middle + half), &found_);
  std::erase_if(found_, [&](int i) {
    const ContactMesh::Ball& ball = side.facets->balls()[i];
    return !MayReach(side.field, X_SB * ball.center, ball.radius + margin_);
  });
  return found_;
}

void CalcPatches(const ContactSide& side, NearFacets* near, const Pose& X_SB, SidePatches* out) {
  out->X_SB = X_SB;
  out->patches.assign(static_cast<std::size_t>(side.num_cells()), PatchIntegrals{});
  if (side.axis) {
    CalcAxis(side.axis->Move(X_SB), side.field, &out->patches[0], nullptr);
  } else if (side.cylinder) {
    CalcCylinder(side.cylinder->Move(X_SB), GetPlane(side.field), &out->patches[0], nullptr);
  } else {
    CutNearFacets(side, near, X_SB, &out->facets);
    for (const FacetRegion& region : out->facets.regions) {
      AddRegion(region, &out->patches[static_cast<std::size_t>(region.cell)]);
    }
  }
  for (PatchIntegrals& patch : out->patches) {
    patch.F *= side.modulus;
    patch.M *= side.modulus;
  }
}

void CalcPatchJacobians(const ContactSide& side, SidePatches* out) {
  out->jacobians.assign(out->patches.size(), PatchJacobian::Zero());
  if (side.axis || side.cylinder) {
    PatchIntegrals again;
    if (side.axis) {
      CalcAxis(side.axis->Move(out->X_SB), side.field, &again, &out->jacobians[0]);
    } else {
      CalcCylinder(side.cylinder->Move(out->X_SB), GetPlane(side.field), &again, &out->jacobians[0]);
    }
    out->jacobians[0].topRows<6>() *= side.modulus;
    return;
  }
  for (const FacetRegion& region : out->facets.regions) {
    AddRegionJacobian(region, out->facets.walls, &out->jacobians[static_cast<std::size_t>(region.cell)]);
  }
  for (std::size_t cell = 0; cell < out->patches.size(); ++cell) {
    if (!out->patches[cell].active()) continue;
    out->jacobians[cell].topRows<6>() *= side.modulus;
    FinishJacobian(out->patches[cell], &out->jacobians[cell]);
  }
}

void PullBackVertices(const ContactSide& side, const SidePatches& at, std::vector<PatchCotangent> bar,
                      Eigen::Matrix3Xd* bar_B, Eigen::Matrix3Xd* bar_S) {
  for (PatchCotangent& b : bar) {
    b.F *= side.modulus;
    b.M *= side.modulus;
  }
  std::vector<FieldPlane> bar_planes;
  if (side.pieces) bar_planes.assign(bar.size(), FieldPlane{Vector3d::Zero(), 0.0});
  for (const FacetRegion& region : at.facets.regions) {
    const PatchCotangent& of_cell = bar[static_cast<std::size_t>(region.cell)];
    if (side.pieces) PullBackField(region, at.facets.walls, of_cell, bar_planes);
    if (!side.is_designed) continue;
    std::array<Vector3d, 3> bar_corners{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
    PullBackRegion(region, at.facets.walls, Move(at.X_SB, side.facets->facets()[region.facet]), of_cell, &bar_corners);
    for (int k = 0; k < 3; ++k) {
      bar_B->col(side.facets->triangles()[region.facet][k]) += at.X_SB.R.transpose() * bar_corners[k];
    }
  }
  if (side.pieces) PullBackPlanes(*side.pieces, side.piece, bar_planes, bar_S);
}

}  // namespace knap
