#include "sim/scenarios/check_values.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "sim/scenarios/check_objective.h"
#include "sim/scenarios/check_rules.h"
#include "sim/scenarios/units.h"

namespace knap {
namespace {

constexpr double kMostPairs = 1e6;  // of links of two ropes, or of one with itself

class ValueChecker {
 public:
  explicit ValueChecker(const Scene& scene) : scene_(scene) {}

  std::vector<ValueFault> Check() {
    for (const Body& body : scene_.bodies) CheckBody(body);
    for (const Rope& rope : scene_.ropes) CheckRope(rope);
    for (std::size_t i = 0; i < scene_.contacts.size(); ++i) CheckContact(i);
    for (std::size_t i = 0; i < scene_.grips.size(); ++i) CheckGrip(i);
    const std::vector<ValueFault> of_objective = FindObjectiveFaults(scene_);
    faults_.insert(faults_.end(), of_objective.begin(), of_objective.end());
    return std::move(faults_);
  }

 private:
  void Report(std::vector<std::string> paths, std::string message) {
    faults_.push_back({std::move(paths), std::move(message)});
  }

  // Bodies without a valid name have been reported, and nothing can refer to them.
  void CheckBody(const Body& body) {
    if (body.name.empty()) return;
    const std::string path = "bodies." + body.name;
    if (const auto* given = body.inertia ? std::get_if<ExplicitInertia>(&*body.inertia) : nullptr) {
      CheckInertia(*given, path + ".inertia");
    }
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      const auto* box = std::get_if<BoxShape>(&body.shapes[i].kind);
      if (box == nullptr || box->rounding <= 0.5 * box->size.minCoeff()) continue;
      Report(
          {GetShapePath(body, i) + ".rounding", GetShapePath(body, i) + ".size"},
          fmt::format("must be at most half the least size, {}", FormatQuantity(0.5 * box->size.minCoeff(), kLength)));
    }
    std::visit(
        [&](const auto& joint) {
          if constexpr (requires { joint.axis; }) CheckOneDofJoint(joint, path + ".joint");
        },
        body.joint.kind);
    if (const auto* prescribed = std::get_if<PrescribedJoint>(&body.joint.kind)) {
      CheckMotion(prescribed->motion, body, path + ".joint.motion");
    }
  }

  void CheckMotion(const Motion& motion, const Body& body, const std::string& path) {
    if (const auto* segments = std::get_if<SegmentsMotion>(&motion)) {
      for (std::size_t i = 0; i < segments->segments.size(); ++i) {
        CheckSegment(segments->segments[i], body, fmt::format("{}.segments[{}]", path, i));
      }
    }
    const auto* joint_path = std::get_if<JointPathMotion>(&motion);
    if (joint_path != nullptr && joint_path->axis.norm() == 0.0) Report({path + ".axis"}, "must not be zero");
  }

  void CheckInertia(const ExplicitInertia& given, const std::string& path) {
    Eigen::Matrix3d I_BBcm_B = given.moments.asDiagonal();
    I_BBcm_B(0, 1) = I_BBcm_B(1, 0) = given.products(0);
    I_BBcm_B(0, 2) = I_BBcm_B(2, 0) = given.products(1);
    I_BBcm_B(1, 2) = I_BBcm_B(2, 1) = given.products(2);
    const Eigen::Vector3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I_BBcm_B).eigenvalues();
    // Ascending order: a mass distribution has I1 > 0 and I1 + I2 ≥ I3.
    if (principal(0) > 0.0 && principal(0) + principal(1) >= principal(2) * (1.0 - kDecimalRoundOff)) return;
    Report({path + ".moments", path + ".products"},
           fmt::format(
               "no body has such moments: the principal ones are {:.4g}, {:.4g} and {:.4g}, but each must be positive "
               "and no larger than the sum of the others",
               principal(0), principal(1), principal(2)));
  }

  template <class OneDofJoint>
  void CheckOneDofJoint(const OneDofJoint& joint, const std::string& path) {
    if (joint.axis.norm() == 0.0) Report({path + ".axis"}, "must not be zero");
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
    const auto& [first, second] = scene_.contacts[i].bodies;
    const auto count = [&](const std::string& name) {
      const Rope* rope = FindRope(scene_, name);
      return rope == nullptr ? 1.0 : static_cast<double>(rope->links);
    };
    if (count(first) * count(second) <= kMostPairs) return;
    Report({fmt::format("contacts[{}].bodies", i), "ropes." + first + ".links", "ropes." + second + ".links"},
           fmt::format("these are {:.0f} pairs of links, at most {:.0f} are allowed", count(first) * count(second),
                       kMostPairs));
  }

  void CheckGrip(std::size_t i) {
    const Grip& grip = scene_.grips[i];
    const std::string path = fmt::format("grips[{}]", i);
    if (grip.until <= grip.from) {
      Report({path + ".until", path + ".from"},
             fmt::format("must be more than `from`, {}", FormatQuantity(grip.from, kTime)));
    }
    const Rope* rope = FindRope(scene_, grip.held);
    if (rope == nullptr) return;
    const double length = static_cast<double>(rope->links) * rope->pitch;
    if (grip.held_point.x() < 0.0 || grip.held_point.x() > length * (1.0 + kDecimalRoundOff)) {
      Report({path + ".held_point[0]", path + ".held_point", "ropes." + rope->name + ".links"},
             fmt::format("must lie on the rope, from 0 m to {}", FormatQuantity(length, kLength)));
    }
  }

  const Scene& scene_;
  std::vector<ValueFault> faults_;
};

}  // namespace

std::vector<ValueFault> FindValueFaults(const Scene& scene) { return ValueChecker(scene).Check(); }

}  // namespace knap
