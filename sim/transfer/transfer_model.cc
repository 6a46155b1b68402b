#include "sim/transfer/transfer_model.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/rollout/conditions.h"
#include "sim/rollout/loss_terms.h"
#include "sim/transfer/bullet_world.h"
#include "sim/transfer/check_transfer.h"

namespace knap {

using Eigen::VectorXd;

namespace {

constexpr std::size_t kCachedPieces = 4;

bool IsFinite(const BodyHistory::State& state) {
  for (std::size_t i = 0; i < state.X_WB.size(); ++i) {
    if (!state.X_WB[i].R.allFinite() || !state.X_WB[i].p.allFinite() || !state.V[i].allFinite()) return false;
  }
  return true;
}

}  // namespace

TransferModel::TransferModel(const std::map<std::string, std::string>& files) : source_(files) {
  const std::vector<std::string> faults = FindTransferFaults(scene());
  if (!faults.empty()) throw std::runtime_error(fmt::format("{}", fmt::join(faults, "; ")));
  fixed_pieces_ = MakeFixedPieces(scene(), files);
}

const MeshPieces& TransferModel::FindPieces(const VectorXd& theta) {
  for (auto it = pieces_.begin(); it != pieces_.end(); ++it) {
    if (it->first != theta) continue;
    pieces_.splice(pieces_.begin(), pieces_, it);
    return pieces_.front().second;
  }
  MeshPieces pieces = MakeDesignedPieces(scene(), *source_.GetShapes(theta));
  pieces.insert(fixed_pieces_.begin(), fixed_pieces_.end());
  pieces_.emplace_front(theta, std::move(pieces));
  if (pieces_.size() > kCachedPieces) pieces_.pop_back();
  return pieces_.front().second;
}

TransferOutput TransferModel::Run(const VectorXd& theta, const std::vector<double>& variation,
                                  const std::function<void(int, int)>& progress) {
  if (theta.size() != source_.num_parameters()) {
    throw std::invalid_argument(
        fmt::format("theta has {} values; the scenario has {}", theta.size(), source_.num_parameters()));
  }
  if (!theta.allFinite()) throw std::invalid_argument("theta is not finite");
  TransferOutput out;
  out.failure = source_.FindFault(theta);
  if (!out.failure.empty()) {
    out.finite = false;
    out.loss = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  built_ = source_.Build(theta, variation);
  history_ = BodyHistory{};
  const Rollout& rollout = built_.scene.rollout;
  const int samples = static_cast<int>(std::llround(rollout.horizon / rollout.step));
  const int steps_per_sample = static_cast<int>(std::ceil(rollout.step / largest_step * (1.0 - 1e-9)));
  BulletWorld world(built_, FindPieces(theta), {rollout.step / steps_per_sample, iterations});
  world.Record(0.0, &history_);
  for (int sample = 1; sample <= samples && out.finite; ++sample) {
    for (int i = 0; i < steps_per_sample; ++i) world.Step();
    world.Record(sample * rollout.step, &history_);
    out.finite = IsFinite(history_.states.back());
    if (progress) progress(sample, samples);
  }
  out.steps = static_cast<int>(history_.time.size() - 1) * steps_per_sample;
  out.penetration = world.penetration();
  out.largest_force = world.largest_force();
  out.contact_onsets = world.contact_onsets();
  if (!out.finite) {
    out.loss = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  if (out.penetration > built_.scene.trust.penetration) {
    const Contact& contact = built_.scene.contacts[static_cast<std::size_t>(world.deepest_contact())];
    out.distrust.push_back(fmt::format("{} and {} press into one another, {:.0f}% of what the thinner one has",
                                       contact.bodies[0], contact.bodies[1], 100.0 * out.penetration));
  }
  BodyTrack track(built_.model, history_, rollout.step);
  const Watched watched{*built_.signals, track, rollout};
  out.loss = EvaluateTerms(built_.scene.loss.task, watched, {}, nullptr);
  out.success = built_.scene.success && out.distrust.empty() && Holds(*built_.scene.success, watched);
  out.finite = std::isfinite(out.loss);
  return out;
}

}  // namespace knap
