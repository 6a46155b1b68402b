#include "coordinator/cli/rollout_record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <optional>

#include "coordinator/run/loss_unit.h"
#include "coordinator/run_directory/json_text.h"

namespace knap {
namespace {

// Design parameters come first, then controls and weights.
double GetValue(const RolloutRecord& record, std::size_t i) {
  const auto k = static_cast<Eigen::Index>(i);
  const Eigen::VectorXd& design = record.input.theta;
  return k < design.size() ? design[k] : record.input.controls[k - design.size()];
}

// dloss/dtheta_i; empty when the rollout has no gradient.
std::optional<double> GetDerivative(const RolloutRecord& record, std::size_t i) {
  const Eigen::VectorXd& design = record.output.gradient;
  const Eigen::VectorXd& controls = record.output.control_gradient;
  const auto k = static_cast<Eigen::Index>(i);
  if (k < record.input.theta.size()) return k < design.size() ? std::optional(design[k]) : std::nullopt;
  const Eigen::Index c = k - record.input.theta.size();
  return c < controls.size() ? std::optional(controls[c]) : std::nullopt;
}

}  // namespace

nlohmann::ordered_json MakeRolloutJson(const RolloutRecord& record) {
  const RolloutOutput& output = record.output;
  nlohmann::ordered_json theta = nlohmann::ordered_json::object();
  nlohmann::ordered_json gradient = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < record.parameters.names.size(); ++i) {
    const std::string& name = record.parameters.names[i];
    const std::optional<double> derivative = GetDerivative(record, i);
    theta[name] = GetValue(record, i);
    gradient[name] = derivative ? MakeJsonNumber(*derivative) : nullptr;
  }
  nlohmann::ordered_json variation = nlohmann::ordered_json::object();
  const std::vector<std::string> keys = ListVariedKeys(record.scene.variation);
  for (std::size_t i = 0; i < record.input.variation.size(); ++i) {
    variation[keys[i]] = record.input.variation[i];
  }
  return {{"scenario", record.scene.name},
          {"theta", std::move(theta)},
          {"variation", std::move(variation)},
          {"loss", MakeJsonNumber(output.loss)},
          {"success", record.scene.success ? nlohmann::ordered_json(output.success) : nullptr},
          {"gradient", std::move(gradient)},
          {"steps", output.steps},
          {"forward_s", record.forward_s},
          {"gradient_s", record.gradient_s},
          {"certificate",
           {{"finite", output.certificate.finite},
            {"converged", output.certificate.converged},
            {"trusted", output.distrust.empty()},
            {"distrust", output.distrust},
            {"penetration", MakeJsonNumber(output.certificate.penetration)},
            {"largest_force", MakeJsonNumber(output.certificate.largest_force)},
            {"gradient_reliable", output.gradient_reliable},
            {"reasons", output.doubts},
            {"loss_error", MakeJsonNumber(output.loss_error)},
            {"touchdown_share", MakeJsonNumber(output.touchdown_share)},
            {"gradient_change", MakeJsonNumber(output.gradient_change)},
            {"loss_rounding", MakeJsonNumber(output.loss_rounding)},
            {"worst_residual", MakeJsonNumber(output.certificate.worst_residual)},
            {"subdivided_steps", output.certificate.subdivided_steps},
            {"rejected_steps", output.certificate.rejected_steps},
            {"newton_iterations", output.certificate.newton_iterations},
            {"contact_onsets", output.certificate.contact_onsets},
            {"failure", output.failure.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(output.failure)}}}};
}

std::string FormatRollout(const RolloutRecord& record) {
  const RolloutOutput& output = record.output;
  const auto yes = [](bool value) { return value ? "yes" : "no"; };
  std::string text;
  const auto out = std::back_inserter(text);
  const bool distils = record.input.theta_reference.size() + record.input.controls_reference.size() > 0;
  fmt::format_to(out, "loss       {:.9g}{}\n", output.loss,
                 distils ? "  (distillation)" : FormatLossUnit(record.scene));
  fmt::format_to(out, "success    {}\n", record.scene.success ? yes(output.success) : "no success test");
  fmt::format_to(out, "steps      {}\n", output.steps);
  fmt::format_to(out, "time       {:.1f} ms forward, {:.1f} ms gradient\n", 1e3 * record.forward_s,
                 1e3 * record.gradient_s);
  fmt::format_to(out,
                 "certified  finite {}, converged {}; worst residual {:.1e}, {} steps subdivided, {} contact onsets\n",
                 yes(output.certificate.finite), yes(output.certificate.converged), output.certificate.worst_residual,
                 output.certificate.subdivided_steps, output.certificate.contact_onsets);
  fmt::format_to(out, "           deepest contact {:.3g}% of the thinner body, largest force {:.3g} N\n",
                 100.0 * output.certificate.penetration, output.certificate.largest_force);
  for (const std::string& reason : output.distrust) {
    fmt::format_to(out, "           not to be trusted, and no success: {}\n", reason);
  }
  if (std::isfinite(output.loss_error)) {
    fmt::format_to(out, "           time steps, Newton and rounding move the loss by about {:.1e}\n",
                   output.loss_error);
  }
  if (output.gradient.size() + output.control_gradient.size() > 0) {
    fmt::format_to(out, "           gradient reliable {}{}{}\n", yes(output.gradient_reliable),
                   output.doubts.empty() ? "" : ": ", fmt::join(output.doubts, ", "));
  }
  if (!output.failure.empty()) fmt::format_to(out, "failed     {}\n", output.failure);
  if (!record.input.variation.empty()) fmt::format_to(out, "\n{:<36} {:>16}\n", "varied key", "value [SI]");
  const std::vector<std::string> keys = ListVariedKeys(record.scene.variation);
  for (std::size_t i = 0; i < record.input.variation.size(); ++i) {
    fmt::format_to(out, "{:<36} {:>16.9g}\n", keys[i], record.input.variation[i]);
  }
  if (!record.parameters.names.empty())
    fmt::format_to(out, "\n{:<36} {:>16} {:>16}\n", "parameter", "theta [SI]", "dloss/dtheta");
  for (std::size_t i = 0; i < record.parameters.names.size(); ++i) {
    const std::optional<double> derivative = GetDerivative(record, i);
    fmt::format_to(out, "{:<36} {:>16.9g} {:>16}\n", record.parameters.names[i], GetValue(record, i),
                   derivative ? fmt::format("{:.9g}", *derivative) : "none");
  }
  return text;
}

}  // namespace knap
