#include "sim/scenarios/check_scene.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <type_traits>
#include <utility>

#include "sim/scenarios/check_actuation.h"
#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/numeric_keys.h"

namespace knap {
namespace {

class SceneChecker {
 public:
  SceneChecker(Scene& scene, FieldLog& log) : scene_(scene), log_(log) {}

  void Check() {
    for (const Body& body : scene_.bodies) CheckBody(body);
    for (const Rope& rope : scene_.ropes) CheckRope(rope);
    for (std::size_t i = 0; i < scene_.contacts.size(); ++i) CheckContact(i);
    for (std::size_t i = 0; i < scene_.grips.size(); ++i) CheckGrip(i);
    CheckDesign();
    CheckRollout();
    CheckLoss();
    CheckVariation();
    CheckActuation(scene_, log_);
    CheckLearning();
  }

 private:
  void Report(std::vector<std::string> paths, const std::string& message) { log_.Report(paths, message); }

  // Bodies without a valid name have been reported, and nothing can refer to them.
  void CheckBody(const Body& body) {
    if (body.name.empty()) return;
    const std::string path = "bodies." + body.name;
    CheckAncestors(body, path);
    const bool moves_by_force = !std::holds_alternative<FixedJoint>(body.joint.kind) &&
                                !std::holds_alternative<PrescribedJoint>(body.joint.kind);
    if (moves_by_force && !body.inertia) {
      Report({path + ".inertia", path + ".joint.type"},
             "a body that forces move needs an inertia; only fixed and prescribed ones do without");
    }
    if (body.inertia) CheckInertia(body, path + ".inertia");
    if (const BoxShape* box = body.shape ? std::get_if<BoxShape>(&*body.shape) : nullptr) {
      const double most = 0.5 * box->size.minCoeff();
      if (box->rounding > most) {
        Report({path + ".shape.rounding", path + ".shape.size"},
               fmt::format("must be at most half the least size, {}", FormatQuantity(most, kLength)));
      }
    }
    std::visit(
        [&](const auto& joint) {
          if constexpr (requires { joint.axis; }) {
            if (joint.axis.norm() == 0.0) Report({path + ".joint.axis"}, "must not be zero");
            CheckOneDofJoint(joint, path + ".joint");
          }
        },
        body.joint.kind);
    const auto* prescribed = std::get_if<PrescribedJoint>(&body.joint.kind);
    const auto* motion = prescribed != nullptr ? std::get_if<SegmentsMotion>(&prescribed->motion) : nullptr;
    for (std::size_t i = 0; motion != nullptr && i < motion->segments.size(); ++i) {
      CheckSegment(motion->segments[i], body, fmt::format("{}.joint.motion.segments[{}]", path, i));
    }
  }

  void CheckSegment(const MotionSegment& segment, const Body& body, const std::string& path) {
    if (segment.ramp > 0.5 * segment.duration) {
      Report({path + ".ramp", path + ".duration"},
             fmt::format("must be at most half the duration, {}", FormatQuantity(0.5 * segment.duration, kTime)));
    }
    const bool has_axis = segment.axis.norm() > 0.0;
    const bool tips = segment.tips.norm() > 0.0;
    if (segment.angle != 0.0 && has_axis == tips) {
      Report({path + ".angle", path + ".axis", path + ".tips"}, "a turn needs either `axis` or `tips`");
    }
    if (tips && body.parent != kWorldName) {
      Report({path + ".tips", "bodies." + body.name + ".parent"},
             "what is level is known only where the world carries the joint");
    }
    if (tips && scene_.gravity.norm() == 0.0) Report({path + ".tips", "gravity"}, "nothing is level without gravity");
  }

  template <class OneDofJoint>
  void CheckOneDofJoint(const OneDofJoint& joint, const std::string& path) {
    const Dimension dimension = std::is_same_v<OneDofJoint, RevoluteJoint> ? kAngle : kLength;
    const auto check = [&](const auto& range, const std::string& section) {
      if (range.lower < range.upper) return;
      Report({section + ".lower", section + ".upper"},
             fmt::format("must be less than upper, {}", FormatQuantity(range.upper, dimension)));
    };
    if (joint.limits) check(*joint.limits, path + ".limits");
    const PositionActuator* position = joint.actuator ? std::get_if<PositionActuator>(&*joint.actuator) : nullptr;
    if (position != nullptr) check(*position, path + ".actuator");
  }

