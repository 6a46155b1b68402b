#include "sim/rollout/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "sim/math/check.h"
#include "sim/rollout/rollout_simulation.h"
#include "sim/scenarios/signal_fields.h"

namespace knap {

using Eigen::Vector3d;

namespace {

// What is seen of one body of the tree.
struct Seen {
  int index = 0;
  Recording::Body body;
};

bool Moves(const Tree& tree, int body) {
  for (int i = body; i >= 0; i = tree.bodies()[i].parent) {
    if (tree.bodies()[i].joint != JointType::kFixed) return true;
  }
  return false;
}

std::vector<Seen> ListBodies(const Scene& scene, const SceneModel& model) {
  std::vector<Seen> seen;
  const auto add = [&](int index, std::string name) {
    seen.push_back({index, {std::move(name), Moves(model.tree, index), {}}});
  };
  for (const Body& body : scene.bodies) add(model.body_index.at(body.name), body.name);
  for (const Rope& rope : scene.ropes) {
    const std::vector<int>& links = model.links.at(rope.name);
    for (std::size_t i = 0; i < links.size(); ++i) add(links[i], fmt::format("{} link {}", rope.name, i));
  }
  return seen;
}

// Looks at a simulation while it goes.
class Recorder {
 public:
  Recorder(double period, Recording* out) : period_(period), out_(out) {}

  void Look(double time, const Scene& scene, const SceneModel& model, const Dynamics& dynamics,
            const ContactModel& contacts) {
    if (out_->time.empty()) Begin(scene, model);
    if (time < next_) return;
    // Multiples, not sums, so that the grid does not drift.
    if (period_ > 0.0) next_ = period_ * (std::floor(time / period_ * (1.0 + 1e-12)) + 1.0);
    out_->time.push_back(time);
    for (Seen& s : seen_) s.body.X_WB.push_back(dynamics.kinematics()[s.index].X_WB);
    for (Pair& pair : pairs_) LookAt(contacts.reports(), &pair);
  }

  void Finish() {
    for (Seen& s : seen_) out_->bodies.push_back(std::move(s.body));
    for (Pair& pair : pairs_) {
      if (pair.touched) out_->contacts.push_back(std::move(pair.contact));
    }
  }

 private:
  // Two bodies and all pairs of their shapes, which follow one another in the model.
  struct Pair {
    std::size_t begin = 0, end = 0;
    std::array<int, 2> bodies{};
    Recording::Contact contact;
    bool touched = false;
  };

  // Places are weighted with the force that each bears.
  static void LookAt(const std::vector<ContactReport>& reports, Pair* pair) {
    Vector3d f_W = Vector3d::Zero();
    Vector3d p_W = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    double depth = 0.0;
    double bearing = 0.0;
    bool active = false;
    for (std::size_t i = pair->begin; i < pair->end; ++i) {
      const ContactReport& report = reports[i];
      if (!report.active) continue;
      const double weight = report.f_W.norm();
      bearing += weight;
      if (!active) p_W = report.p_W;
      if (active && bearing > 0.0) p_W += weight / bearing * (report.p_W - p_W);
      f_W += report.f_W;
      depth = std::max(depth, report.depth);
      active = true;
    }
    pair->contact.f_W.push_back(f_W);
    pair->contact.p_W.push_back(p_W);
    pair->contact.depth.push_back(depth);
    pair->touched = pair->touched || active;
  }

  void Begin(const Scene& scene, const SceneModel& model) {
    out_->gravity_W = model.tree.gravity;
    seen_ = ListBodies(scene, model);
    const auto name_of = [&](int index) {
      const auto found = std::find_if(seen_.begin(), seen_.end(), [&](const Seen& s) { return s.index == index; });
      KNAP_CHECK(found != seen_.end(), "a contact of body {}, which has no name", index);
      return found->body.name;
    };
    for (std::size_t i = 0; i < model.contacts.size(); ++i) {
      const std::array<int, 2>& bodies = model.contacts[i].bodies;
      if (pairs_.empty() || pairs_.back().bodies != bodies) {
        pairs_.push_back({i, i, bodies, {{name_of(bodies[0]), name_of(bodies[1])}, {}, {}, {}}});
      }
      pairs_.back().end = i + 1;
    }
  }

  double period_;
  double next_ = 0.0;
  Recording* out_;
  std::vector<Seen> seen_;
  std::vector<Pair> pairs_;
};

// Of the recorded times, which are those of states of the trajectory.
std::vector<int> FindStates(const Recording& recording, const Trajectory& trajectory) {
  std::vector<int> states;
  int k = 0;
  for (const double time : recording.time) {
    while (trajectory.time(k) < time) ++k;
    states.push_back(k);
  }
  return states;
}

void AddSignals(Scene scene, const std::vector<int>& states, const SignalSet& signals, RolloutTrack* track,
                Recording* out) {
  const SignalDimensions dimensions(scene);
  for (const Signal& signal : scene.signals) {
    out->signals.push_back({signal.name, UnitName(*dimensions.Find(signal.name)), {}});
  }
  for (const int k : states) {
    for (Recording::Signal& signal : out->signals) signal.values.push_back(track->Calc(*signals.Find(signal.name), k));
  }
}

void AddJoints(const Scene& scene, const SceneModel& model, const std::vector<int>& states,
               const Trajectory& trajectory, Recording* out) {
  for (const Body& body : scene.bodies) {
    const TreeBody& moved = model.tree.bodies()[model.body_index.at(body.name)];
    const bool turns = std::holds_alternative<RevoluteJoint>(body.joint.kind);
    if (!turns && !std::holds_alternative<PrismaticJoint>(body.joint.kind)) continue;
    Recording::Joint& joint = out->joints.emplace_back(Recording::Joint{body.name, turns ? "rad" : "m", {}});
    for (const int state : states) joint.q.push_back(trajectory.q(state)(moved.q_start));
  }
}

}  // namespace

const Recording::Body& Recording::Find(const std::string& body) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == body; });
  KNAP_CHECK(found != bodies.end(), "no body '{}' was recorded", body);
  return *found;
}

RecordedRollout RolloutSimulation::Record(const RolloutInput& input, double period) {
  CheckInput(input);
  RequireSound(input.theta);
  const bool distill = input.theta_reference.size() > 0 || input.controls_reference.size() > 0;
  if (distill) RequireSound(input.theta_reference);
  const Reference* reference = distill ? &GetReference(input) : nullptr;
  RecordedRollout out;
  Recorder recorder(period, &out.recording);
  Manner manner;
  manner.observe = [&](const Simulated& s, double time) {
    recorder.Look(time, s.scene, s.model, *s.dynamics, *s.contacts);
  };
  const Simulated s = Simulate(input.theta, input.controls, input.variation, manner);
  recorder.Finish();
  const std::vector<int> states = FindStates(out.recording, *s.trajectory);
  AddJoints(s.scene, s.model, states, *s.trajectory, &out.recording);
  // What stopped early may lack the states that signals look back at.
  if (s.trajectory->certificate.converged) AddSignals(s.scene, states, *s.signals, s.track.get(), &out.recording);
  SignalCotangents unused;
  Judge(s, reference, &unused, &out.output);
  return out;
}

}  // namespace knap
