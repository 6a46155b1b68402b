#include "coordinator/gradcheck/gradient_check_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

constexpr std::size_t kWorstShown = 5;

const char* GetName(GradientVerdict verdict) {
  switch (verdict) {
    case GradientVerdict::kAgreed:
      return "agreed";
    case GradientVerdict::kFlagged:
      return "flagged";
    case GradientVerdict::kDisagreed:
      return "disagreed";
  }
  return "";
}

nlohmann::ordered_json MakeRolloutJson(const CheckedRollout& rollout, const ParameterSpec& parameters) {
  const RolloutCertificate& certificate = rollout.outcome.certificate;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < rollout.parameters.size(); ++i) {
    const ParameterCheck& row = rollout.parameters[i];
    if (row.fixed) continue;
    rows.push_back({{"name", parameters.names[i]},
                    {"analytic", MakeJsonNumber(row.analytic)},
                    {"difference", MakeJsonNumber(row.difference)},
                    {"rel_error", MakeJsonNumber(row.relative_error)},
                    {"step", row.step},
                    {"plateau_steps", row.plateau_steps}});
  }
  return {{"draw", rollout.draw},
          {"theta", rollout.theta},
          {"variation", rollout.variation},
          {"loss", MakeJsonNumber(rollout.outcome.loss)},
          {"verdict", GetName(rollout.verdict)},
          {"rel_error", MakeJsonNumber(rollout.relative_error)},
          {"certificate",
           {{"finite", certificate.finite},
            {"converged", certificate.converged},
            {"gradient_reliable", certificate.gradient_reliable},
            {"worst_residual", MakeJsonNumber(certificate.worst_residual)},
            {"subdivided_steps", certificate.subdivided_steps},
            {"contact_onsets", certificate.contact_onsets}}},
          {"parameters", std::move(rows)}};
}

// Disagreements first, then flagged ones, then by error.
std::vector<const CheckedRollout*> SelectWorst(const GradientCheckReport& report) {
  std::vector<const CheckedRollout*> worst;
  for (const CheckedRollout& rollout : report.rollouts) worst.push_back(&rollout);
  std::stable_sort(worst.begin(), worst.end(), [](const CheckedRollout* a, const CheckedRollout* b) {
    return a->verdict != b->verdict ? a->verdict > b->verdict : a->relative_error > b->relative_error;
  });
  // Whatever does not agree is shown, however much.
  const auto others = static_cast<std::size_t>(report.flagged + report.disagreed);
  worst.resize(std::min(worst.size(), std::max(kWorstShown, others)));
  return worst;
}

// The draw, its verdict and what its certificate warns of.
std::string FormatWarnings(const CheckedRollout& rollout) {
  const RolloutCertificate& certificate = rollout.outcome.certificate;
  std::string text = fmt::format("draw {}: {}", rollout.draw, GetName(rollout.verdict));
  if (!certificate.finite) text += ", not finite";
  if (!certificate.converged) text += ", not converged";
  if (!certificate.gradient_reliable) text += ", gradient not reliable";
  return text;
}

void AppendRollout(const CheckedRollout& rollout, const Problem& problem, const std::string& rollout_command,
                   std::string* text) {
  const auto out = std::back_inserter(*text);
  fmt::format_to(out, "\n{}", FormatWarnings(rollout));
  const auto worst = std::max_element(
      rollout.parameters.begin(), rollout.parameters.end(),
      [](const ParameterCheck& a, const ParameterCheck& b) { return a.relative_error < b.relative_error; });
  if (worst != rollout.parameters.end()) {
    fmt::format_to(out, "; worst {}: gradient {:.9g}, difference {:.9g} at step {:.1e}, relative error {:.1e}",
                   problem.parameters.names[static_cast<std::size_t>(worst - rollout.parameters.begin())],
                   worst->analytic, worst->difference, worst->step, worst->relative_error);
  }
  fmt::format_to(out, "\n  {} --theta={} --variation-values={}\n", rollout_command, fmt::join(rollout.theta, ","),
                 fmt::join(rollout.variation, ","));
}

}  // namespace

nlohmann::ordered_json MakeGradientCheckJson(const GradientCheckReport& report, const Problem& problem,
                                             const GradientCheckOptions& options) {
  const std::vector<std::string> failures = ListFailures(report, options);
  nlohmann::ordered_json rollouts = nlohmann::ordered_json::array();
  for (const CheckedRollout& rollout : report.rollouts) {
    rollouts.push_back(MakeRolloutJson(rollout, problem.parameters));
  }
  return {{"passed", failures.empty()},
          {"failures", failures},
          {"checked", report.checked()},
          {"agreed", report.agreed},
          {"flagged", report.flagged},
          {"unflagged_disagreements", report.disagreed},
          {"quarantined", report.flagged},
          {"nonconverged", report.nonconverged},
          {"certificates_that_warn", report.doubted},
          {"zero_gradient", report.zero_gradient},
          {"draws", report.draws},
          {"evaluated", report.evaluated},
          {"max_rel_error", report.max_rel_error},
          {"tolerance", options.tolerance},
          {"seed", options.seed},
          {"rollouts", std::move(rollouts)}};
}

std::string FormatVerdict(const CheckedRollout& rollout) {
  const std::string text = FormatWarnings(rollout);
  return rollout.parameters.empty() ? text : text + fmt::format(", relative error {:.1e}", rollout.relative_error);
}

std::string FormatGradientCheck(const GradientCheckReport& report, const Problem& problem,
                                const GradientCheckOptions& options, const std::string& rollout_command) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "checked                  {:>8}  rollouts with a non-zero gradient, of {} draws from seed {}\n",
                 report.checked(), report.draws, options.seed);
  fmt::format_to(out, "agreed                   {:>8}  with central differences within {:g} of the largest component\n",
                 report.agreed, options.tolerance);
  fmt::format_to(
      out, "flagged                  {:>8}  do not agree, and their certificates warn, {} of them not converged\n",
      report.flagged, report.nonconverged);
  fmt::format_to(out, "unflagged disagreements  {:>8}\n", report.disagreed);
  fmt::format_to(out, "certificates that warn   {:>8}  of time steps, touchdowns, rounding, agreed or not\n",
                 report.doubted);
  fmt::format_to(out, "zero gradient            {:>8}  left out\n", report.zero_gradient);
  fmt::format_to(out, "max relative error       {:>8.1e}  of those that agreed\n", report.max_rel_error);
  fmt::format_to(out, "rollouts run             {:>8}\n", report.evaluated);
  for (const CheckedRollout* rollout : SelectWorst(report)) AppendRollout(*rollout, problem, rollout_command, &text);
  const std::vector<std::string> failures = ListFailures(report, options);
  fmt::format_to(out, "\n{}\n", failures.empty() ? "passed" : fmt::format("failed: {}", fmt::join(failures, "; ")));
  return text;
}

}  // namespace knap
