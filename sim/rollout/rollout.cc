#include "sim/rollout/rollout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/gradient/node_windows.h"
#include "sim/rollout/rollout_simulation.h"

namespace knap {

using Eigen::VectorXd;

namespace {

constexpr std::size_t kCachedReferences = 64;
constexpr std::size_t kCachedNodes = 16;
// Touchdowns after which the time nodes are suspect: what follows one or two is exact.
constexpr int kLeastCascade = 3;

SimulationOptions MakeOptions(const Rollout& rollout) {
  SimulationOptions options;
  options.step = rollout.step;
  options.steps = static_cast<int>(std::llround(rollout.horizon / rollout.step));
  options.order = rollout.integrator == Integrator::kBdf1 ? 1 : 2;
  if (rollout.integrator == Integrator::kTrBdf2) options.tolerance = rollout.tolerance;
  options.newton_tolerance = rollout.newton_tolerance;
  options.newton_max_iterations = static_cast<int>(rollout.newton_max_iterations);
  return options;
}

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Of a rollout that failed. Who asks for a gradient gets one of its size: the protocol holds every other for an error.
void SetGradientUnknown(const RolloutInput& input, RolloutOutput* out) {
  out->gradient_reliable = false;
  if (!input.want_gradient) return;
  out->gradient = VectorXd::Constant(input.theta.size(), kUnknown);
  out->control_gradient = VectorXd::Constant(input.controls.size(), kUnknown);
}

bool Distills(const RolloutInput& input) { return input.theta_reference.size() + input.controls_reference.size() > 0; }

bool FollowsNodes(const RolloutInput& input) { return input.theta_nodes.size() + input.controls_nodes.size() > 0; }

// Rows as FindCommandRow counts them.
Eigen::MatrixXd StackCommands(const Eigen::MatrixXd& open_loop, const ClosedLoop* policy) {
  if (policy == nullptr) return open_loop;
  Eigen::MatrixXd commands(open_loop.rows() + policy->commands().rows(), policy->commands().cols());
  // Without open-loop controls there are no columns either.
  if (open_loop.rows() > 0) commands.topRows(open_loop.rows()) = open_loop;
  commands.bottomRows(policy->commands().rows()) = policy->commands();
  return commands;
}

// "pea and table": those of a pair of the contact model.
std::string NamePair(const Scene& scene, const SceneModel& model, int pair) {
  const auto contact = static_cast<std::size_t>(model.contact_of_pair[static_cast<std::size_t>(pair)]);
  const auto& bodies = scene.contacts[contact].bodies;
  return fmt::format("{} and {}", bodies[0], bodies[1]);
}

}  // namespace

RolloutSimulation::RolloutSimulation(const std::map<std::string, std::string>& files) : source_(files) {
  // Whatever this simulator cannot do shows now, not in the first rollout.
  ContactModel(source_.BuildInitialModel().contacts);
}

RolloutSimulation::Simulated RolloutSimulation::Simulate(const VectorXd& theta, const VectorXd& controls,
                                                         const std::vector<double>& variation, const Manner& manner) {
  Simulated s;
  static_cast<BuiltScene&>(s) = source_.Build(theta, variation);
  const Eigen::Index open_loop = CountControls(s.scene);
  if (s.scene.controls) s.commands = CalcCommands(*s.scene.controls, controls.head(open_loop));
  if (s.scene.policy) {
    s.policy = std::make_unique<ClosedLoop>(
        MakeClosedLoop(s.scene, *s.signals, s.model, controls.tail(controls.size() - open_loop)));
  }
  s.dynamics = std::make_unique<Dynamics>(s.model.tree);
  s.contacts = std::make_unique<ContactModel>(s.model.contacts, s.model.grips);
  SimulationOptions options = MakeOptions(s.scene.rollout);
  options.progress = manner.progress;
  if (manner.finer) options.tolerance *= 0.25;
  options.nodes = manner.nodes;
  Simulator simulator(s.dynamics.get(), s.contacts.get());
  ForceRecord record;
  if (manner.observe || !s.signals->forces().empty()) {
    simulator.observer = [&](double time) {
      AddToRecord(time, s.signals->forces(), *s.contacts, &record);
      if (manner.observe) manner.observe(s, time);
    };
  }
  s.trajectory = std::make_unique<Trajectory>(simulator.Run(
      s.model.q0, s.model.v0, options, MakeControlSequence(s.scene, s.model, s.commands), s.policy.get()));
  s.track =
      std::make_unique<SimulatedTrack>(*s.trajectory, s.dynamics.get(), s.scene.rollout.step, s.signals->remembered(),
                                       StackCommands(s.commands, s.policy.get()), std::move(record));
  return s;
}

const RolloutSimulation::Reference& RolloutSimulation::GetReference(const RolloutInput& input) {
  for (auto it = references_.begin(); it != references_.end(); ++it) {
    if (it->theta == input.theta_reference && it->controls == input.controls_reference &&
        it->variation == input.variation) {
      references_.splice(references_.begin(), references_, it);
      return references_.front();
    }
  }
  Reference reference{input.theta_reference, input.controls_reference, input.variation, {}};
  const Simulated s = Simulate(input.theta_reference, input.controls_reference, input.variation, {});
  if (s.trajectory->certificate.converged) {
    for (const Term& term : s.scene.loss.distillation) reference.terms.push_back(TraceTerm(term, s.watched()));
  }
  references_.push_front(std::move(reference));
  if (references_.size() > kCachedReferences) references_.pop_back();
  return references_.front();
}

std::shared_ptr<const TimeNodeList> RolloutSimulation::GetNodes(const RolloutInput& input) {
  for (auto it = nodes_.begin(); it != nodes_.end(); ++it) {
    if (it->theta == input.theta_nodes && it->controls == input.controls_nodes && it->variation == input.variation) {
      nodes_.splice(nodes_.begin(), nodes_, it);
      return nodes_.front().list;
    }
  }
  Nodes nodes{input.theta_nodes, input.controls_nodes, input.variation, nullptr};
  const Simulated s = Simulate(input.theta_nodes, input.controls_nodes, input.variation, {});
  if (s.trajectory->certificate.converged) {
    SignalCotangents bar;
    Evaluate(s, nullptr, &bar);
    nodes.list = std::make_shared<const TimeNodeList>(
        ListFollowingNodes(*s.trajectory, bar.states, s.dynamics.get(), s.contacts.get()));
  }
  nodes_.push_front(std::move(nodes));
  if (nodes_.size() > kCachedNodes) nodes_.pop_back();
  return nodes_.front().list;
}

void RolloutSimulation::CheckInput(const RolloutInput& input) const {
  const auto check = [](const char* name, Eigen::Index values, Eigen::Index reference, Eigen::Index nodes, int size,
                        const RolloutInput& of) {
    const auto fits = [size](Eigen::Index n, bool wanted) { return n == (wanted ? size : 0); };
    if (fits(values, true) && fits(reference, Distills(of)) && fits(nodes, FollowsNodes(of))) return;
    throw std::invalid_argument(
        fmt::format("{0} has {1} values, {0}_reference {2}, {0}_nodes {3}; the scenario has {4}", name, values,
                    reference, nodes, size));
  };
  check("theta", input.theta.size(), input.theta_reference.size(), input.theta_nodes.size(), num_parameters(), input);
  check("controls", input.controls.size(), input.controls_reference.size(), input.controls_nodes.size(), num_controls(),
        input);
  if (FollowsNodes(input) && (Distills(input) || input.want_gradient)) {
    throw std::invalid_argument("time steps of other values are for the task loss without a gradient");
  }
  for (const VectorXd* values : {&input.theta, &input.theta_reference, &input.theta_nodes}) {
    if (!values->allFinite()) throw std::invalid_argument("theta is not finite");
  }
  for (const VectorXd* values : {&input.controls, &input.controls_reference, &input.controls_nodes}) {
    if (!values->allFinite()) throw std::invalid_argument("controls are not finite");
  }
}

std::string RolloutSimulation::DescribeStop(const Simulated& s) const {
  const SimulationCertificate& certificate = s.trajectory->certificate;
  const int pair = certificate.hardest_contact;
  // Without figures up to the comma: reports count such reasons.
  return fmt::format("it was given up as {}{}, at {:.4g} s",
                     certificate.out_of_effort ? "ever shorter steps led nowhere" : "no step converged",
                     pair < 0 ? "" : fmt::format(" while {} pressed hardest", NamePair(s.scene, s.model, pair)),
                     s.trajectory->time(s.trajectory->size() - 1));
}

std::vector<std::string> RolloutSimulation::FindDistrust(const Simulated& s) const {
  const SimulationCertificate& certificate = s.trajectory->certificate;
  std::vector<std::string> out;
  if (certificate.penetration > s.scene.trust.penetration) {
    const int pair = certificate.deepest_contact;
    out.push_back(fmt::format("{} press into one another, {:.0f}% of what the thinner one has",
                              NamePair(s.scene, s.model, pair), 100.0 * certificate.penetration));
  }
  if (const int pair = certificate.passed_contact; pair >= 0) {
    out.push_back(fmt::format("{} pass through one another", NamePair(s.scene, s.model, pair)));
  }
  return out;
}

double RolloutSimulation::Evaluate(const Simulated& s, const Reference* reference, SignalCotangents* bar) const {
  bar->points.assign(s.signals->points().size(), Eigen::Vector3d::Zero());
  bar->measures.assign(s.signals->measures().size(), 0.0);
  const std::vector<Term>& terms = reference != nullptr ? s.scene.loss.distillation : s.scene.loss.task;
  const double loss = EvaluateTerms(terms, s.watched(),
                                    reference != nullptr ? reference->terms : std::vector<std::vector<double>>(), bar);
  std::stable_sort(bar->states.begin(), bar->states.end(),
                   [](const StateCotangent& a, const StateCotangent& b) { return a.state < b.state; });
  return loss;
}

void RolloutSimulation::Judge(const Simulated& s, const Reference* reference, SignalCotangents* bar,
                              RolloutOutput* out) const {
  out->certificate = s.trajectory->certificate;
  out->steps = out->certificate.steps;
  if (reference != nullptr && reference->terms.size() != s.scene.loss.distillation.size()) {
    out->certificate.converged = false;
  }
  if (!out->certificate.converged) {
    out->certificate.finite = false;
    out->loss = kUnknown;
    out->distrust = {s.trajectory->certificate.converged ? "the reference that it was to be distilled from was given up"
                                                         : DescribeStop(s)};
    return;
  }
  out->loss = Evaluate(s, reference, bar);
  out->distrust = FindDistrust(s);
  out->success = s.scene.success && out->distrust.empty() && Holds(*s.scene.success, s.watched());
  out->certificate.finite = std::isfinite(out->loss);
}

RolloutSimulation::Gradient RolloutSimulation::CalcGradient(const VectorXd& controls, const Simulated& s,
                                                            const SignalCotangents& bar, TimeNodes nodes) const {
  Gradient out;
  out.design = VectorXd::Zero(num_parameters());
  const Eigen::Index open_loop = CountControls(s.scene);
  // Of the open-loop commands, then of the policy's.
  Eigen::MatrixXd bar_commands = Eigen::MatrixXd::Zero(s.commands.rows() + (s.policy ? s.policy->commands().rows() : 0),
                                                       s.policy ? s.policy->commands().cols() : s.commands.cols());
  for (const CommandCotangent& c : bar.commands) bar_commands(c.row, c.interval) += c.bar;
  // What a loss sees of a policy's commands goes back into the states too.
  if (!bar.states.empty() || s.policy != nullptr) {
    if (s.policy) s.policy->BeginSweep(bar_commands.bottomRows(s.policy->commands().rows()));
    TrajectoryGradient gradient =
        SweepAdjoint(*s.trajectory, bar.states, s.dynamics.get(), s.contacts.get(), s.policy.get(), nodes);
    for (const VertexCotangent& c : bar.vertices) {
      gradient.vertices[static_cast<std::size_t>(c.contact)][static_cast<std::size_t>(c.shape)].col(c.vertex) += c.bar;
    }
    out.touchdowns = gradient.touchdowns;
    out.loss_rounding = gradient.loss_rounding;
    out.loss_error = gradient.loss_error;
    out.finite = out.finite && gradient.finite;
    out.solvable = gradient.solvable;
    if (design()) {
      std::vector<PointCotangent> points;
      for (std::size_t i = 0; i < s.signals->points().size(); ++i) {
        const SignalPoint& point = s.signals->points()[i];
        points.push_back({point.body, point.p_B, bar.points[i]});
        if (s.policy) points.back().bar_B += s.policy->bar_points()[i];
      }
      out.design = design()->PullBack(s.scene, *s.shapes, s.model, gradient, points);
    }
    if (s.scene.controls) {
      bar_commands.topRows(s.commands.rows()) += PullBackControlSequence(s.scene, s.model, gradient.controls);
    }
  }
  for (std::size_t i = 0; i < bar.measures.size(); ++i) {
    const SignalMeasure& of = s.signals->measures()[i];
    if (bar.measures[i] != 0.0) out.design += bar.measures[i] * design()->Find(of.body)->PullBack(of.measure.gradient);
  }
  out.controls.resize(num_controls());
  if (s.scene.controls) {
    out.controls.head(open_loop) =
        PullBackCommands(*s.scene.controls, controls.head(open_loop), bar_commands.topRows(s.commands.rows()));
  }
  if (s.policy) out.controls.tail(CountWeights(s.scene)) = s.policy->bar_weights();
  out.finite = out.finite && out.design.allFinite() && out.controls.allFinite();
  return out;
}

VectorXd RolloutSimulation::Normalize(const Scene& scene, const Gradient& gradient) const {
  VectorXd g(num_parameters() + num_controls());
  if (design()) g.head(num_parameters()) = gradient.design.cwiseProduct(design()->ranges());
  const Eigen::Index open_loop = CountControls(scene);
  if (scene.controls) {
    g.segment(num_parameters(), open_loop) =
        (scene.controls->upper - scene.controls->lower) * gradient.controls.head(open_loop);
  }
  if (scene.policy) {
    const Eigen::Index weights = CountWeights(scene);
    g.tail(weights) = (scene.policy->upper - scene.policy->lower) * gradient.controls.tail(weights);
  }
  return g;
}

void RolloutSimulation::AddGradient(const RolloutInput& input, const Simulated& s, const Reference* reference,
                                    const SignalCotangents& bar, RolloutOutput* out) {
  const GradientDemand& demand = s.scene.gradient;
  const bool chosen_steps = s.scene.rollout.integrator == Integrator::kTrBdf2;
  VectorXd frozen;
  const bool compares_frozen = chosen_steps && out->certificate.contact_onsets > 0;
  if (compares_frozen) frozen = Normalize(s.scene, CalcGradient(input.controls, s, bar, TimeNodes::kFrozen));
  const Gradient gradient = CalcGradient(input.controls, s, bar, TimeNodes::kFollowing);
  out->gradient = gradient.design;
  out->control_gradient = gradient.controls;
  out->loss_rounding = gradient.loss_rounding;
  out->loss_error = std::abs(gradient.loss_error) + gradient.loss_rounding;
  out->certificate.finite = out->certificate.finite && gradient.finite;
  out->certificate.converged = out->certificate.converged && gradient.solvable;
  const VectorXd g = Normalize(s.scene, gradient);
  const double size = g.norm();
  // A gradient of zero is one that nothing contests: what the tool never touched.
  if (size == 0.0 && (frozen.size() == 0 || frozen.isZero(0.0))) return;
  const auto doubt = [out](const char* reason) {
    out->gradient_reliable = false;
    out->doubts.emplace_back(reason);
  };
  if (out->certificate.subdivided_steps > 0) doubt("cut steps");
  const double largest = g.lpNorm<Eigen::Infinity>();
  // Where steps are chosen, the loss is known to no more than loss_error, and rounding is lost in that.
  if (!chosen_steps && out->loss_rounding > demand.step * demand.tolerance * largest) doubt("rounding");
  if (chosen_steps && !(out->loss_error <= demand.loss_error * largest)) doubt("time steps");
  if (compares_frozen) out->touchdown_share = (g - frozen).norm() / size;
  if (gradient.touchdowns >= kLeastCascade && out->touchdown_share > demand.touchdown) doubt("touchdowns");
  if (demand.compare != GradientComparison::kFiner || !chosen_steps) return;
  const Simulated finer = Simulate(input.theta, input.controls, input.variation, {.finer = true});
  SignalCotangents bar_finer;
  out->gradient_change = std::numeric_limits<double>::infinity();
  if (finer.trajectory->certificate.converged) {
    Evaluate(finer, reference, &bar_finer);
    const Gradient other = CalcGradient(input.controls, finer, bar_finer, TimeNodes::kFollowing);
    out->gradient_change = (g - Normalize(finer.scene, other)).norm() / size;
  }
  if (!(out->gradient_change <= demand.change)) doubt("tolerance");
}

void RolloutSimulation::RequireSound(const VectorXd& theta) {
  const std::string fault = source_.FindFault(theta);
  if (!fault.empty()) throw std::invalid_argument(fault);
}

RolloutOutput RolloutSimulation::Run(const RolloutInput& input, const std::function<void(int, int)>& progress) {
  CheckInput(input);
  const double start = clock ? clock() : 0.0;
  const bool distill = Distills(input);
  const bool follows = FollowsNodes(input) && scene().rollout.integrator == Integrator::kTrBdf2;
  std::string failure = source_.FindFault(input.theta);
  if (failure.empty() && distill) failure = source_.FindFault(input.theta_reference);
  if (failure.empty() && follows) failure = source_.FindFault(input.theta_nodes);
  if (!failure.empty()) {
    RolloutOutput out;
    out.certificate.converged = out.certificate.finite = false;
    out.failure = std::move(failure);
    out.loss = kUnknown;
    SetGradientUnknown(input, &out);
    forward_s = clock ? clock() - start : 0.0;
    gradient_s = 0.0;
    return out;
  }
  const Reference* reference = distill ? &GetReference(input) : nullptr;
  const int total = static_cast<int>(std::llround(scene().rollout.horizon / scene().rollout.step));
  Manner manner;
  if (progress) manner.progress = [&](int done) { progress(done, total); };
  if (follows) manner.nodes = GetNodes(input);
  const Simulated s = Simulate(input.theta, input.controls, input.variation, manner);
  RolloutOutput out;
  SignalCotangents bar;
  Judge(s, reference, &bar, &out);
  if (follows && manner.nodes == nullptr) out.certificate.converged = false;
  if (!out.certificate.converged) {
    SetGradientUnknown(input, &out);
    forward_s = clock ? clock() - start : 0.0;
    gradient_s = 0.0;
    return out;
  }
  const double middle = clock ? clock() : 0.0;
  forward_s = middle - start;
  if (input.want_gradient) AddGradient(input, s, reference, bar, &out);
  gradient_s = clock ? clock() - middle : 0.0;
  return out;
}

RolloutModel::RolloutModel(const std::map<std::string, std::string>& files)
    : simulation_(std::make_unique<RolloutSimulation>(files)) {}

RolloutModel::~RolloutModel() = default;
RolloutModel::RolloutModel(RolloutModel&& other) noexcept = default;
RolloutModel& RolloutModel::operator=(RolloutModel&& other) noexcept = default;

const Scene& RolloutModel::scene() const { return simulation_->scene(); }

int RolloutModel::num_parameters() const { return simulation_->num_parameters(); }

int RolloutModel::num_controls() const { return simulation_->num_controls(); }

const std::optional<SceneDesign>& RolloutModel::design() const { return simulation_->source().design(); }

VectorXd RolloutModel::initial_theta() const { return design() ? design()->initial_theta() : VectorXd(); }

const SceneSource& RolloutModel::source() const { return simulation_->source(); }

RolloutOutput RolloutModel::Run(const RolloutInput& input, const std::function<void(int, int)>& progress) {
  simulation_->clock = clock;
  RolloutOutput out = simulation_->Run(input, progress);
  forward_s = simulation_->forward_s;
  gradient_s = simulation_->gradient_s;
  return out;
}

RecordedRollout RolloutModel::Record(const RolloutInput& input, double period) {
  return simulation_->Record(input, period);
}

}  // namespace knap
