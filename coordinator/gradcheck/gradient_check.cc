#include "coordinator/gradcheck/gradient_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>

#include "coordinator/gradcheck/difference_ladder.h"
#include "coordinator/learning/batch_objective.h"

namespace knap {
namespace {

constexpr std::size_t kLeastRound = 256;  // rollouts asked for in one call while there are as many

bool HasNumbers(const RolloutOutcome& outcome) {
  return std::isfinite(outcome.loss) &&
         std::all_of(outcome.gradient.begin(), outcome.gradient.end(), [](double g) { return std::isfinite(g); });
}

bool IsUsable(const RolloutCertificate& certificate) { return certificate.finite && certificate.converged; }

// One rollout under comparison.
struct Comparison {
  std::size_t rollout = 0;  // in the report
  double scale = 0.0;       // ‖g‖∞, range-normalised
  std::vector<DifferenceLadder> ladders;
  std::vector<bool> settled;  // one a parameter
};

class GradientChecker {
 public:
  GradientChecker(const Problem& problem, const GradientCheckOptions& options, RolloutService& service,
                  const GradientCheckObserver& observer)
      : parameters_(problem.parameters),
        variations_(problem.variations),
        options_(options),
        service_(service),
        observer_(observer),
        drawn_within_(problem.parameters) {
    for (std::size_t i = 0; i < parameters_.names.size(); ++i) {
      range_.push_back(parameters_.upper[i] - parameters_.lower[i]);
      drawn_within_.lower[i] += CalcLargestStep() * range_[i];
      drawn_within_.upper[i] -= CalcLargestStep() * range_[i];
    }
  }

  GradientCheckReport Check() {
    DrawRollouts();
    Compare();
    return std::move(report_);
  }

 private:
  // What is fixed stays where learning leaves it.
  std::vector<double> DrawTheta(std::uint64_t index) const {
    std::vector<double> theta = SampleTheta(drawn_within_, options_.seed, index);
    for (std::size_t i = 0; i < theta.size(); ++i) {
      if (parameters_.IsFixed(i)) theta[i] = parameters_.initial[i];
    }
    return theta;
  }

  void DrawRollouts() {
    const auto most = static_cast<std::int64_t>(options_.rollouts) * kDrawsPerRollout;
    while (report_.checked() < options_.rollouts && report_.draws < most) {
      const std::int64_t count = std::min<std::int64_t>(options_.rollouts - report_.checked(), most - report_.draws);
      std::vector<RolloutQuery> queries;
      for (std::int64_t i = 0; i < count; ++i) {
        const auto index = static_cast<std::uint64_t>(report_.draws + i);
        queries.push_back(
            {.theta = DrawTheta(index),
             .theta_reference = {},
             .variation = SampleVariation(variations_, options_.seed, RandomStream::kTrainingVariations, index),
             .gradient = true});
      }
      std::vector<RolloutOutcome> outcomes = Ask(queries);
      for (std::size_t i = 0; i < outcomes.size(); ++i) Sort(queries[i], std::move(outcomes[i]));
    }
  }

  // ‖g‖∞ in range-normalised parameters, of those that are compared; 0 also where a number is none.
  double CalcScale(const std::vector<double>& gradient) const {
    double scale = 0.0;
    for (std::size_t i = 0; i < range_.size(); ++i) {
      if (!parameters_.IsFixed(i)) scale = std::max(scale, std::abs(gradient[i] * range_[i]));
    }
    return scale;
  }

  // The next draw: to be compared, to be flagged at once, or left out.
  void Sort(const RolloutQuery& query, RolloutOutcome outcome) {
    const std::int64_t draw = report_.draws++;
    const bool has_gradient = outcome.gradient.size() == range_.size();
    if (IsUsable(outcome.certificate)) {
      if (!has_gradient) {
        throw std::runtime_error(
            fmt::format("a rollout's gradient has {} values; expected {}", outcome.gradient.size(), range_.size()));
      }
      if (CalcScale(outcome.gradient) == 0.0) {
        ++report_.zero_gradient;
        return;
      }
    }
    CheckedRollout rollout{.draw = draw,
                           .theta = query.theta,
                           .variation = query.variation,
                           .outcome = std::move(outcome),
                           .parameters = {},
                           .relative_error = std::numeric_limits<double>::infinity()};
    if (IsUsable(rollout.outcome.certificate) && HasNumbers(rollout.outcome)) {
      Comparison comparison{.rollout = report_.rollouts.size(), .ladders = {}, .settled = {}};
      comparison.scale = CalcScale(rollout.outcome.gradient);
      comparison.ladders.resize(range_.size());
      for (std::size_t i = 0; i < range_.size(); ++i) comparison.settled.push_back(parameters_.IsFixed(i));
      rollout.parameters.resize(range_.size());
      open_.push_back(std::move(comparison));
      report_.rollouts.push_back(std::move(rollout));
    } else {
      Judge(&report_.rollouts.emplace_back(std::move(rollout)));
    }
  }