  void CheckAncestors(const Body& body, const std::string& path) {
    const Body* ancestor = &body;
    std::string chain = body.name;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      ancestor = FindBody(scene_, ancestor->parent);
      if (ancestor == nullptr) return;
      chain += " → " + ancestor->name;
      if (ancestor != &body) continue;
      Report({path + ".parent"}, fmt::format("the bodies must form a tree, but here is a cycle: {}", chain));
      return;
    }
  }

  void CheckInertia(const Body& body, const std::string& path) {
    if (const auto* given = std::get_if<ExplicitInertia>(&*body.inertia)) {
      Eigen::Matrix3d I_BBcm_B = given->moments.asDiagonal();
      I_BBcm_B(0, 1) = I_BBcm_B(1, 0) = given->products(0);
      I_BBcm_B(0, 2) = I_BBcm_B(2, 0) = given->products(1);
      I_BBcm_B(1, 2) = I_BBcm_B(2, 1) = given->products(2);
      const Eigen::Vector3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I_BBcm_B).eigenvalues();
      // Ascending order: a mass distribution has I1 > 0 and I1 + I2 ≥ I3.
      if (!(principal(0) > 0.0) || principal(0) + principal(1) < principal(2) * (1.0 - kDecimalRoundOff)) {
        Report(
            {path + ".moments", path + ".products"},
            fmt::format(
                "no body has such moments: the principal ones are {:.4g}, {:.4g} and {:.4g}, but each must be positive "
                "and no larger than the sum of the others",
                principal(0), principal(1), principal(2)));
      }
      return;
    }
    const bool has_volume = body.shape && !std::holds_alternative<HalfSpaceShape>(*body.shape);
    if (!has_volume) {
      Report({path + ".type", path, "bodies." + body.name + ".shape"},
             "needs a shape with a volume (sphere, capsule, box or designed_mesh); else give an explicit inertia");
    }
  }

  const Rope* FindRope(const std::string& name) const {
    const auto found =
        std::find_if(scene_.ropes.begin(), scene_.ropes.end(), [&](const Rope& r) { return r.name == name; });
    return found == scene_.ropes.end() ? nullptr : &*found;
  }

  void CheckRope(const Rope& rope) {
    const std::string path = "ropes." + rope.name;
    if (rope.gap >= rope.pitch) {
      Report({path + ".gap", path + ".pitch"},
             fmt::format("must be less than the pitch, {}", FormatQuantity(rope.pitch, kLength)));
      return;
    }
    const double most = 0.5 * std::min(rope.thickness, rope.pitch - rope.gap);
    if (rope.rounding > most) {
      Report({path + ".rounding", path + ".thickness"},
             fmt::format("must be at most half the least size, {}", FormatQuantity(most, kLength)));
    }
    if (const auto* straight = std::get_if<StraightState>(&rope.initial)) {
      if (straight->direction.norm() == 0.0) Report({path + ".initial.direction"}, "must not be zero");
      return;
    }
    const HelixState& helix = std::get<HelixState>(rope.initial);
    const double most_advance = 4.0 * static_cast<double>(helix.links_per_side) * rope.pitch;
    if (std::abs(helix.advance) >= most_advance) {
      Report({path + ".initial.advance", path + ".pitch"},
             fmt::format("must be less than the links of a turn are long, {}", FormatQuantity(most_advance, kLength)));
    }
  }

  void CheckContact(std::size_t i) {
    const std::string path = fmt::format("contacts[{}].bodies", i);
    const auto& [first, second] = scene_.contacts[i].bodies;
    const Body* a = FindBody(scene_, first);
    const Body* b = FindBody(scene_, second);
    const bool has_rope = FindRope(first) != nullptr || FindRope(second) != nullptr;
    if (!has_rope && (a == nullptr || b == nullptr)) return;  // reported where the name is read
    if (!has_rope && a == b) {
      Report({path}, "a contact needs two different bodies");
      return;
    }
    for (std::size_t earlier = 0; earlier < i; ++earlier) {
      const auto& [c, d] = scene_.contacts[earlier].bodies;
      if ((c == first && d == second) || (c == second && d == first)) {
        Report({path}, fmt::format("{} and {} already have a contact, contacts[{}]", first, second, earlier));
        return;
      }
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const Body* body = side == 0 ? a : b;
      if (body == nullptr || body->shape) continue;
      Report({fmt::format("{}[{}]", path, side), fmt::format("bodies.{}.shape", scene_.contacts[i].bodies[side])},
             "this body has no shape to touch with");
    }
  }

