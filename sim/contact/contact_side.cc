#include "sim/contact/contact_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace knap {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
bool Is(const ContactGeometry& shape) {
  return std::holds_alternative<T>(shape);
}

bool IsRound(const ContactGeometry& shape) { return Is<SphereGeometry>(shape) || Is<CapsuleGeometry>(shape); }

RoundField MakeRound(const ContactGeometry& shape) {
  if (const auto* sphere = std::get_if<SphereGeometry>(&shape)) return {sphere->radius, 0.0, sphere->center};
  const CapsuleGeometry& capsule = std::get<CapsuleGeometry>(shape);
  return {capsule.radius, capsule.half_length, capsule.center};
}

// The least half width; infinite where nothing bounds it.
double CalcHalfWidth(const ContactGeometry& shape) {
  if (IsRound(shape)) return MakeRound(shape).radius;
  if (const auto* box = std::get_if<BoxGeometry>(&shape)) return box->half.minCoeff();
  if (const auto* mesh = std::get_if<MeshGeometry>(&shape)) return 0.5 * mesh->mesh->bounds().sizes().minCoeff();
  return kInfinity;
}

// `touching`: which of the contact's two is B.
ContactSide MakeSide(const ContactPair& contact, int touching, double share) {
  const ContactGeometry& shape = contact.shapes[touching];
  const ContactGeometry& other = contact.shapes[1 - touching];
  ContactSide side;
  side.body = contact.bodies[touching];
  side.field_body = contact.bodies[1 - touching];
  side.modulus = share * contact.material.stiffness;
  side.size = std::min(CalcHalfWidth(shape), CalcHalfWidth(other));
  side.deepest = side.size;
  for (const ContactGeometry* s : {&other, &shape}) {
    if (const auto* sphere = std::get_if<SphereGeometry>(s)) side.rolling_radius = sphere->radius;
  }
  if (const auto* box = std::get_if<BoxGeometry>(&other)) {
    side.field = PolyhedralField::MakeBox(box->half, box->center);
  } else if (IsRound(other)) {
    side.field = MakeRound(other);
    side.deepest = std::min(side.size, 0.5 * CalcHalfWidth(other));
  } else {
    side.field = PolyhedralField::MakeHalfSpace();
  }
  if (IsRound(shape)) {
    const RoundField round = MakeRound(shape);
    side.axis = RoundAxis{round.center, round.axis, round.half_length, round.radius};
    if (IsRound(other)) side.deepest = 0.5 * (round.radius + CalcHalfWidth(other));
  } else if (const auto* box = std::get_if<BoxGeometry>(&shape)) {
    side.facets = std::make_shared<ContactMesh>(ContactMesh::MakeBox(box->half, box->center));
  } else {
    side.facets = std::get<MeshGeometry>(shape).mesh;
    side.is_designed = true;
  }
  return side;
}

Facet Move(const Facet& facet, const Pose& X) {
  Facet out = facet;
  for (int k = 0; k < facet.size; ++k) out.corner[k] = X * facet.corner[k];
  return out;
}

// Whether a ball in S may reach the field.
bool MayReach(const PolyhedralField& field, const Vector3d& center, double radius) {
  for (const FieldPlane& plane : field.planes) {
    if (plane.n.dot(center) - plane.d >= radius) return false;
  }
  return true;
}

bool MayReach(const RoundField& field, const Vector3d& center, double radius) {
  const Vector3d x = center - field.center;
  const double along = std::clamp(field.axis.dot(x), -field.half_length, field.half_length);
  const double reach = field.radius + radius;
  return (x - along * field.axis).squaredNorm() < reach * reach;
}

// Whether a facet's plane meets a sphere; other fields are left to what cuts the facet.
bool PlaneMayReach(const DepthField& field, const Facet& facet) {
  const auto* round = std::get_if<RoundField>(&field);
  if (round == nullptr || round->half_length > 0.0) return true;
  const Vector3d area = (facet.corner[1] - facet.corner[0]).cross(facet.corner[2] - facet.corner[0]);
  const double h = area.dot(round->center - facet.corner[0]);
  return h * h < round->radius * round->radius * area.squaredNorm();
}

// The facets near the field, ascending, in S: use(i, facet).
template <class Use>
void ForNearFacets(const ContactSide& side, NearFacets* near, const Pose& X_SB, const Use& use) {
  for (const int i : near->Find(side, X_SB)) {
    const ContactMesh::Ball& ball = side.facets->balls()[i];
    const Vector3d center = X_SB * ball.center;
    if (!std::visit([&](const auto& field) { return MayReach(field, center, ball.radius); }, side.field)) continue;
    const Facet facet = Move(side.facets->facets()[i], X_SB);
    if (PlaneMayReach(side.field, facet)) use(i, facet);
  }
}

}  // namespace