  // One difference quotient of one parameter: queries 2j and 2j+1 of a round.
  struct Quotient {
    std::size_t comparison, parameter;
    int step;
  };

  // Round by round the next steps of all parameters that are not settled, of so many rollouts that a round keeps
  // workers busy: what is settled can be told while the others still run.
  void Compare() {
    while (!open_.empty()) {
      std::vector<Quotient> quotients;
      std::vector<RolloutQuery> queries;
      for (std::size_t c = 0; c < open_.size() && queries.size() < kLeastRound; ++c) {
        for (std::size_t p = 0; p < range_.size(); ++p) {
          if (open_[c].settled[p]) continue;
          for (const int step : open_[c].ladders[p].ListNextSteps()) {
            quotients.push_back({c, p, step});
            for (const double sign : {1.0, -1.0})
              queries.push_back(MakeQuery(open_[c], p, sign * CalcLadderStep(step)));
          }
        }
      }
      const std::vector<RolloutOutcome> outcomes = Ask(queries);
      for (std::size_t j = 0; j < quotients.size(); ++j) {
        const auto& [c, p, step] = quotients[j];
        const bool usable = IsUsable(outcomes[2 * j].certificate) && IsUsable(outcomes[2 * j + 1].certificate);
        // The steps as they were rounded.
        const double width = (queries[2 * j].theta[p] - queries[2 * j + 1].theta[p]) / range_[p];
        const double difference = (outcomes[2 * j].loss - outcomes[2 * j + 1].loss) / width;
        open_[c].ladders[p].Set(step, usable ? difference : std::numeric_limits<double>::quiet_NaN());
      }
      Settle();
    }
  }

  RolloutQuery MakeQuery(const Comparison& comparison, std::size_t parameter, double step) const {
    const CheckedRollout& rollout = report_.rollouts[comparison.rollout];
    RolloutQuery query{.theta = rollout.theta,
                       .theta_reference = {},
                       .variation = rollout.variation,
                       .gradient = false,
                       .theta_nodes = rollout.theta};
    query.theta[parameter] += step * range_[parameter];
    // A draw at the very edge may be rounded across it.
    query.theta[parameter] =
        std::clamp(query.theta[parameter], parameters_.lower[parameter], parameters_.upper[parameter]);
    return query;
  }

  void Settle() {
    std::erase_if(open_, [this](Comparison& comparison) {
      CheckedRollout& rollout = report_.rollouts[comparison.rollout];
      bool all = true;
      rollout.relative_error = 0.0;
      for (std::size_t p = 0; p < range_.size(); ++p) {
        if (parameters_.IsFixed(p)) {
          rollout.parameters[p] = {.analytic = rollout.outcome.gradient[p], .fixed = true};
          continue;
        }
        const DifferenceLadder& ladder = comparison.ladders[p];
        const double g = rollout.outcome.gradient[p] * range_[p];
        const auto window = ladder.FindBestWindow(g, options_.tolerance * comparison.scale);
        rollout.parameters[p] = {.analytic = rollout.outcome.gradient[p],
                                 .difference = window.difference / range_[p],
                                 .step = CalcLadderStep(window.middle),
                                 .relative_error = window.error / comparison.scale,
                                 .plateau_steps = window.plateau_steps};
        rollout.relative_error = std::max(rollout.relative_error, rollout.parameters[p].relative_error);
        comparison.settled[p] = window.plateau_steps > 0 || ladder.ListNextSteps().empty();
        all = all && comparison.settled[p];
      }
      if (all) Judge(&rollout);
      return all;
    });
  }