  void CheckGrip(std::size_t i) {
    const Grip& grip = scene_.grips[i];
    const std::string path = fmt::format("grips[{}]", i);
    if (grip.body == grip.held && !grip.body.empty()) Report({path + ".held"}, "a body cannot hold itself");
    if (grip.until <= grip.from) {
      Report({path + ".until", path + ".from"},
             fmt::format("must be more than `from`, {}", FormatQuantity(grip.from, kTime)));
    }
    const Rope* rope = FindRope(grip.held);
    if (rope == nullptr) return;
    const double length = static_cast<double>(rope->links) * rope->pitch;
    if (grip.held_point.x() < 0.0 || grip.held_point.x() > length * (1.0 + kDecimalRoundOff)) {
      Report({path + ".held_point[0]", path + ".held_point", "ropes." + rope->name + ".links"},
             fmt::format("must lie on the rope, from 0 m to {}", FormatQuantity(length, kLength)));
    }
  }

  void CheckDesign() {
    if (scene_.design) {
      for (const DesignedBody& body : scene_.design->bodies) CheckDesignedBody(body);
      for (const DesignParameter& parameter : scene_.design->parameters) CheckParameter(parameter);
    }
    // An entry that is wrong or of the wrong body may be what the following misses.
    if (log_.HasFailedNear("design.bodies") || HasMisplacedDesign()) return;
    for (const Body& body : scene_.bodies) {
      const std::string path = "bodies." + body.name;
      if (IsDesigned(body) && CountDesigns(body.name) == 0) {
        Report({path + ".shape.type", path}, scene_.design ? "needs an entry of design.bodies that gives the mesh"
                                                           : "needs a section 'design' that gives the mesh");
      }
      if (body.joint.attachment && CountDesigns(body.parent) == 0) {
        Report({path + ".joint.attachment", path + ".parent"},
               "only a designed parent has a mesh that joints move with");
      }
    }
  }

  static bool IsDesigned(const Body& body) {
    return body.shape && std::holds_alternative<DesignedMeshShape>(*body.shape);
  }

  bool HasMisplacedDesign() const {
    if (!scene_.design) return false;
    const std::vector<DesignedBody>& bodies = scene_.design->bodies;
    return std::any_of(bodies.begin(), bodies.end(), [&](const DesignedBody& designed) {
      const Body* body = FindBody(scene_, designed.name);
      return body != nullptr && !IsDesigned(*body);
    });
  }

  std::ptrdiff_t CountDesigns(const std::string& name) const {
    if (!scene_.design) return 0;
    const std::vector<DesignedBody>& bodies = scene_.design->bodies;
    return std::count_if(bodies.begin(), bodies.end(), [&](const DesignedBody& b) { return b.name == name; });
  }

  void CheckDesignedBody(const DesignedBody& designed) {
    const Body* body = FindBody(scene_, designed.name);
    if (body == nullptr) return;
    const std::string path = "design.bodies." + designed.name;
    if (!IsDesigned(*body)) {
      Report({path + ".name", "bodies." + designed.name + ".shape"},
             "the shape of this body must be of type designed_mesh");
    }
    if (CountDesigns(designed.name) > 1) Report({path + ".name"}, "is given twice");
    for (const VertexGroup& group : designed.vertex_groups) {
      if (HasRepeats(group.vertices)) {
        Report({path + ".vertex_groups." + group.name + ".vertices"}, "names a vertex twice");
      }
    }
    for (std::size_t i = 0; i < designed.moves.size(); ++i) {
      const std::string& name = designed.moves[i].group;
      const bool own = std::any_of(designed.vertex_groups.begin(), designed.vertex_groups.end(),
                                   [&](const VertexGroup& group) { return group.name == name; });
      const std::string move = fmt::format("{}.moves[{}].group", path, i);
      if (!own && !log_.HasFailedNear(move)) Report({move}, "is a vertex group of another body");
    }
  }