std::vector<ContactSide> MakeSides(const std::vector<ContactPair>& contacts) {
  std::vector<ContactSide> sides;
  int next_id = 0;
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    const ContactPair& contact = contacts[i];
    const auto& [a, b] = contact.shapes;
    if (Is<HalfSpaceGeometry>(a) && Is<HalfSpaceGeometry>(b)) {
      throw std::invalid_argument(fmt::format("contact {}: two half-spaces do not touch", i));
    }
    if (Is<MeshGeometry>(a) && Is<MeshGeometry>(b)) {
      throw std::invalid_argument(
          fmt::format("contact {}: two meshes; one has to be a sphere, capsule, box or half-space", i));
    }
    // What is to have the field comes last.
    const auto rank = [](const ContactGeometry& shape) {
      if (Is<MeshGeometry>(shape)) return 0;
      if (Is<BoxGeometry>(shape)) return 1;
      return IsRound(shape) ? 2 : 3;
    };
    const bool both = rank(a) == rank(b);
    for (int touching = 0; touching < 2; ++touching) {
      if (!both && rank(contact.shapes[touching]) > rank(contact.shapes[1 - touching])) continue;
      ContactSide& side = sides.emplace_back(MakeSide(contact, touching, both ? 0.5 : 1.0));
      side.pair = i;
      side.first_id = next_id;
      next_id += side.num_cells();
    }
  }
  return sides;
}

NearFacets::NearFacets(const ContactSide& side) {
  if (side.axis) {
    center_B_ = side.axis->center;
    radius_B_ = side.axis->half_length + side.axis->radius;
  } else {
    center_B_ = side.facets->bounds().center();
    radius_B_ = (1.0 + 1e-9) * 0.5 * side.facets->bounds().diagonal().norm();
    found_.reserve(side.facets->facets().size());
  }
  if (const auto* round = std::get_if<RoundField>(&side.field)) {
    const Vector3d reach = Vector3d::Constant(round->radius) + (round->half_length * round->axis).cwiseAbs();
    field_ = AlignedBox3d(round->center - reach, round->center + reach);
    radius_S_ = (1.0 + 1e-9) * (round->half_length + round->radius);
  } else if (const PolyhedralField& polyhedron = std::get<PolyhedralField>(side.field); polyhedron.planes.size() == 6) {
    Vector3d high;
    Vector3d low;
    for (int i = 0; i < 3; ++i) {
      high(i) = polyhedron.planes[2 * i].d;
      low(i) = -polyhedron.planes[2 * i + 1].d;
    }
    field_ = AlignedBox3d(low, high);
    radius_S_ = (1.0 + 1e-9) * 0.5 * field_.diagonal().norm();
  } else {
    radius_S_ = kInfinity;
  }
}

bool NearFacets::MayTouch(const Pose& X_WB, const Pose& X_WS) const {
  const Vector3d center = X_WB * center_B_;
  if (std::isinf(radius_S_)) return (X_WS.R.col(2)).dot(center - X_WS.p) < radius_B_;
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
  const std::vector<Facet>& facets = side.facets->facets();
  if (infinite) {
    found_.clear();
    for (int i = 0; i < static_cast<int>(facets.size()); ++i) {
      bool near = false;
      for (int k = 0; k < facets[i].size; ++k) near = near || (X_SB * facets[i].corner[k]).z() < margin_;
      if (near) found_.push_back(i);
    }
    return found_;
  }
  const Vector3d half = X_BS.R.cwiseAbs() * (0.5 * field_.sizes()) + Vector3d::Constant(margin_);
  const Vector3d middle = X_BS * field_.center();
  side.facets->FindFacets(AlignedBox3d(middle - half, middle + half), &found_);
  return found_;
}

void CalcPatches(const ContactSide& side, NearFacets* near, const Pose& X_SB, std::vector<PatchIntegrals>* patches,
                 std::vector<PatchJacobian>* jacobians) {
  const auto cells = static_cast<std::size_t>(side.num_cells());
  patches->assign(cells, PatchIntegrals{});
  if (jacobians != nullptr) jacobians->assign(cells, PatchJacobian::Zero());
  if (side.axis) {
    RoundAxis axis = *side.axis;
    axis.center = X_SB * axis.center;
    axis.direction = X_SB.R * axis.direction;
    CalcAxis(axis, side.field, &(*patches)[0], jacobians == nullptr ? nullptr : &(*jacobians)[0]);
  } else {
    ForNearFacets(side, near, X_SB, [&](int, const Facet& facet) { AddFacet(facet, side.field, patches, jacobians); });
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    PatchIntegrals& patch = (*patches)[cell];
    if (!patch.active()) continue;
    if (jacobians != nullptr) {
      if (!side.axis) FinishJacobian(patch, &(*jacobians)[cell]);
      (*jacobians)[cell].topRows<6>() *= side.modulus;
    }
    patch.F *= side.modulus;
    patch.M *= side.modulus;
  }
}

void PullBackVertices(const ContactSide& side, NearFacets* near, const Pose& X_SB, std::vector<PatchCotangent> bar,
                      Eigen::Matrix3Xd* bar_vertices) {
  for (PatchCotangent& b : bar) {
    b.F *= side.modulus;
    b.M *= side.modulus;
  }
  ForNearFacets(side, near, X_SB, [&](int i, const Facet& facet) {
    std::array<Vector3d, 3> bar_corners{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
    PullBackFacet(facet, side.field, bar, &bar_corners);
    for (int k = 0; k < 3; ++k) {
      bar_vertices->col(side.facets->triangles()[i][k]) += X_SB.R.transpose() * bar_corners[k];
    }
  });
}

}  // namespace knap
