// A scene's contact in the terms that Bullet knows: Coulomb friction, rolling resistance, and a rebound.
//
// Bullet's bodies are rigid, so that a contact's stiffness and stick distance mean nothing here. Its damping d does. A
// force F = K(depth) D(1 + d ddepth/dt), D the ramp of patch_law.h, returns of the speed of approach v the share e for
// which compression and return pass the same energy, whatever K is [Hunt & Crossley 1975]:
//
//   ∫_0^x t/(1 + t) dt = x − ln(1 + x) = ∫_0^y t/D(1 − t) dt,   x = d v,   y = e x < 1
//
// 1 where x = 0, then falling; y tends to 1 and e to 1/x for large x.
#pragma once

namespace knap {

// e of d [s/m] ≥ 0 and v [m/s] ≥ 0; within 1e-4.
double CalcRebound(double damping, double speed);

}  // namespace knap