  void CheckParameter(const DesignParameter& parameter) {
    if (parameter.name.empty()) return;
    const std::string path = "design.parameters." + parameter.name;
    const Dimension dimension = parameter.kind == ParameterKind::kStretch ? kDimensionless : kLength;
    if (parameter.lower >= parameter.upper) {
      Report({path + ".lower", path + ".upper"},
             fmt::format("must be less than upper, {}", FormatQuantity(parameter.upper, dimension)));
    } else if (parameter.initial < parameter.lower || parameter.initial > parameter.upper) {
      Report({path + ".initial", path + ".lower", path + ".upper"},
             fmt::format("must lie from lower, {}, to upper, {}", FormatQuantity(parameter.lower, dimension),
                         FormatQuantity(parameter.upper, dimension)));
    }
    for (const DesignedBody& body : scene_.design->bodies) {
      for (const CageMove& move : body.moves) {
        if (move.parameter == parameter.name && move.direction.norm() > 0.0) return;
      }
    }
    Report({path + ".name", "design.bodies"}, "moves no vertex of a cage; see design.bodies");
  }

  void CheckRollout() {
    const Rollout& rollout = scene_.rollout;
    if (!IsWholeMultiple(rollout.horizon, rollout.step)) {
      Report({"rollout.horizon", "rollout.step"},
             fmt::format("must be a whole number of steps of {}", FormatQuantity(rollout.step, kTime)));
    }
  }

  void CheckLoss() {
    for (std::size_t i = 0; i < scene_.loss.task.size(); ++i) {
      const std::string path = fmt::format("loss.task[{}]", i);
      const TaskTerm& term = scene_.loss.task[i];
      if (const auto* crossing = std::get_if<CrossingLoss>(&term)) CheckOpening(crossing->opening, path);
      if (const auto* hold = std::get_if<HeightHoldLoss>(&term)) CheckHeight(hold->height, path);
      if (std::holds_alternative<ControlCostLoss>(term) && !scene_.IsDriven()) {
        Report({path + ".type", path}, "the scenario has no section controls or policy");
      }
      if (const auto* target = std::get_if<PointTargetLoss>(&term)) CheckPointTarget(*target, path);
    }
    for (std::size_t i = 0; i < scene_.loss.distillation.size(); ++i) {
      const std::string path = fmt::format("loss.distillation[{}]", i);
      const DistillationTerm& term = scene_.loss.distillation[i];
      if (const auto* match = std::get_if<PositionMatchLoss>(&term)) {
        if (HasRepeats(match->axes)) Report({path + ".axes"}, "names an axis twice");
        CheckSampling(match->sample_period, scene_.rollout.horizon, "rollout.horizon", path);
      }
      if (const auto* height = std::get_if<HeightLoss>(&term)) CheckHeight(*height, path);
    }
    if (!scene_.success) return;
    if (const auto* crosses = std::get_if<CrossesOpening>(&*scene_.success)) CheckOpening(crosses->opening, "success");
    if (const auto* holds = std::get_if<HoldsRope>(&*scene_.success)) {
      const bool touch = std::any_of(scene_.contacts.begin(), scene_.contacts.end(), [&](const Contact& contact) {
        const auto& [a, b] = contact.bodies;
        return (a == holds->rope && b == holds->body) || (b == holds->rope && a == holds->body);
      });
      if (!touch) Report({"success.body", "contacts"}, fmt::format("has no contact with {}", holds->rope));
    }
  }

  void CheckSampling(double period, double end, const std::string& end_path, const std::string& path) {
    if (!IsWholeMultiple(period, scene_.rollout.step)) {
      Report({path + ".sample_period", "rollout.step"},
             fmt::format("must be a whole number of steps of {}", FormatQuantity(scene_.rollout.step, kTime)));
    } else if (period > end) {
      Report({path + ".sample_period", end_path},
             fmt::format("must be at most {}, {}", end_path == "rollout.horizon" ? "the horizon" : "`until`",
                         FormatQuantity(end, kTime)));
    }
  }

  void CheckHeight(const HeightLoss& loss, const std::string& path) {
    CheckSampling(loss.sample_period, loss.until, path + ".until", path);
    if (loss.until > scene_.rollout.horizon) {
      Report({path + ".until", "rollout.horizon"},
             fmt::format("must be at most the horizon, {}", FormatQuantity(scene_.rollout.horizon, kTime)));
    }
    if (loss.from == 0.0) return;
    if (!IsWholeMultiple(loss.from, loss.sample_period)) {
      Report({path + ".from", path + ".sample_period"},
             fmt::format("must be a whole number of sample periods of {}", FormatQuantity(loss.sample_period, kTime)));
    } else if (loss.from >= loss.until) {
      Report({path + ".from", path + ".until"},
             fmt::format("must be less than `until`, {}", FormatQuantity(loss.until, kTime)));
    }
  }

