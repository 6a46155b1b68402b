// Which points touch which surface in a contact of two shapes: the table of contact_model.h.
#pragma once

#include <array>
#include <vector>

#include "sim/contact/contact_law.h"
#include "sim/contact/contact_shape.h"
#include "sim/contact/point_side.h"

namespace knap {

struct ContactPair {
  std::array<int, 2> bodies{-1, -1};  // indices in the tree
  std::array<ContactGeometry, 2> shapes;
  ContactMaterial material;
};

// The longest spacing of a mesh's samples at which nothing slips through between them when it meets this shape: half of
// the shape's least width. Infinite where no samples are needed.
double CalcSampleSpacing(const ContactGeometry& against);

// In the order of the contacts, each point with a number of its own. Throws std::invalid_argument naming the contact's
// number for two half-spaces, two meshes, or a mesh without the samples it needs.
std::vector<PointSide> MakeSides(const std::vector<ContactPair>& contacts);

}  // namespace knap
