#include "sim/rollout/rollout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/geometry/mesh_io.h"
#include "sim/rollout/height_loss.h"
#include "sim/scenarios/numeric_keys.h"
#include "sim/scenarios/scenario_files.h"

namespace knap {

using Eigen::VectorXd;

namespace {

constexpr std::size_t kCachedMeshes = 4;
constexpr std::size_t kCachedReferences = 64;

CageDesign MakeCageDesign(const Design& design, const std::map<std::string, std::string>& files) {
  TriangleMesh mesh = ReadMesh(design.mesh, files.at(design.mesh), design.mesh_unit);
  TriangleMesh cage = ReadMesh(design.cage, files.at(design.cage), design.mesh_unit);
  VectorXd theta(design.parameters.size());
  std::map<std::string, int> parameter_index;
  for (std::size_t i = 0; i < design.parameters.size(); ++i) {
    theta(static_cast<Eigen::Index>(i)) = design.parameters[i].initial;
    parameter_index[design.parameters[i].name] = static_cast<int>(i);
  }
  std::vector<VertexMove> moves;
  for (const auto& move : design.moves) {
    for (const auto& group : design.vertex_groups) {
      if (group.name != move.group) continue;
      for (const auto vertex : group.vertices) {
        moves.push_back({parameter_index.at(move.parameter), static_cast<int>(vertex), move.direction});
      }
    }
  }
  return CageDesign(std::move(mesh), std::move(cage), std::move(theta), moves);
}

SimulationOptions MakeOptions(const Rollout& rollout) {
  SimulationOptions options;
  options.step = rollout.step;
  options.steps = static_cast<int>(std::llround(rollout.horizon / rollout.step));
  options.order = rollout.integrator == Integrator::kBdf2 ? 2 : 1;
  options.newton_tolerance = rollout.newton_tolerance;
  options.newton_max_iterations = static_cast<int>(rollout.newton_max_iterations);
  return options;
}

}  // namespace

RolloutModel::RolloutModel(const std::map<std::string, std::string>& files) : scene_(ParseScenarioFiles(files)) {
  if (scene_.design) {
    design_ = MakeCageDesign(*scene_.design, files);
    sampling_ = MakeSampling(scene_, design_->initial_mesh());
    parameter_ranges_.resize(num_parameters());
    for (int i = 0; i < num_parameters(); ++i) {
      const DesignParameter& parameter = scene_.design->parameters[static_cast<std::size_t>(i)];
      parameter_ranges_(i) = parameter.upper - parameter.lower;
    }
  }
  // Whatever this simulator cannot do shows now, not in the first rollout.
  ContactModel(BuildModel(scene_, design_ ? GetMesh(design_->initial_theta()) : nullptr).contacts);
}

std::shared_ptr<const ContactMesh> RolloutModel::GetMesh(const VectorXd& theta) {
  if (!design_) return nullptr;
  for (auto it = meshes_.begin(); it != meshes_.end(); ++it) {
    if (it->first == theta) {
      meshes_.splice(meshes_.begin(), meshes_, it);
      return meshes_.front().second;
    }
  }
  meshes_.emplace_front(theta, std::make_shared<ContactMesh>(design_->CalcMesh(theta), sampling_));
  if (meshes_.size() > kCachedMeshes) meshes_.pop_back();
  return meshes_.front().second;
}

Scene RolloutModel::MakeVariedScene(const std::vector<double>& variation) const {
  Scene varied = scene_;
  ApplyVariation(varied, variation);
  return varied;
}

RolloutModel::Simulated RolloutModel::Simulate(const VectorXd& theta, const Scene& varied,
                                               const std::function<void(int)>& progress) {
  Simulated out;
  out.model = BuildModel(varied, GetMesh(theta));
  out.dynamics = std::make_unique<Dynamics>(out.model.tree);
  out.contacts = std::make_unique<ContactModel>(out.model.contacts);
  SimulationOptions options = MakeOptions(varied.rollout);
  options.progress = progress;
  out.trajectory = std::make_unique<Trajectory>(
      Simulator(out.dynamics.get(), out.contacts.get()).Run(out.model.q0, out.model.v0, options));
  return out;
}

const RolloutModel::Reference& RolloutModel::GetReference(const RolloutInput& input, const Scene& varied) {
  for (auto it = references_.begin(); it != references_.end(); ++it) {
    if (it->theta == input.theta_reference && it->variation == input.variation) {
      references_.splice(references_.begin(), references_, it);
      return references_.front();
    }
  }
  Reference reference{input.theta_reference, input.variation, {}};
  const Simulated simulated = Simulate(input.theta_reference, varied, {});
  if (simulated.trajectory->certificate.converged) {
    for (const DistillationTerm& term : varied.loss.distillation) {
      Reference::Path path;
      if (const auto* match = std::get_if<PositionMatchLoss>(&term)) {
        path.body =
            TraceBody(*simulated.trajectory, simulated.model.body_index.at(match->body), simulated.dynamics.get());
      } else {
        path.heights = TraceHeight(std::get<HeightLoss>(term), varied.rollout.step, simulated.model,
                                   *simulated.trajectory, simulated.dynamics.get());
      }
      reference.paths.push_back(std::move(path));
    }
  }
  references_.push_front(std::move(reference));
  if (references_.size() > kCachedReferences) references_.pop_back();
  return references_.front();
}

bool RolloutModel::Succeeds(const Simulated& s, const Scene& varied) {
  if (const auto* test = std::get_if<CrossesOpening>(&*varied.success)) {
    const int body = s.model.body_index.at(test->opening.body);
    return CrossesInside(test->opening, TraceBody(*s.trajectory, body, s.dynamics.get()));
  }
  return HoldsRopeAtEnd(std::get<HoldsRope>(*varied.success), varied, s.model, *s.trajectory, s.dynamics.get());
}

RolloutOutput RolloutModel::Run(const RolloutInput& input, const std::function<void(int, int)>& progress) {
  const int d = num_parameters();
  if (input.theta.size() != d || (input.theta_reference.size() != 0 && input.theta_reference.size() != d)) {
    throw std::invalid_argument(
        fmt::format("theta has {} values, theta_reference {}; the scenario has {} parameters", input.theta.size(),
                    input.theta_reference.size(), d));
  }
  if (!input.theta.allFinite() || !input.theta_reference.allFinite()) {
    throw std::invalid_argument("theta is not finite");
  }
  const double start = clock ? clock() : 0.0;
  const Scene varied = MakeVariedScene(input.variation);
  const int total = static_cast<int>(std::llround(varied.rollout.horizon / varied.rollout.step));
  const bool distill = input.theta_reference.size() > 0;
  const Reference* reference = distill ? &GetReference(input, varied) : nullptr;

  Simulated s = Simulate(input.theta, varied, progress ? [&](int done) { progress(done, total); }
                                                       : std::function<void(int)>());
  RolloutOutput out;
  out.certificate = s.trajectory->certificate;
  out.steps = s.trajectory->whole_steps();
  if (distill && reference->paths.size() != varied.loss.distillation.size()) out.certificate.converged = false;
  if (!out.certificate.converged) {
    out.loss = std::numeric_limits<double>::quiet_NaN();
    out.certificate.finite = false;
    forward_s = clock ? clock() - start : 0.0;
    gradient_s = 0.0;
    return out;
  }
  const auto trace = [&](const std::string& body) {
    return TraceBody(*s.trajectory, s.model.body_index.at(body), s.dynamics.get());
  };
  std::vector<StateCotangent> cotangents;
  // Null reference: the height at the start.
  const auto add_height = [&](const HeightLoss& loss, const std::vector<double>* heights_reference) {
    const std::vector<double> heights =
        TraceHeight(loss, varied.rollout.step, s.model, *s.trajectory, s.dynamics.get());
    out.loss += EvaluateHeight(loss, varied.rollout.step, s.model, *s.trajectory, heights,
                               heights_reference ? *heights_reference : std::vector<double>{heights[0]},
                               s.dynamics.get(), &cotangents);
  };
  if (distill) {
    for (std::size_t i = 0; i < varied.loss.distillation.size(); ++i) {
      const DistillationTerm& term = varied.loss.distillation[i];
      const Reference::Path& path = reference->paths[i];
      if (const auto* match = std::get_if<PositionMatchLoss>(&term)) {
        out.loss += EvaluatePositionMatch(*match, varied.rollout.step, trace(match->body), path.body, &cotangents);
      } else {
        add_height(std::get<HeightLoss>(term), &path.heights);
      }
    }
  } else {
    for (const TaskTerm& term : varied.loss.task) {
      if (const auto* crossing = std::get_if<CrossingLoss>(&term)) {
        out.loss += EvaluateCrossingLoss(*crossing, trace(crossing->opening.body), &cotangents);
      } else {
        add_height(std::get<HeightLoss>(term), nullptr);
      }
    }
  }
  out.success = varied.success && Succeeds(s, varied);
  out.certificate.finite = std::isfinite(out.loss);
  const double middle = clock ? clock() : 0.0;
  forward_s = middle - start;
  if (input.want_gradient) {
    std::stable_sort(cotangents.begin(), cotangents.end(),
                     [](const StateCotangent& a, const StateCotangent& b) { return a.state < b.state; });
    out.gradient = VectorXd::Zero(d);
    if (!cotangents.empty()) {
      const TrajectoryGradient gradient = SweepAdjoint(*s.trajectory, cotangents, s.dynamics.get(), s.contacts.get());
      out.loss_rounding = gradient.loss_rounding;
      out.certificate.finite = out.certificate.finite && gradient.finite;
      out.certificate.converged = out.certificate.converged && gradient.solvable;
      Eigen::Matrix3Xd vertices;
      for (const Eigen::Matrix3Xd& of_contact : gradient.vertices) {
        if (of_contact.cols() == 0) continue;
        if (vertices.cols() == 0) vertices.setZero(3, of_contact.cols());
        vertices += of_contact;
      }
      if (vertices.cols() > 0) out.gradient = design_->PullBack(vertices);
      // A gradient of zero is one that nothing contests: what the tool never touched.
      const double g = (out.gradient.array() * parameter_ranges_.array()).abs().maxCoeff();
      out.smooth = g == 0.0 || out.loss_rounding <= kLargestSmoothRounding * varied.gradient.tolerance * g;
    }
  }
  gradient_s = clock ? clock() - middle : 0.0;
  return out;
}

BodyPath RolloutModel::Trace(const VectorXd& theta, const std::vector<double>& variation, const std::string& body) {
  const Simulated s = Simulate(theta, MakeVariedScene(variation), {});
  return TraceBody(*s.trajectory, s.model.body_index.at(body), s.dynamics.get());
}

RopeStills RolloutModel::TraceRope(const VectorXd& theta, const std::vector<double>& variation,
                                   const std::string& rope) {
  const Scene varied = MakeVariedScene(variation);
  const Simulated s = Simulate(theta, varied, {});
  const auto look = [&](int state) {
    s.dynamics->CalcKinematics(s.trajectory->q(state), s.trajectory->v(state), s.trajectory->vdot(state),
                               s.trajectory->time(state));
    RopeStill still{{}, s.model.tree.gravity};
    for (const int i : s.model.links.at(rope)) still.X_WL.push_back(s.dynamics->kinematics()[i].X_WB);
    return still;
  };
  const bool success = s.trajectory->certificate.converged && varied.success && Succeeds(s, varied);
  return {look(0), look(s.trajectory->size() - 1), success};
}

}  // namespace knap
