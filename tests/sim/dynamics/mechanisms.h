// Articulated mechanisms that tests and benchmarks share: a finger and a chain.
#pragma once

#include "sim/multibody/tree.h"

namespace knap::test {

// The finger of DiffHand's scenes [Xu 2021], its links as solid boxes of 1 g/cm³: a palm fixed to the world, a knuckle
// that turns about z, then three times a joint that turns about y and a phalanx fixed to it, and a tip. Along x; 4
// degrees of freedom, each with damping and a force actuator. Gravity is zero, as in Reaching.
Tree MakeFinger();

// `links` rods of 1.5 g and 30 mm one below the other on ball joints, the first one hanging from the world; `damping`
// in every joint [N m s/rad].
Tree MakeChain(int links, double damping);

}  // namespace knap::test