  void CheckPointTarget(const PointTargetLoss& loss, const std::string& path) {
    CheckSampling(loss.sample_period, scene_.rollout.horizon, "rollout.horizon", path);
    for (std::size_t i = 0; i < loss.targets.size(); ++i) {
      const std::string from = fmt::format("{}.targets[{}].from", path, i);
      if (i == 0 && loss.targets[i].from != 0.0) {
        Report({from}, "the first target must count from 0 s");
      } else if (i > 0 && loss.targets[i].from <= loss.targets[i - 1].from) {
        Report({from}, "must be later than the target before");
      }
    }
  }

  void CheckOpening(const Opening& opening, const std::string& path) {
    if (opening.axis != opening.opening_axis) return;
    Report({path + ".opening_axis", path + ".axis"}, "must differ from axis: the opening lies in the plane");
  }

  void CheckVariation() {
    const std::vector<NumericKey> keys = ListNumericKeys(scene_);
    for (std::size_t i = 0; i < scene_.variation.size(); ++i) {
      const Variation& variation = scene_.variation[i];
      const std::string path = fmt::format("variation[{}]", i);
      for (std::size_t earlier = 0; earlier < i; ++earlier) {
        if (scene_.variation[earlier].key != variation.key) continue;
        Report({path + ".key"}, fmt::format("already varies, see variation[{}]", earlier));
        break;
      }
      const auto key =
          std::find_if(keys.begin(), keys.end(), [&](const NumericKey& k) { return k.path == variation.key; });
      if (key != keys.end()) CheckDistribution(variation, *key, path);
    }
  }

  void CheckDistribution(const Variation& variation, const NumericKey& key, const std::string& path) {
    const std::string allowed = DescribeRange(key.range, key.dimension);
    if (const auto* uniform = std::get_if<UniformDistribution>(&variation.distribution)) {
      const std::string lower = path + ".lower";
      const std::string upper = path + ".upper";
      if (uniform->lower > uniform->upper) {
        Report({lower, upper}, fmt::format("must be at most upper, {}", FormatQuantity(uniform->upper, key.dimension)));
      }
      if (!key.range.Contains(uniform->lower)) Report({lower, path + ".key"}, "the key must be " + allowed);
      if (!key.range.Contains(uniform->upper)) Report({upper, path + ".key"}, "the key must be " + allowed);
    } else if (const auto* normal = std::get_if<NormalDistribution>(&variation.distribution)) {
      const double reach = normal->truncate_at * normal->std;
      if (!key.range.Contains(normal->mean - reach) || !key.range.Contains(normal->mean + reach)) {
        Report({path + ".mean", path + ".std", path + ".truncate_at", path + ".key"},
               fmt::format("draws reach from {} to {}, but the key must be {}",
                           FormatQuantity(normal->mean - reach, key.dimension),
                           FormatQuantity(normal->mean + reach, key.dimension), allowed));
      }
    }
  }

  // Where nothing varies there is one rollout to learn from and one to test; what the file says must not differ.
  void SettleWithoutVariation() {
    const std::pair<std::string, std::int64_t*> counts[] = {
        {"learning.variations", &scene_.learning.variations},
        {"learning.batch", &scene_.learning.batch},
        {"evaluation.variations", &scene_.evaluation.variations},
    };
    for (const auto& [path, count] : counts) {
      if (log_.IsGiven(path) && *count != 1) {
        Report({path}, "the scenario has no section variation, so all rollouts are alike: must be 1");
      }
      *count = 1;
    }
  }

  void CheckLearning() {
    if (scene_.variation.empty() && !log_.HasFailedNear("variation")) SettleWithoutVariation();
    const Learning& learning = scene_.learning;
    if (learning.batch > learning.variations) {
      Report({"learning.batch", "learning.variations"},
             fmt::format("a batch has at most all {} variations", learning.variations));
    }
    if (!scene_.design) return;
    const auto d = static_cast<std::int64_t>(scene_.design->parameters.size());
    if (learning.dimensions_per_batch > d) {
      Report({"learning.dimensions_per_batch", "design.parameters"},
             fmt::format("must be at most the number of design parameters, {}", d));
    }
  }

  Scene& scene_;
  FieldLog& log_;
};

}  // namespace

void CheckScene(Scene& scene, FieldLog& log) { SceneChecker(scene, log).Check(); }

}  // namespace knap
