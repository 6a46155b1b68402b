// A scene's contact in the terms that Bullet knows: Coulomb friction, rolling resistance, and a rebound.
//
// Bullet's bodies are rigid, so that a contact's stiffness and stick distance mean nothing here. Its damping d does: a
// Hunt-Crossley contact F = K(depth)(1 + d·ddepth/dt), whatever K, returns of the speed of approach v the share e with
//
//   x − ln(1 + x) = −y − ln(1 − y),   x = d v,   y = e x < 1                                  [Hunt & Crossley 1975]
//
// 1 where x = 0, about 1 − 2x/3 for small x, 1/x for large ones. knap's contact keeps its ramp from pulling with a
// smooth corner, which makes its own rebounds a little lower (docs/transfer.md).
#pragma once

namespace knap {

// e of d [s/m] ≥ 0 and v [m/s] ≥ 0; within 1e-9.
double CalcRebound(double damping, double speed);

}  // namespace knap
