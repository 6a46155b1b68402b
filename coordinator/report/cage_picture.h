// The picture of `knap cage`: what each parameter does to a tool.
#pragma once

#include <string>

#include "sim/geometry/triangle_mesh.h"
#include "sim/morphology/cage_maker.h"

namespace knap {

// A panel a parameter, all in one view and scale: the cage and the mesh as they are, faint, and the mesh with the
// parameter at its lower and at its upper bound. Of a mesh with more edges than can be told apart those are drawn that
// bend most. Costs as CageDesign does.
std::string DrawCage(const MadeCage& made, const TriangleMesh& mesh, const std::string& title);

}  // namespace knap
