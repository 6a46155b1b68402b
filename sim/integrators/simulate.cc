#include "sim/integrators/simulate.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "sim/math/check.h"

namespace knap {

using Eigen::VectorXd;

Simulator::Simulator(Dynamics* dynamics, ContactModel* contacts)
    : dynamics_(dynamics),
      contacts_(contacts),
      control_(dynamics->tree(), contacts->contacts()),
      predictor_(dynamics->tree().nv()),
      saved_predictor_(dynamics->tree().nv()) {
  const Tree& tree = dynamics->tree();
  q_.setZero(tree.nq());
  for (VectorXd* x : {&v_, &xi_, &xi_trial_, &vdot_, &r_, &magnitude_, &scale_, &scale_now_, &dx_, &start_, &zero_}) {
    x->setZero(tree.nv());
  }
  joint_of_row_.resize(tree.nv());
  for (int i = 0; i < tree.size(); ++i) {
    const TreeBody& body = tree.bodies()[i];
    for (int k = 0; k < CountDof(body.joint); ++k) joint_of_row_[body.v_start + k] = body.v_start;
  }
}

Trajectory Simulator::Run(const VectorXd& q0, const VectorXd& v0, const SimulationOptions& options,
                          const ControlSequence& controls, Feedback* feedback) {
  const Tree& tree = dynamics_->tree();
  KNAP_CHECK(
      controls.values.size() == 0 || (controls.values.rows() == tree.num_controls() && controls.steps_per_interval > 0),
      "controls of {} actuators, {} steps an interval; the tree has {}", controls.values.rows(),
      controls.steps_per_interval, tree.num_controls());
  KNAP_CHECK(feedback == nullptr || controls.values.cols() * controls.steps_per_interval >= options.steps,
             "a feedback law for {} intervals of {} steps; the simulation has {}", controls.values.cols(),
             controls.steps_per_interval, options.steps);
  Trajectory trajectory(tree.nq(), tree.nv());
  trajectory.controls = controls;
  dynamics_->controls().setZero();
  trajectory.Reserve(options.steps + 1);
  bristles_next_.Clear();
  trajectory.Append(0.0, StepFormula{}, q0, v0, zero_, zero_, bristles_next_);
  trajectory.state_of_step_.push_back(0);
  dynamics_->CalcKinematics(q0, v0, zero_, 0.0);
  contacts_->BeginStep(0.0, bristles_next_.bent);
  contacts_->AddWrenches(dynamics_);
  trajectory.choice_.next = std::min(options.step, control_.CalcLongestStep(dynamics_->kinematics()));
  trajectory.choice_.speed = control_.CalcSpeed(0.0, 0.0, v0);
  was_active_.assign(contacts_->contacts().size(), false);
  trajectory.last_touched_.assign(contacts_->contacts().size(), -std::numeric_limits<double>::infinity());
  NoteContacts(0.0, &trajectory);
  contacts_->NotePoses();
  trajectory.certificate.contact_onsets = 0;  // what touches from the start has no onset
  if (observer) observer(0.0);
  trajectory.memory_ = options.memory;
  trajectory.blocks_.front().seed = trajectory.MakeSeed();
  for (int n = 0; n < options.steps; n += kStepsPerBlock) {
    if (n > 0) trajectory.BeginBlock();
    if (trajectory.OutgrowsMemory()) {
      if (!trajectory.replay_) trajectory.replay_ = MakeReplay(options);
      trajectory.DropBlocks();
    }
    if (!TakeSteps(n, std::min(n + kStepsPerBlock, options.steps), options, feedback, &trajectory)) {
      trajectory.certificate.converged = false;
      break;
    }
  }
  return trajectory;
}

bool Simulator::TakeSteps(int begin, int end, const SimulationOptions& options, Feedback* feedback,
                          Trajectory* trajectory) {
  const ControlSequence& controls = trajectory->controls;
  ListJumps(options, controls);
  // Afresh with every block, so that one simulated again comes out the same. State 0 has no acceleration yet.
  predictor_.Clear();
  const int k = trajectory->size() - 1;
  if (begin > 0) predictor_.Push(trajectory->time(k), trajectory->vdot(k));
  for (int n = begin; n < end; ++n) {
    const int states_before = trajectory->size();
    if (feedback != nullptr && n % controls.steps_per_interval == 0) {
      AskFeedback(n / controls.steps_per_interval, feedback, trajectory);
    }
    if (controls.values.size() > 0) dynamics_->controls() = controls.values.col(controls.IntervalOfStep(n));
    if (options.tolerance > 0.0) {
      const bool taken = options.nodes ? TakeGiven(n, options, trajectory) : TakeChosen(n, options, trajectory);
      if (!taken) return false;
    } else {
      // Times are multiples of the step, not sums, so that they do not drift.
      if (!TakeFixed(n * options.step, options.step, 0, options, trajectory)) return false;
      if (trajectory->size() > states_before + 1) ++trajectory->certificate.subdivided_steps;
    }
    trajectory->state_of_step_.push_back(trajectory->size() - 1);
    if (options.progress && n % 256 == 0) options.progress(n);
  }
  return true;
}

void Simulator::AskFeedback(int interval, Feedback* feedback, Trajectory* trajectory) {
  const int k = trajectory->size() - 1;
  q_ = trajectory->q(k);
  v_ = trajectory->v(k);
  dynamics_->CalcKinematics(q_, v_, zero_, trajectory->time(k));
  feedback->SetControls({interval, k, trajectory->time(k), q_, v_, dynamics_->kinematics()},
                        trajectory->controls.values.col(interval));
}

Trajectory Simulator::Repeat(const Trajectory::Seed& seed, int first_step, const SimulationOptions& options,
                             const ControlSequence& controls) {
  Trajectory block(dynamics_->tree().nq(), dynamics_->tree().nv());
  block.controls = controls;
  block.Reserve(kStepsPerBlock + 2);
  if (seed.v_before.size() > 0) block.Append(0.0, {}, seed.q, seed.v_before, zero_, zero_, {});
  block.Append(seed.time, seed.formula, seed.q, seed.v, seed.xi, seed.vdot, seed.bristles);
  block.choice_ = seed.choice;
  was_active_.assign(contacts_->contacts().size(), false);
  block.last_touched_.assign(was_active_.size(), 0.0);
  dynamics_->CalcKinematics(seed.q, seed.v, zero_, seed.time);
  contacts_->BeginStep(0.0, seed.bristles.bent);
  contacts_->AddWrenches(dynamics_);
  contacts_->NotePoses();
  TakeSteps(first_step, std::min(first_step + kStepsPerBlock, options.steps), options, nullptr, &block);
  return block;
}

Trajectory::Replay Simulator::MakeReplay(const SimulationOptions& options) const {
  // Of its own, so that nobody's kinematics change under them when an old state is looked at.
  struct World {
    Tree tree;
    Dynamics dynamics;
    ContactModel contacts;
    Simulator simulator;
    SimulationOptions options;
    World(const Tree& t, const ContactModel& c, const SimulationOptions& o)
        : tree(t), dynamics(tree), contacts(c.contacts(), c.grips()), simulator(&dynamics, &contacts), options(o) {
      options.progress = {};
    }
  };
  const auto world = std::make_shared<World>(dynamics_->tree(), *contacts_, options);
  // What a feedback law has set is among the controls: it is not asked again.
  return [world](const Trajectory::Seed& seed, int first_step, const ControlSequence& controls) {
    return world->simulator.Repeat(seed, first_step, world->options, controls);
  };
}

bool Simulator::TakeFixed(double time, double h, int depth, const SimulationOptions& options, Trajectory* trajectory) {
  const int size = trajectory->size();
  const bool second_order = options.order == 2 && depth == 0 && size > 1 && trajectory->formula(size - 1).h == h;
  saved_predictor_ = predictor_;
  if (Solve(time + h, second_order ? StepFormula::Bdf2(h) : StepFormula::Bdf1(h), options, trajectory)) {
    if (depth == kMaxSubdivisions || contacts_->FindPassage() < 0) {
      Accept(trajectory);
      return true;
    }
    trajectory->CutBackTo(size);
    predictor_ = saved_predictor_;
  }
  if (depth == kMaxSubdivisions) return false;
  const double half = 0.5 * h;
  return TakeFixed(time, half, depth + 1, options, trajectory) &&
         TakeFixed(time + half, half, depth + 1, options, trajectory);
}

void Simulator::Accept(Trajectory* trajectory) {
  const double time = trajectory->time(trajectory->size() - 1);
  SimulationCertificate& certificate = trajectory->certificate;
  ++certificate.steps;
  if (certificate.passed_contact < 0) certificate.passed_contact = contacts_->FindPassage();
  contacts_->NotePoses();
  NoteContacts(time, trajectory);
  if (observer) observer(time);
}

void Simulator::NoteContacts(double time, Trajectory* trajectory) {
  SimulationCertificate& certificate = trajectory->certificate;
  certificate.hardest_contact = -1;
  double hardest = 0.0;
  for (std::size_t i = 0; i < was_active_.size(); ++i) {
    const ContactReport& report = contacts_->reports()[i];
    const bool active = report.active;
    if (report.depth_share > certificate.penetration) {
      certificate.penetration = report.depth_share;
      certificate.deepest_contact = static_cast<int>(i);
    }
    const double force = report.f_W.norm();
    certificate.largest_force = std::max(certificate.largest_force, force);
    if (force > hardest) {
      hardest = force;
      certificate.hardest_contact = static_cast<int>(i);
    }
    if (active) trajectory->last_touched_[i] = time;
    if (active && !was_active_[i]) ++certificate.contact_onsets;
    was_active_[i] = active;
  }
}

}  // namespace knap
