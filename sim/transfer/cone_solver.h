// Bullet's sequential impulse solver with friction in a cone.
//
// Bullet bounds friction by μ times the normal impulse in each of two directions by itself. A contact that slides in
// one of them then still sticks in the other: a ball that is pushed along a table by a swinging plate, and slides up
// the plate as it rolls, would be carried along sideways. Here the two rows of a point are solved together: with f the
// impulses, v the slip and D the rows' effective masses, as in Bullet's own rows,
//
//   f ← the point of the disc |f| ≤ μ N that is nearest to f − D v        N the point's normal impulse so far
//
// which stands still where friction opposes the slip with μ N, or sticks within the disc.
#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace knap {

// To be used with SOLVER_USE_2_FRICTION_DIRECTIONS, without rolling friction.
class ConeSolver final : public btSequentialImpulseConstraintSolver {
 protected:
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int body_count,
                                btPersistentManifold** manifolds, int manifold_count, btTypedConstraint** constraints,
                                int constraint_count, const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  void SolveFriction(btSolverConstraint* first, btSolverConstraint* second);
};

}  // namespace knap
