// What a simulation says about itself.
#pragma once

namespace knap {

struct SimulationCertificate {
  bool converged = true;
  bool finite = true;
  double worst_residual = 0.0;  // largest accepted scaled residual
  int steps = 0;                // accepted
  int subdivided_steps = 0;     // whole steps of fixed length that had to be cut
  int rejected_steps = 0;       // of chosen length: begun again with a smaller one
  int contact_onsets = 0;       // times that some contact began
  // Of the contacts, at the start and at the states that accepted steps led to.
  double penetration = 0.0;    // the deepest, as a share of what the thinner body or its field has; 1: used up
  int deepest_contact = -1;    // whose that is
  double largest_force = 0.0;  // of one contact [N]
  int passed_contact = -1;     // whose bodies passed through one another within a step (contact_model.h); -1: none
  long newton_iterations = 0;
  int hardest_contact = -1;    // whose force is the largest at the last accepted state; -1: nothing touches there
  bool out_of_effort = false;  // it did not converge because steps of chosen length became too many
};

}  // namespace knap
