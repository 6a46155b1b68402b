// The mechanism of Flipping: an articulated finger that pushes a 6 cm box over an edge on the floor, about which it
// turns on a hinge. For tests and benchmarks.
//
// The finger of DiffHand's scenes, on a base that slides along x and z, every joint on a position actuator; the box,
// of 1 g/cm³, stands on the floor with the hinge along its far lower edge. Links of the finger are in contact with
// box and floor, and the box with the floor: 7 degrees of freedom. The base advances, the tip presses against the
// box's near face and tips it over, until it lies on its far face.
#pragma once

#include <vector>

#include "sim/contact/contact_model.h"
#include "sim/integrators/simulate.h"
#include "tests/sim/dynamics/mechanisms.h"

namespace knap::test {

struct Flipping {
  Tree tree;
  std::vector<ContactPair> contacts;
  Eigen::VectorXd q0, v0;
  ControlSequence controls;   // the actuators' targets
  SimulationOptions options;  // 5 ms, 1.5 s
  int box = 0;
  int hinge = 0;          // its angle's place in q, 0 at the start
  int finger_on_box = 0;  // the contact of the fingertip
};

Flipping MakeFlipping();

}  // namespace knap::test
