#include "sim/transfer/cone_solver.h"

#include <cmath>

#include "sim/math/check.h"

namespace knap {
namespace {

// What a row's impulse becomes when nothing bounds it [btSolverConstraint].
btScalar CalcFreeImpulse(const btSolverConstraint& row, btSolverBody& a, btSolverBody& b) {
  const btScalar slip = row.m_contactNormal1.dot(a.internalGetDeltaLinearVelocity()) +
                        row.m_relpos1CrossNormal.dot(a.internalGetDeltaAngularVelocity()) +
                        row.m_contactNormal2.dot(b.internalGetDeltaLinearVelocity()) +
                        row.m_relpos2CrossNormal.dot(b.internalGetDeltaAngularVelocity());
  return row.m_appliedImpulse + row.m_rhs - row.m_appliedImpulse * row.m_cfm - slip * row.m_jacDiagABInv;
}

void SetImpulse(btScalar impulse, btSolverConstraint* row, btSolverBody* a, btSolverBody* b) {
  const btScalar change = impulse - row->m_appliedImpulse;
  row->m_appliedImpulse = impulse;
  a->internalApplyImpulse(row->m_contactNormal1 * a->internalGetInvMass(), row->m_angularComponentA, change);
  b->internalApplyImpulse(row->m_contactNormal2 * b->internalGetInvMass(), row->m_angularComponentB, change);
}

}  // namespace

void ConeSolver::SolveFriction(btSolverConstraint* first, btSolverConstraint* second) {
  const btScalar normal = m_tmpSolverContactConstraintPool[first->m_frictionIndex].m_appliedImpulse;
  const btScalar bound = first->m_friction * std::fmax(normal, 0.0);
  btSolverBody& a = m_tmpSolverBodyPool[first->m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[first->m_solverBodyIdB];
  btScalar f1 = CalcFreeImpulse(*first, a, b);
  btScalar f2 = CalcFreeImpulse(*second, a, b);
  const btScalar size = std::sqrt(f1 * f1 + f2 * f2);
  if (size > bound) {
    f1 *= bound / size;
    f2 *= bound / size;
  }
  SetImpulse(f1, first, &a, &b);
  SetImpulse(f2, second, &a, &b);
}

btScalar ConeSolver::solveSingleIteration(int iteration, btCollisionObject**, int, btPersistentManifold**, int,
                                          btTypedConstraint**, int, const btContactSolverInfo&, btIDebugDraw*) {
  for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverNonContactConstraintPool[m_orderNonContactConstraintPool[i]];
    if (iteration >= row.m_overrideNumSolverIterations) continue;
    resolveSingleConstraintRowGeneric(m_tmpSolverBodyPool[row.m_solverBodyIdA],
                                      m_tmpSolverBodyPool[row.m_solverBodyIdB], row);
  }
  for (int i = 0; i < m_tmpSolverContactConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactConstraintPool[m_orderTmpConstraintPool[i]];
    resolveSingleConstraintRowLowerLimit(m_tmpSolverBodyPool[row.m_solverBodyIdA],
                                         m_tmpSolverBodyPool[row.m_solverBodyIdB], row);
  }
  btConstraintArray& friction = m_tmpSolverContactFrictionConstraintPool;
  KNAP_CHECK(friction.size() == 2 * m_tmpSolverContactConstraintPool.size(), "{} rows of friction for {} points",
             friction.size(), m_tmpSolverContactConstraintPool.size());
  for (int i = 0; i < friction.size(); i += 2) {
    KNAP_CHECK(friction[i].m_frictionIndex == friction[i + 1].m_frictionIndex, "row {} is of another point", i);
    SolveFriction(&friction[i], &friction[i + 1]);
  }
  return 1.0;  // a residual that never ends the iterations early
}

}  // namespace knap
