#include "coordinator/report/top_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <variant>

namespace knap {
namespace {

constexpr double kMoved = 0.5e-3;   // a body farther than this from its start has been touched [m]
constexpr double kPathStep = 1e-3;  // least distance of drawn points [m]
constexpr std::size_t kPosesBetween = 5;

const Body* FindBody(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& b) { return b.name == name; });
  return found == scene.bodies.end() ? nullptr : &*found;
}

bool Turns(const Body& body) {
  if (body.parent != kWorldName || !body.joint.orientation_rpy.isZero(0.0)) return true;
  const auto* prescribed = std::get_if<PrescribedJoint>(&body.joint.kind);
  if (prescribed == nullptr) return !std::holds_alternative<FixedJoint>(body.joint.kind);
  const auto* constant = std::get_if<ConstantVelocityMotion>(&prescribed->motion);
  return constant != nullptr && !constant->angular_velocity.isZero(0.0);
}

Eigen::Vector2d Project(const Eigen::Vector3d& p_W, const Opening& opening) {
  return {p_W[static_cast<int>(opening.opening_axis)], p_W[static_cast<int>(opening.axis)]};
}

Outline Shift(Outline outline, const Eigen::Vector2d& by) {
  for (auto& loop : outline) {
    for (Eigen::Vector2d& point : loop) point += by;
  }
  return outline;
}

std::optional<double> FindTouchTime(const BodyPath& path) {
  for (std::size_t i = 0; i < path.p_W.size(); ++i) {
    if ((path.p_W[i] - path.p_W.front()).norm() > kMoved) return path.time[i];
  }
  return std::nullopt;
}

std::vector<Eigen::Vector2d> ThinOut(const BodyPath& path, const Opening& opening) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& p_W : path.p_W) {
    const Eigen::Vector2d point = Project(p_W, opening);
    if (points.empty() || (point - points.back()).norm() > kPathStep) points.push_back(point);
  }
  return points;
}

}  // namespace

std::optional<Opening> FindShownOpening(const Scene& scene) {
  if (!scene.success || !scene.design || scene.design->bodies.size() != 1 || scene.IsDriven()) return std::nullopt;
  const auto* test = std::get_if<CrossesOpening>(&*scene.success);
  const Body* tool = FindBody(scene, scene.design->bodies[0].name);
  if (test == nullptr || tool == nullptr || Turns(*tool)) return std::nullopt;
  return test->opening;
}

TopView TraceTopView(RolloutModel& model, const std::vector<double>& theta,
                     const std::vector<std::vector<double>>& variations, const Opening& opening) {
  const Eigen::VectorXd design =
      Eigen::Map<const Eigen::VectorXd>(theta.data(), static_cast<Eigen::Index>(theta.size()));
  TopView view;
  std::vector<double> touch_times;
  for (const std::vector<double>& variation : variations) {
    const BodyPath path = model.Trace({design, {}, variation}, opening.body);
    if (const std::optional<double> time = FindTouchTime(path)) touch_times.push_back(*time);
    view.paths.push_back({ThinOut(path, opening), CrossesInside(opening, path)});
  }
  std::sort(touch_times.begin(), touch_times.end());
  const double contact_time = touch_times.empty() ? 0.0 : touch_times[touch_times.size() / 2];

  const std::string& tool_name = model.design()->bodies().front();
  const BodyPath tool = model.Trace({design, {}, variations.front()}, tool_name);
  const auto at_contact = static_cast<std::size_t>(
      std::lower_bound(tool.time.begin(), tool.time.end() - 1, contact_time) - tool.time.begin());
  const Outline outline = CalcSilhouette(model.design()->Find(tool_name)->CalcMesh(design),
                                         static_cast<int>(opening.opening_axis), static_cast<int>(opening.axis));
  view.tool_at_contact = Shift(outline, Project(tool.p_W[at_contact], opening));
  const std::size_t way = tool.p_W.size() - 1 - at_contact;
  for (std::size_t k = 1; k <= kPosesBetween; ++k) {
    view.tool_between.push_back(Shift(outline, Project(tool.p_W[at_contact + way * k / (kPosesBetween + 1)], opening)));
  }
  view.tool_at_end = Shift(outline, Project(tool.p_W.back(), opening));
  return view;
}

Eigen::AlignedBox2d FindStartBox(const Scene& scene, const VariationSpec& variations, const Opening& opening) {
  const Body* body = FindBody(scene, opening.body);
  if (body == nullptr || body->parent != kWorldName || !body->joint.orientation_rpy.isZero(0.0)) return {};
  const auto find = [&](Axis axis) -> std::optional<UniformDraw> {
    const std::string key = fmt::format("bodies.{}.initial.position[{}]", opening.body, static_cast<int>(axis));
    for (const VariationKey& variation : variations) {
      const auto* uniform = std::get_if<UniformDraw>(&variation.distribution);
      if (variation.name == key && uniform != nullptr) return *uniform;
    }
    return std::nullopt;
  };
  const std::optional<UniformDraw> right = find(opening.opening_axis), up = find(opening.axis);
  if (!right || !up) return {};
  const Eigen::Vector2d origin = Project(body->joint.position, opening);
  return {origin + Eigen::Vector2d(right->lower, up->lower), origin + Eigen::Vector2d(right->upper, up->upper)};
}

double FindBodyRadius(const Scene& scene, const std::string& body_name) {
  const Body* body = FindBody(scene, body_name);
  if (body == nullptr || !body->shape) return 0.0;
  const auto* sphere = std::get_if<SphereShape>(&*body->shape);
  return sphere == nullptr ? 0.0 : sphere->radius;
}

}  // namespace knap
