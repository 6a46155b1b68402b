// Articulated mechanisms that tests and benchmarks share: a finger and a chain.
#pragma once

#include <vector>

#include "sim/multibody/tree.h"

namespace knap::test {

// A box-shaped link of a mechanism: from x0 to x1 in the body's frame, its section centred on the axis x [m].
struct BoxLink {
  int body = 0;
  double x0 = 0.0, x1 = 0.0;
  double width = 0.0;   // along y
  double height = 0.0;  // along z
};

// Adds the finger of DiffHand's scenes [Xu 2021] to a tree, its links as solid boxes of 1 g/cm³: a palm fixed to
// `parent` (−1 the world), a knuckle that turns about z, then three times a joint that turns about y and a phalanx
// fixed to it, and a tip. Along x, 0.1886 m; 4 degrees of freedom, each with damping and a motor like the given one,
// whose body and dof are overwritten. Returns the links from palm to tip.
std::vector<BoxLink> AddFinger(Tree* tree, int parent, const Actuator& motor);

// That finger on the world, with force actuators and no gravity, as in Reaching.
Tree MakeFinger();

// `links` rods of 1.5 g and 30 mm one below the other on ball joints, the first one hanging from the world; `damping`
// in every joint [N m s/rad].
Tree MakeChain(int links, double damping);

}  // namespace knap::test
