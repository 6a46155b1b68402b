#include "sim/scenarios/rollout_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {

using std::string_view;

void VisitFields(FieldVisitor& v, Rollout& r) {
  v.Number({.key = "horizon", .doc = "duration, a whole number of steps", .dimension = kTime, .range = kPositive},
           r.horizon);
  v.Number(
      {.key = "step",
       .doc = "of bdf1 and bdf2; of tr_bdf2 the longest one, 0: at most 4 ms, as samples and intervals allow. Samples "
              "and control intervals are whole numbers of it",
       .required = false,
       .dimension = kTime,
       .range = kNonNegative},
      r.step);
  static constexpr string_view kIntegrators[] = {"tr_bdf2", "bdf1", "bdf2"};
  v.EnumField({.key = "integrator",
               .doc = "implicit: tr_bdf2 in steps of its choice, bdf1 and bdf2 in fixed ones",
               .required = false},
              r.integrator, kIntegrators);
  v.Number({.key = "tolerance",
            .doc = "of tr_bdf2: the error of a step, positions as a share of the smallest body's radius, speeds of the "
                   "largest speed",
            .required = false,
            .range = {0.0, 1.0, true}},
           r.tolerance);
  v.Number({.key = "newton_tolerance", .doc = "on the scaled residual", .required = false, .range = {0.0, 1e-2, true}},
           r.newton_tolerance);
  v.Integer({.key = "newton_max_iterations",
             .doc = "before the step is subdivided",
             .required = false,
             .range = {1.0, 1000.0}},
            r.newton_max_iterations);
}

void VisitFields(FieldVisitor& v, GradientDemand& g) {
  v.Number({.key = "tolerance",
            .doc = "relative to the largest component: what `knap gradcheck` asks for",
            .required = false,
            .range = kFraction},
           g.tolerance);
  v.Number({.key = "step",
            .doc = "share of a parameter's range; with fixed time steps, where rounding blurs differences over it by "
                   "more than the tolerance, a rollout's gradient is unreliable",
            .required = false,
            .range = kFraction},
           g.step);
  v.Number({.key = "loss_error",
            .doc = "share of a parameter's range; where chosen time steps do more to the loss than a move over it, the "
                   "gradient is unreliable",
            .required = false,
            .range = kPositive},
           g.loss_error);
  v.Number(
      {.key = "touchdown",
       .doc = "share of itself by which a gradient over three touchdowns or more may differ from that at frozen time "
              "nodes; beyond, it is unreliable",
       .required = false,
       .range = kPositive},
      g.touchdown);
  static constexpr string_view kComparisons[] = {"none", "finer"};
  v.EnumField({.key = "compare",
               .doc = "what a gradient is compared with at the cost of another rollout: that at a quarter of "
                      "rollout.tolerance, or nothing",
               .required = false},
              g.compare, kComparisons);
  v.Number({.key = "change",
            .doc = "share of itself by which a gradient may differ there; beyond, it is unreliable",
            .required = false,
            .range = kPositive},
           g.change);
  v.Number({.key = "flagged",
            .doc = "share of rollouts whose certificate may warn in `knap gradcheck`",
            .required = false,
            .range = {0.0, 1.0}},
           g.flagged);
}

void VisitFields(FieldVisitor& v, TrustDemand& t) {
  v.Number({.key = "penetration",
            .doc = "how deep bodies may press into one another, as a share of half the thinner one's width; a rollout "
                   "with a deeper contact is not to be trusted",
            .required = false,
            .range = kPositive},
           t.penetration);
}

}  // namespace knap
