// A rope of boxes on ball joints, wound around a prism: the mechanism of Winding, for tests and benchmarks.
#pragma once

#include "sim/geometry/triangle_mesh.h"
#include "tests/sim/dynamics/pair_scene.h"

namespace knap::test {

// A square prism along x, 90 mm long and centred, with sides of `side` at the middle and `end_side` at both ends [m].
TriangleMesh MakeSpool(double side, double end_side);

struct WoundRope {
  PairScene scene;
  int spool = 0;           // fixed
  std::vector<int> links;  // bodies, from one end to the other
};

// 15 links of 30 mm pitch, 8 mm thick, 1.5 g each, in 1.875 turns of a square helix around a side of 50 mm, 1 mm above
// it; the joints damped, both ends free.
WoundRope MakeWoundRope(const TriangleMesh& spool, const ContactMaterial& material);

}  // namespace knap::test
