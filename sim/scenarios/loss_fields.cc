#include "sim/scenarios/loss_fields.h"

#include "sim/scenarios/common_fields.h"

namespace knap {

using std::string_view;

static void VisitOpening(FieldVisitor& v, Opening& o) {
  v.Text({.key = "body", .doc = "whose origin is watched", .role = TextRole::kBody}, o.body);
  VisitAxis(v, "axis", "of the world, across the plane of the opening", o.axis);
  v.Number({.key = "at", .doc = "coordinate of the plane along `axis`", .dimension = kLength}, o.at);
  VisitAxis(v, "opening_axis", "of the world, along the opening", o.opening_axis);
  v.Number({.key = "opening_center", .doc = "coordinate along `opening_axis`", .required = false, .dimension = kLength},
           o.opening_center);
  v.Number({.key = "opening_half_width", .doc = "of the gap", .dimension = kLength, .range = kNonNegative},
           o.opening_half_width);
}

static void VisitWeight(FieldVisitor& v, double& weight, double& length_unit) {
  v.Number({.key = "weight", .doc = "factor of this term", .required = false, .range = kNonNegative}, weight);
  v.Number({.key = "length_unit",
            .doc = "length that counts as 1",
            .required = false,
            .dimension = kLength,
            .range = kPositive},
           length_unit);
}

static void VisitFields(FieldVisitor& v, CrossingLoss& l) {
  VisitOpening(v, l.opening);
  VisitWeight(v, l.weight, l.length_unit);
  v.Number({.key = "shortfall_weight",
            .doc = "of a body that never reaches the plane",
            .required = false,
            .range = kNonNegative},
           l.shortfall_weight);
  v.Number({.key = "shortfall_scale",
            .doc = "missing distance beyond which the penalty levels off",
            .required = false,
            .dimension = kLength,
            .range = kPositive},
           l.shortfall_scale);
}

static void VisitFields(FieldVisitor& v, ControlCostLoss& l) {
  v.Number({.key = "weight", .doc = "factor of this term", .required = false, .range = kNonNegative}, l.weight);
}

static void VisitFields(FieldVisitor& v, TimedTarget& t) {
  v.Number({.key = "from", .doc = "time from which it counts", .dimension = kTime, .range = kNonNegative}, t.from);
  v.Numbers({.key = "position", .doc = "in the world", .dimension = kLength}, t.position);
}

static void VisitSamplePeriod(FieldVisitor& v, double& period) {
  v.Number({.key = "sample_period",
            .doc = "between samples, a whole number of steps",
            .dimension = kTime,
            .range = kPositive},
           period);
}

static constexpr string_view kNormalizations[] = {"sum", "mean"};

static void VisitFields(FieldVisitor& v, HeightLoss& l) {
  v.Text({.key = "rope", .doc = "whose centre of mass is watched", .role = TextRole::kRope}, l.rope);
  VisitSamplePeriod(v, l.sample_period);
  v.Number({.key = "from",
            .doc = "time after which samples count, a whole number of sample periods",
            .required = false,
            .dimension = kTime,
            .range = kNonNegative},
           l.from);
  v.Number({.key = "until", .doc = "the last sample's time, at most", .dimension = kTime, .range = kPositive}, l.until);
  v.EnumField({.key = "normalize", .doc = "over the samples", .required = false}, l.normalize, kNormalizations);
  VisitWeight(v, l.weight, l.length_unit);
}

static void VisitFields(FieldVisitor& v, HeightHoldLoss& l) {
  VisitFields(v, l.height);
  v.Text({.key = "carried_by",
          .doc = "`world` or the body that is to carry the rope's centre of mass along from where it is at `from`",
          .required = false,
          .role = TextRole::kBodyOrWorld},
         l.carried_by);
}

static void VisitFields(FieldVisitor& v, PointTargetLoss& l) {
  v.Text({.key = "body", .doc = "that carries the point", .role = TextRole::kBody}, l.body);
  VisitVector(v, "point", "in B; on a designed body it moves with the mesh", kLength, l.point);
  v.StructList({.key = "targets", .doc = "by time, the first from 0 s; a sample's is the one when its period begins"},
               l.targets, 1);
  VisitSamplePeriod(v, l.sample_period);
  VisitWeight(v, l.weight, l.length_unit);
}

static void VisitFields(FieldVisitor& v, TaskTerm& term) {
  v.OneOf({.key = "type",
           .doc = "crossing: squared distance from an opening where the body crosses its plane; height_hold: squared "
                  "difference from the height that the rope had, or would have if carried along; control_cost: squared "
                  "commands, one sample a control interval; point_target: "
                  "distance of a body's point from targets"},
          term, {"crossing", "height_hold", "control_cost", "point_target"});
}

static void VisitFields(FieldVisitor& v, PositionMatchLoss& l) {
  v.Text({.key = "body", .doc = "whose origin is compared", .role = TextRole::kBody}, l.body);
  v.LeafList({.key = "axes", .doc = "of the world, the coordinates compared"}, l.axes, 1,
             [](FieldVisitor& w, Axis& axis) { w.EnumField({}, axis, kAxisNames); });
  VisitSamplePeriod(v, l.sample_period);
  v.EnumField({.key = "normalize", .doc = "over the samples", .required = false}, l.normalize, kNormalizations);
  VisitWeight(v, l.weight, l.length_unit);
}

static void VisitFields(FieldVisitor& v, DistillationTerm& term) {
  v.OneOf({.key = "type",
           .doc = "position_match, height_match: squared distance from the reference trajectory, squared difference "
                  "from its height"},
          term, {"position_match", "height_match"});
}

void VisitFields(FieldVisitor& v, Loss& l) {
  v.StructList({.key = "task", .doc = "terms, added up", .required = false}, l.task);
  v.StructList({.key = "distillation", .doc = "terms, added up", .required = false}, l.distillation);
}

static void VisitFields(FieldVisitor& v, CrossesOpening& s) { VisitOpening(v, s.opening); }

static void VisitFields(FieldVisitor& v, HoldsRope& s) {
  v.Text({.key = "rope", .doc = "that is held", .role = TextRole::kRope}, s.rope);
  v.Text({.key = "body", .doc = "that holds it", .role = TextRole::kBody}, s.body);
  v.Number({.key = "distance",
            .doc = "of the rope's centre of mass from the body's origin at the end, at most",
            .dimension = kLength,
            .range = kPositive},
           s.distance);
  v.Number({.key = "touched_within",
            .doc = "time before the end during which the two must have touched",
            .dimension = kTime,
            .range = kPositive},
           s.touched_within);
}

void VisitFields(FieldVisitor& v, SuccessTest& test) {
  v.OneOf({.key = "type",
           .doc = "crosses_opening: the first crossing of the plane lies in the opening; holds_rope: it is near and "
                  "touched at the end"},
          test, {"crosses_opening", "holds_rope"});
}

}  // namespace knap
