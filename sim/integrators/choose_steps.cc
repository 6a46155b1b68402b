#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/integrators/simulate.h"
#include "sim/math/check.h"

namespace knap {

namespace {

// Of a time grid in doubles, far less than any step [s].
constexpr double kSameTime = GripSpring::kTimeRounding;

}  // namespace

void Simulator::ListJumps(const SimulationOptions& options, const ControlSequence& controls) {
  jumps_.clear();
  if (options.tolerance <= 0.0) return;
  jumps_.push_back(0.0);
  for (Eigen::Index i = 1; i < controls.values.cols(); ++i) {
    jumps_.push_back(static_cast<double>(i * controls.steps_per_interval) * options.step);
  }
  for (const GripSpring& grip : contacts_->grips()) {
    for (const double time : {grip.from, grip.until}) {
      if (std::isfinite(time)) jumps_.push_back(time);
    }
  }
  std::sort(jumps_.begin(), jumps_.end());
}

bool Simulator::ForcesJumpAt(double time) const {
  const auto jump = std::lower_bound(jumps_.begin(), jumps_.end(), time - kSameTime);
  return jump != jumps_.end() && *jump <= time + kSameTime;
}

bool Simulator::SolveRestart(double end, const SimulationOptions& options, Trajectory* trajectory) {
  predictor_.Clear();
  const double now = trajectory->time(trajectory->size() - 1);
  return Solve(end, StepFormula::Bdf1(end - now), options, trajectory);
}

bool Simulator::TakeChosen(int n, const SimulationOptions& options, Trajectory* trajectory) {
  const double end = (n + 1) * options.step;
  while (true) {
    const double now = trajectory->time(trajectory->size() - 1);
    if (now == end) return true;
    if (ForcesJumpAt(now)) {
      if (!SolveRestart(now + kRestartShare * options.step, options, trajectory)) return false;
      Accept(trajectory);
      continue;
    }
    const auto jump = std::upper_bound(jumps_.begin(), jumps_.end(), now);
    const bool jumps_within = jump != jumps_.end() && *jump < end - kSameTime;
    if (!ChooseStep(jumps_within ? *jump : end, options, trajectory)) return false;
  }
}

std::optional<double> Simulator::FindShift(const TimeNode& node, const Trajectory& trajectory) const {
  const std::optional<double> in =
      CalcTouchdownIn(node.approach, contacts_->contacts()[node.contact], dynamics_->kinematics());
  if (!in) return std::nullopt;
  return trajectory.time(trajectory.size() - 1) + *in - node.touchdown;
}

bool Simulator::SolveGiven(double end, const SimulationOptions& options, Trajectory* trajectory) {
  const double now = trajectory->time(trajectory->size() - 1);
  if (end <= now) return false;
  return ForcesJumpAt(now) ? SolveRestart(end, options, trajectory) : TakeTrBdf2(end, options, trajectory);
}

bool Simulator::TakeGiven(int n, const SimulationOptions& options, Trajectory* trajectory) {
  double& shift = trajectory->choice_.shift;
  const auto follow = [&](const TimeNode& node) {
    const std::optional<double> found = FindShift(node, *trajectory);
    if (found) shift = *found;
    return found.has_value();
  };
  if (n == 0 && options.nodes->start.contact >= 0 && !follow(options.nodes->start)) return false;
  for (const TimeNode& node : options.nodes->ends[n]) {
    const int size = trajectory->size();
    const auto take = [&] { return SolveGiven(node.time + (node.moves ? shift : 0.0), options, trajectory); };
    saved_predictor_ = predictor_;
    if (!take()) return false;
    if (node.contact >= 0) {
      const double before = shift;
      if (!follow(node)) return false;
      if (node.moves && shift != before) {
        // The touchdown is seen from where this node lay, and then it moves as well.
        trajectory->CutBackTo(size);
        predictor_ = saved_predictor_;
        if (!take()) return false;
      }
    }
    Accept(trajectory);
  }
  return true;
}

bool Simulator::ChooseStep(double end, const SimulationOptions& options, Trajectory* trajectory) {
  const int size = trajectory->size();
  const double now = trajectory->time(size - 1);
  const double wanted = trajectory->choice_.next;
  const double left = end - now;
  // What is left over is shared out, so that it leaves no sliver.
  double h = wanted >= left * (1.0 - 1e-9) ? left : std::min(wanted, 0.5 * left);
  saved_predictor_ = predictor_;
  bool rejected = false;
  while (true) {
    if (trajectory->certificate.newton_iterations > CalcMostIterations(options.steps)) {
      trajectory->certificate.out_of_effort = true;
      return false;
    }
    const double to = h == left ? end : now + h;
    double factor = 0.25;
    if (TakeTrBdf2(to, options, trajectory)) {
      const double speed = control_.CalcSpeed(trajectory->choice_.speed, h, trajectory->v(size + 1));
      const auto slopes = [trajectory](int k) { return StepControl::Slopes{trajectory->v(k), trajectory->vdot(k)}; };
      const double error =
          control_.CalcError(h, options.tolerance, speed, slopes(size - 1), slopes(size), slopes(size + 1));
      factor = StepControl::CalcFactor(error);
      const bool least = h <= kLeastShare * options.step;
      const bool passes = !least && error <= 1.0 && contacts_->FindPassage() >= 0;
      if (least || (error <= 1.0 && !passes)) {
        if (rejected) factor = std::min(factor, 1.0);
        double next = factor * h;
        if (h < wanted && factor >= 1.0 && !rejected) next = std::max(next, wanted);
        next = std::min({next, options.step, control_.CalcLongestStep(dynamics_->kinematics())});
        trajectory->choice_ = {next, speed};
        Accept(trajectory);
        return true;
      }
      factor = passes ? 0.25 : std::min(factor, 0.9);
    } else if (h <= kLeastShare * options.step) {
      return false;
    }
    ++trajectory->certificate.rejected_steps;
    rejected = true;
    trajectory->CutBackTo(size);
    predictor_ = saved_predictor_;
    h *= factor;
  }
}

bool Simulator::TakeTrBdf2(double end, const SimulationOptions& options, Trajectory* trajectory) {
  const double now = trajectory->time(trajectory->size() - 1);
  const double h = end - now;
  return Solve(now + StepFormula::kGamma * h, StepFormula::TrapezoidalStage(h), options, trajectory) &&
         Solve(end, StepFormula::BdfStage(h), options, trajectory);
}

}  // namespace knap
