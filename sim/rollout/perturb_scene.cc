#include "sim/rollout/perturb_scene.h"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "sim/math/overloaded.h"
#include "sim/rollout/build_body.h"
#include "sim/rollout/build_model.h"

namespace knap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void ScaleMass(double factor, Inertia* inertia) {
  std::visit(Overloaded{[&](SolidInertia& i) { i.mass *= factor; }, [&](DensityInertia& i) { i.density *= factor; },
                        [&](ExplicitInertia& i) {
                          i.mass *= factor;
                          i.moments *= factor;
                          i.products *= factor;
                        }},
             *inertia);
}

// Divides every time of what it visits.
class TimeScale {
 public:
  explicit TimeScale(double speed) : speed_(speed) {}

  void Apply(Scene* scene) const {
    Scale(&scene->rollout.horizon);
    Scale(&scene->rollout.step);
    for (Grip& grip : scene->grips) {
      Scale(&grip.from);
      Scale(&grip.until);
    }
    for (Signal& signal : scene->signals) {
      if (auto* drift = std::get_if<DriftSignal>(&signal.kind)) Scale(&drift->since);
      if (auto* distance = std::get_if<DistanceSignal>(&signal.kind)) {
        for (TimedPosition& target : distance->targets) Scale(&target.after);
      }
    }
    for (std::vector<Term>* terms : {&scene->loss.task, &scene->loss.distillation}) {
      for (Term& term : *terms) Apply(&term);
    }
    if (scene->success) Apply(&*scene->success);
    if (scene->controls) Scale(&scene->controls->interval);
    if (scene->policy) Scale(&scene->policy->interval);
  }

 private:
  void Scale(double* time) const { *time /= speed_; }

  void Apply(Term* term) const {
    std::visit(Overloaded{[](AtEnd&) {}, [&](AtTime& at) { Scale(&at.time); },
                          [&](OverSamples& samples) {
                            Scale(&samples.every);
                            Scale(&samples.from);
                            Scale(&samples.until);
                          },
                          [](AtCrossing&) {}},
               term->when);
    if (auto* schedule = std::get_if<ScheduleTarget>(&term->target)) {
      for (TimedValue& value : schedule->values) Scale(&value.after);
    }
  }

  void Apply(Condition* condition) const {
    const auto apply_all = [&](std::vector<Condition>& of) {
      for (Condition& part : of) Apply(&part);
    };
    std::visit(Overloaded{[&](Within& within) { Apply(&within.when); }, [&](AllOf& c) { apply_all(c.of); },
                          [&](AnyOf& c) { apply_all(c.of); }, [&](NoneOf& c) { apply_all(c.of); }},
               condition->kind);
  }

  void Apply(ConditionTime* when) const {
    const auto apply_span = [&](auto& span) {
      Scale(&span.from);
      Scale(&span.until);
    };
    std::visit(Overloaded{[](AtEnd&) {}, [&](AtTime& at) { Scale(&at.time); }, [&](Ever& w) { apply_span(w); },
                          [&](Always& w) { apply_span(w); },
                          [&](Lasting& w) {
                            apply_span(w);
                            Scale(&w.duration);
                          },
                          [](WhenCrossing&) {}},
               *when);
  }

  double speed_;
};

Matrix3d Turn(double angle, const Vector3d& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

void MoveBody(const StartPerturbation& start, const Vector3d& gravity, Body* body) {
  const Vector3d up = gravity.norm() > 0.0 ? Vector3d(-gravity.normalized()) : Vector3d::UnitZ();
  Vector3d along = Vector3d::UnitX() - up.x() * up;
  if (!(along.norm() > 1e-6)) along = Vector3d::UnitY() - up.y() * up;
  along.normalize();
  const Matrix3d R_WJ = RotationFromRpy(body->joint.orientation_rpy);
  FreeState& initial = std::get<FreeJoint>(body->joint.kind).initial;
  initial.position += R_WJ.transpose() * (start.along * along + start.across * up.cross(along));
  initial.orientation_rpy =
      CalcRpy(R_WJ.transpose() * Turn(start.turn, up) * R_WJ * RotationFromRpy(initial.orientation_rpy));
}

void MoveRope(const StartPerturbation& start, Rope* rope) {
  std::visit(Overloaded{[&](HelixState& helix) {
                          helix.center.x() += start.along;
                          helix.turn += start.turn;
                        },
                        [&](StraightState& straight) {
                          const Matrix3d R_WL = MakeLinkAxes(straight.direction);
                          straight.start += start.along * R_WL.col(0) + start.across * R_WL.col(1);
                          straight.direction = Turn(start.turn, R_WL.col(2)) * straight.direction;
                        }},
             rope->initial);
}

}  // namespace

Vector3d CalcRpy(const Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
          std::atan2(R(1, 0), R(0, 0))};
}

void PerturbScene(Scene* scene) {
  if (!scene->perturbation) return;
  const Perturbation& perturbation = *scene->perturbation;
  for (Contact& contact : scene->contacts) contact.friction *= perturbation.friction;
  for (Body& body : scene->bodies) {
    if (body.inertia) ScaleMass(perturbation.mass, &*body.inertia);
  }
  for (Rope& rope : scene->ropes) rope.link_mass *= perturbation.mass;
  const Vector3d gravity = CalcGravity(*scene);
  for (const StartPerturbation& start : perturbation.starts) {
    for (Body& body : scene->bodies) {
      if (body.name == start.name) MoveBody(start, gravity, &body);
    }
    for (Rope& rope : scene->ropes) {
      if (rope.name == start.name) MoveRope(start, &rope);
    }
  }
  const bool is_led = std::any_of(scene->bodies.begin(), scene->bodies.end(), [](const Body& body) {
    return std::holds_alternative<PrescribedJoint>(body.joint.kind);
  });
  if (is_led) TimeScale(perturbation.speed).Apply(scene);
}

}  // namespace knap