  // Of a rollout that is compared as far as it can be.
  void Judge(CheckedRollout* rollout) {
    const RolloutCertificate& certificate = rollout->outcome.certificate;
    const bool agrees = !rollout->parameters.empty() &&
                        std::all_of(rollout->parameters.begin(), rollout->parameters.end(),
                                    [](const ParameterCheck& p) { return p.fixed || p.plateau_steps > 0; });
    const bool doubted = !IsUsable(certificate) || !certificate.gradient_reliable;
    report_.doubted += doubted ? 1 : 0;
    if (agrees && IsUsable(certificate)) {
      rollout->verdict = GradientVerdict::kAgreed;
      ++report_.agreed;
      report_.max_rel_error = std::max(report_.max_rel_error, rollout->relative_error);
    } else if (doubted) {
      rollout->verdict = GradientVerdict::kFlagged;
      ++report_.flagged;
      report_.nonconverged += IsUsable(certificate) ? 0 : 1;
    } else {
      rollout->verdict = GradientVerdict::kDisagreed;
      ++report_.disagreed;
    }
    if (observer_.on_verdict) observer_.on_verdict(*rollout);
  }

  // A round in one call.
  std::vector<RolloutOutcome> Ask(std::span<const RolloutQuery> queries) {
    report_.evaluated += static_cast<std::int64_t>(queries.size());
    if (observer_.on_round) {
      observer_.on_round({report_.checked(), report_.checked() - static_cast<int>(open_.size()), report_.evaluated});
    }
    return EvaluateAll(service_, queries);
  }

  const ParameterSpec& parameters_;
  const VariationSpec& variations_;
  const GradientCheckOptions& options_;
  RolloutService& service_;
  const GradientCheckObserver& observer_;
  ParameterSpec drawn_within_;  // bounds that leave room for the largest step
  std::vector<double> range_;
  std::vector<Comparison> open_;
  GradientCheckReport report_;
};

}  // namespace

GradientCheckReport CheckGradients(const Problem& problem, const GradientCheckOptions& options, RolloutService& service,
                                   const GradientCheckObserver& observer) {
  CheckProblem(problem);
  if (options.rollouts < 1) {
    throw std::invalid_argument(fmt::format("rollouts: {}; expected 1 or more", options.rollouts));
  }
  if (!(options.tolerance > 0.0)) {
    throw std::invalid_argument(fmt::format("tolerance: {}; expected more than 0", options.tolerance));
  }
  if (!(options.flagged >= 0.0 && options.flagged <= 1.0)) {
    throw std::invalid_argument(fmt::format("flagged: {}; expected a share from 0 to 1", options.flagged));
  }
  return GradientChecker(problem, options, service, observer).Check();
}

std::int64_t CalcLeastRollouts(const Problem& problem, const GradientCheckOptions& options) {
  std::int64_t d = 0;
  for (std::size_t i = 0; i < problem.parameters.names.size(); ++i) d += problem.parameters.IsFixed(i) ? 0 : 1;
  return options.rollouts * (1 + 2 * kWindow * d);
}

std::vector<std::string> ListFailures(const GradientCheckReport& report, const GradientCheckOptions& options) {
  std::vector<std::string> failures;
  const int checked = report.checked();
  if (checked < options.rollouts) {
    failures.push_back(fmt::format("only {} of {} rollouts with a non-zero gradient in {} draws", checked,
                                   options.rollouts, report.draws));
  }
  if (report.disagreed > 0) {
    failures.push_back(
        fmt::format("{} of {} rollouts disagree, and their certificates say nothing", report.disagreed, checked));
  }
  const double allowed = options.flagged * checked + 1e-9;  // what a share like 0.05 is short of in binary
  if (report.flagged > allowed) {
    failures.push_back(fmt::format("{} of {} rollouts are flagged; at most {:.3g}% may be", report.flagged, checked,
                                   100.0 * options.flagged));
  }
  if (checked - report.agreed > allowed) {
    failures.push_back(fmt::format("{} of {} rollouts agree; at least {:.3g}% must", report.agreed, checked,
                                   100.0 * (1.0 - options.flagged)));
  }
  return failures;
}

}  // namespace knap
