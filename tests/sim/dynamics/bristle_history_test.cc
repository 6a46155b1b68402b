// Bristles that come and go between states: their formulas against a closed form, their cotangents against the
// formulas.
#include "sim/integrators/bristle_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace knap {
namespace bristle_history_test {

// z' = −10 z + 3, solved as a contact solves its law: z = base + h_contact z'(z).
double IntegrateRelaxation(int steps) {
  const auto rate = [](const Bristle& z) { return Bristle(-10.0 * z.array() + 3.0); };
  BristleState before, now;
  now.bent.id = {7};
  now.bent.z = {Bristle::Constant(1.0)};
  now.rate = {rate(now.bent.z[0])};
  const double h = 0.5 / steps;
  for (int k = 0; k < steps; ++k) {
    for (const StepFormula& f : {StepFormula::TrapezoidalStage(h), StepFormula::BdfStage(h)}) {
      Bristles base;
      CalcBristleBase(f, now, before, nullptr, &base);
      BristleState next;
      next.bent.id = {7};
      next.bent.z = {(base.z[0].array() + 3.0 * f.h_contact) / (1.0 + 10.0 * f.h_contact)};
      CalcBristleRates(f, base, &next);
      EXPECT_LT((next.rate[0] - rate(next.bent.z[0])).norm(), 1e-9);
      before = now;
      now = next;
    }
  }
  return now.bent.z[0].x();
}

TEST(BristleHistory, IsOfSecondOrderUnderTrBdf2) {
  const double exact = 0.3 + 0.7 * std::exp(-5.0);
  const double coarse = std::abs(IntegrateRelaxation(10) - exact);
  const double fine = std::abs(IntegrateRelaxation(20) - exact);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.2);
}

TEST(BristleHistory, LeavesOutWhatNoFormulaLooksAt) {
  BristleState before, now;
  before.bent = {{1, 4}, {Bristle::Ones(), 2.0 * Bristle::Ones()}};
  before.rate = {Bristle::Zero(), Bristle::Zero()};
  now.bent = {{2, 4}, {3.0 * Bristle::Ones(), 5.0 * Bristle::Ones()}};
  now.rate = {Bristle::Ones(), Bristle::Zero()};
  Bristles base;
  CalcBristleBase(StepFormula::Bdf1(0.1), now, before, nullptr, &base);
  EXPECT_EQ(base.id, (std::vector<int>{2, 4}));
  EXPECT_EQ(base.z, now.bent.z);
  CalcBristleBase(StepFormula::BdfStage(0.1), now, before, nullptr, &base);
  EXPECT_EQ(base.id, (std::vector<int>{1, 2, 4}));
  const double zeta = StepFormula::BdfStage(0.1).zeta;
  EXPECT_NEAR(base.z[0].x(), -zeta, 1e-15);
  EXPECT_NEAR(base.z[1].x(), 3.0 * (1.0 + zeta), 1e-14);
  EXPECT_NEAR(base.z[2].x(), 5.0 + 3.0 * zeta, 1e-14);
}

// ⟨J u, w⟩ = ⟨u, Jᵀ w⟩ for u at both earlier states and the contacts' own answer, w at the next state and its rates.
TEST(BristleHistory, CotangentsAreTheTranspose) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  const auto random = [&] { return Bristle(Bristle::NullaryExpr([&] { return normal(generator); })); };
  const auto make = [&](const std::vector<int>& id) {
    BristleState s;
    s.bent.id = id;
    for (std::size_t i = 0; i < id.size(); ++i) {
      s.bent.z.push_back(random());
      s.rate.push_back(random());
    }
    return s;
  };
  for (const StepFormula& f :
       {StepFormula::TrapezoidalStage(0.3), StepFormula::BdfStage(0.3), StepFormula::Bdf1(0.3)}) {
    // All linear: states are directions too.
    const BristleState before = make({1, 3, 5});
    const BristleState now = make({2, 3, 8});
    BristleState next = make({3, 5, 9});
    Bristles base;
    CalcBristleBase(f, now, before, &next.bent, &base);
    CalcBristleRates(f, base, &next);
    BristleCotangents bar_next;
    bar_next.bent = make({3, 5, 9}).bent.z;
    bar_next.rate = make({3, 5, 9}).rate;
    double forward = 0.0;
    for (int i = 0; i < 3; ++i) forward += bar_next.bent[i].dot(next.bent.z[i]) + bar_next.rate[i].dot(next.rate[i]);
    std::vector<Bristle> bar_base(base.z.size(), Bristle::Zero());
    PullBackBristleRates(f, base, next, &bar_next, &bar_base);
    BristleCotangents bar_now, bar_before;
    bar_now.Reset(3);
    bar_before.Reset(3);
    PullBackBristleBase(f, base, bar_base, now, before, &bar_now, &bar_before);
    double backward = 0.0;
    for (int i = 0; i < 3; ++i) {
      backward += bar_next.bent[i].dot(next.bent.z[i]) + bar_now.bent[i].dot(now.bent.z[i]) +
                  bar_now.rate[i].dot(now.rate[i]) + bar_before.bent[i].dot(before.bent.z[i]);
    }
    EXPECT_NEAR(backward, forward, 1e-12 * std::abs(forward) + 1e-12);
  }
}

}  // namespace bristle_history_test
}  // namespace knap
