// Which keys a section may have, in a few words for someone who has written something else in its place.
#pragma once

#include <string>

#include "sim/scenarios/field_visitor.h"

namespace knap {

// "with the keys variations and seed"; of a section whose type chooses its keys, "with the key type (number, signal)".
// Keys that may be left out stand in [ ]. Visits the section, which must be present.
std::string DescribeKeys(const SectionAccess& section);

}  // namespace knap
