#include "coordinator/dispatch/answer_cache.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <utility>

namespace knap {
namespace {

bool HasSameBits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// Hexadecimal, so that the last bit shows.
std::string Compare(const std::string& field, double theirs, double ours) {
  return HasSameBits(theirs, ours) ? "" : fmt::format("{} is {:a} instead of {:a}", field, theirs, ours);
}

std::string Compare(const std::string& field, std::int64_t theirs, std::int64_t ours) {
  return theirs == ours ? "" : fmt::format("{} is {} instead of {}", field, theirs, ours);
}

std::string Compare(const std::string& field, const std::string& theirs, const std::string& ours) {
  return theirs == ours ? "" : fmt::format("{} is '{}' instead of '{}'", field, theirs, ours);
}

}  // namespace

const AnswerCache::Answer* AnswerCache::Find(const ContentId& id) const {
  const auto found = answers_.find(id);
  return found == answers_.end() ? nullptr : &found->second;
}

void AnswerCache::Insert(const ContentId& id, Answer answer) {
  if (answers_.insert_or_assign(id, std::move(answer)).second) order_.push_back(id);
  if (order_.size() > capacity_) {
    answers_.erase(order_.front());
    order_.pop_front();
  }
}

RolloutOutcome MakeOutcome(const rollout_result_t& result, const std::vector<double>& gradient) {
  RolloutOutcome outcome;
  outcome.loss = result.loss;
  outcome.success = result.success != 0;
  outcome.gradient = gradient;
  outcome.certificate.finite = result.finite != 0;
  outcome.certificate.converged = result.converged != 0;
  outcome.certificate.gradient_reliable = result.gradient_reliable != 0;
  outcome.certificate.loss_error = result.loss_error;
  outcome.certificate.worst_residual = result.worst_residual;
  outcome.certificate.penetration = result.penetration;
  outcome.certificate.largest_force = result.largest_force;
  outcome.certificate.distrust = result.distrust;
  outcome.certificate.subdivided_steps = result.subdivided_steps;
  outcome.certificate.contact_onsets = result.contact_onsets;
  outcome.steps = result.steps;
  outcome.forward_s = result.forward_s;
  outcome.gradient_s = result.gradient_s;
  return outcome;
}

std::string DescribeDifference(const rollout_result_t& part, const RolloutOutcome& outcome) {
  const RolloutCertificate& certificate = outcome.certificate;
  for (const std::string& difference : {
           Compare("loss", part.loss, outcome.loss),
           Compare("success", std::int64_t{part.success}, std::int64_t{outcome.success}),
           Compare("length of the gradient", std::int64_t{part.gradient_size},
                   static_cast<std::int64_t>(outcome.gradient.size())),
           Compare("finite", std::int64_t{part.finite}, std::int64_t{certificate.finite}),
           Compare("converged", std::int64_t{part.converged}, std::int64_t{certificate.converged}),
           Compare("gradient_reliable", std::int64_t{part.gradient_reliable},
                   std::int64_t{certificate.gradient_reliable}),
           Compare("loss_error", part.loss_error, certificate.loss_error),
           Compare("worst_residual", part.worst_residual, certificate.worst_residual),
           Compare("penetration", part.penetration, certificate.penetration),
           Compare("largest_force", part.largest_force, certificate.largest_force),
           Compare("distrust", part.distrust, certificate.distrust),
           Compare("subdivided_steps", std::int64_t{part.subdivided_steps}, std::int64_t{certificate.subdivided_steps}),
           Compare("contact_onsets", std::int64_t{part.contact_onsets}, std::int64_t{certificate.contact_onsets}),
           Compare("steps", std::int64_t{part.steps}, std::int64_t{outcome.steps}),
       }) {
    if (!difference.empty()) return difference;
  }
  for (std::size_t i = 0; i < part.values.size(); ++i) {
    const std::size_t index = static_cast<std::size_t>(part.first_value) + i;
    if (index >= outcome.gradient.size()) return fmt::format("gradient has an element {}", index);
    const std::string difference = Compare(fmt::format("gradient[{}]", index), part.values[i], outcome.gradient[index]);
    if (!difference.empty()) return difference;
  }
  return "";
}

}  // namespace knap
