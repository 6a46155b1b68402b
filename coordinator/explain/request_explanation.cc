#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "coordinator/explain/explanation.h"
#include "coordinator/explain/explanation_text.h"
#include "coordinator/explain/request_attempts.h"
#include "lcmtypes/wire/content_id.h"

namespace knap {
namespace {

constexpr std::size_t kMostParameters = 40;

// The last answer to the request, which counts; null when there is none.
const RolloutRow* FindAnswer(const RunRecord& record, const std::string& id) {
  const auto found = std::find_if(record.answers.rbegin(), record.answers.rend(),
                                  [&](const RolloutRow& answer) { return answer.id.starts_with(id); });
  return found == record.answers.rend() ? nullptr : &*found;
}

// Lengths in millimetres, as knap prints them everywhere.
std::string FormatKey(const std::string& key, const Dimension& dimension, double value) {
  if (dimension == kLength) return fmt::format("{} {:.6g} mm", key, 1e3 * value);
  const std::string unit = UnitName(dimension);
  return fmt::format("{} {:.6g}{}{}", key, value, unit.empty() ? "" : " ", unit);
}

void AddVariation(const ExplainedRun& run, const RolloutRow& answer, Explanation* text) {
  if (run.names) {
    if (const std::string number = DescribeVariationNumber(answer, *run.names); !number.empty()) {
      text->Add("variation", number);
    }
  }
  const bool is_named = run.names && run.names->varied.size() == answer.variation.size();
  for (std::size_t i = 0; i < answer.variation.size(); ++i) {
    text->Add("variation", is_named
                               ? FormatKey(run.names->varied[i].first, run.names->varied[i].second, answer.variation[i])
                               : fmt::format("{:.6g}", answer.variation[i]));
  }
  if (answer.variation.empty()) text->Add("variation", "none: the scenario varies nothing");
}

void AddTheta(const ExplainedRun& run, const std::optional<RequestOrigin>& origin, Explanation* text) {
  if (!run.names) {
    text->Add("theta", "not known without the scenario: " + run.nameless);
    return;
  }
  if (!origin) {
    text->Add("theta", "of none of the evaluations in metrics.csv: its own may not have ended");
    return;
  }
  text->Add("theta", origin->design.empty()
                         ? fmt::format("of batch {}, evaluation {} in metrics.csv", origin->batch, origin->evaluation)
                         : fmt::format("the {} design", origin->design));
  if (!origin->reference.empty()) {
    text->Add("theta", fmt::format("compared with what batch {} began with", origin->reference_batch));
  }
  const ParameterSpec& parameters = run.names->problem.parameters;
  const std::size_t shown = std::min(kMostParameters, origin->theta.size());
  for (std::size_t i = 0; i < shown; ++i) text->Add("theta", FormatParameter(parameters, i, origin->theta[i]));
  if (shown < origin->theta.size()) text->Add("theta", fmt::format("and {} more", origin->theta.size() - shown));
}

// How it ended, but for the answer.
std::string DescribeLoss(const RequestSetback& lost) {
  if (lost.why != "dropped") {
    return fmt::format("{} at {}, after {}", DescribeWhy(lost.why), FormatInstant(lost.time_s),
                       FormatSpan(lost.held_s));
  }
  return fmt::format("cancelled at {}, as {}", FormatInstant(lost.time_s),
                     lost.worker.empty() ? "the run was broken off" : DescribeWhy(lost.why));
}

std::string DescribeAnswer(const RolloutRow& answer) {
  std::string text = fmt::format("answered at {}", FormatInstant(answer.time_s));
  if (answer.held_s >= 0.0) text += fmt::format(" after {}", FormatSpan(answer.held_s));
  return text + ", of which " + DescribeComputing(answer);
}

// Of two copies the one that did not answer.
std::string DescribeSlower(const std::vector<RequestAttempt>& attempts, std::size_t life) {
  for (const RequestAttempt& other : attempts) {
    if (other.life != life || other.answer == nullptr) continue;
    return fmt::format("cancelled at {}, as {} had answered", FormatInstant(other.answer->time_s), other.worker);
  }
  return "";
}

void AddAttempts(const ExplainedRun& run, const std::vector<RequestAttempt>& attempts, bool is_open,
                 Explanation* text) {
  const std::vector<RecordedLife>& lives = run.record.lives;
  std::size_t life = 0;
  for (const RequestAttempt& attempt : attempts) {
    if (attempt.life != life) {
      text->Add("resumed", fmt::format("at {}: asked again, as the journal had no answer",
                                       FormatInstant(attempt.life < lives.size() ? lives[attempt.life].begin_s : 0.0)));
      life = attempt.life;
    }
    const std::string about = fmt::format("attempt {}", attempt.number);
    std::vector<std::string> parts;
    const bool is_last = &attempt == &attempts.back();
    if (IsUnrecorded(attempt) && !(is_last && is_open)) {
      text->Add(about, run.record.tells_why
                           ? "taken from the queue of a worker that had not begun with it, for one with nothing to do"
                           : "not on record: its worker was lost, or had not begun with it when another was free");
      continue;
    }
    std::string first = attempt.worker.empty() ? "waited for a worker" : attempt.worker;
    if (attempt.given_s >= 0.0) first += fmt::format(", given at {}", FormatInstant(attempt.given_s));
    if (attempt.copy_of != nullptr) first += fmt::format(", as a second copy: {} took long", attempt.copy_of->worker);
    parts.push_back(first);
    for (const RequestSetback* lost : attempt.resent) {
      parts.push_back(
          fmt::format("sent again at {}: the request or its answer was lost on the way", FormatInstant(lost->time_s)));
    }
    if (attempt.copied != nullptr) {
      parts.push_back(fmt::format("took long: at {} {} got a second copy", FormatInstant(attempt.copied->time_s),
                                  attempt.copied->copy_to));
    }
    if (attempt.lost != nullptr) parts.push_back(DescribeLoss(*attempt.lost));
    if (attempt.answer != nullptr) {
      parts.push_back((attempt.lost != nullptr ? "all the same " : "") + DescribeAnswer(*attempt.answer));
    } else if (attempt.lost == nullptr) {
      if (const std::string slower = DescribeSlower(attempts, attempt.life); !slower.empty()) parts.push_back(slower);
    }
    for (const std::string& part : parts) text->Add(about, part);
  }
}

void AddAnswer(const ExplainedRun& run, const RolloutRow& answer, bool has_gradient, Explanation* text) {
  const std::string unit = run.names && answer.kind != "distillation" ? run.names->loss_unit : "";
  const bool tells_success = !run.names || run.names->has_success;
  text->Add("answer", fmt::format("loss {:.9g}{}{}", answer.loss, unit,
                                  answer.kind == "distillation" ? " (distillation)"
                                  : !tells_success              ? ""
                                  : answer.success              ? ", success"
                                                                : ", no success"));
  text->Add("certified", answer.converged ? "finite and converged" : "it failed: not finite, or not converged");
  if (!answer.distrust.empty()) text->Add("", "not to be trusted, and no success: " + answer.distrust);
  if (has_gradient) {
    text->Add("", answer.gradient_reliable ? "the gradient is reliable"
                                           : "the gradient may not be that of the problem; why: the command below");
  }
  if (std::isfinite(answer.loss_error)) {
    text->Add("", fmt::format("time steps, Newton and rounding move the loss by about {:.1e}", answer.loss_error));
  }
  if (std::isfinite(answer.penetration)) {
    text->Add("", fmt::format("deepest contact {:.3g}% of the thinner body, largest force {:.3g} N",
                              100.0 * answer.penetration, answer.largest_force));
  }
}

// Where it is now.
void AddPresent(const ExplainedRun& run, const std::string& id, Explanation* text) {
  if (!run.live) {
    text->Add("now", run.silence);
    return;
  }
  bool is_held = false;
  for (const LiveWorker& worker : run.live->heard) {
    for (std::size_t i = 0; i < worker.held.size(); ++i) {
      if (!FormatHex(worker.held[i]).starts_with(id)) continue;
      is_held = true;
      text->Add("now", i == 0 && worker.computes
                           ? fmt::format("{} computes it ({:.0f}%)", worker.name, 100.0 * worker.step_fraction)
                           : fmt::format("waits with {}, behind {} more", worker.name, i));
    }
  }
  if (!is_held) text->Add("now", "no worker has it; it waits for one, or is on its way");
}

void AddRepetition(const ExplainedRun& run, const std::string& id, const RolloutRow* answer,
                   const std::optional<RequestOrigin>& origin, Explanation* text) {
  const std::string engine = run.names ? run.names->engine : run.record.engine;
  if (!engine.empty() && engine != "knap") {
    text->Add("again", fmt::format("by a worker of the engine {} alone", engine));
    return;
  }
  if (answer != nullptr && answer->kind == "test" && origin && !origin->design.empty()) {
    if (const std::optional<int> number = FindTestVariation(answer->variation, *run.names)) {
      text->Add("again", fmt::format("knap rollout {} --theta {} --variation {}", run.path, origin->design, *number));
      return;
    }
  }
  text->Add("again", fmt::format("knap rollout {} --request {}", run.path, id.substr(0, kShortDigits)));
}

}  // namespace

std::vector<std::string> FindRequests(const ExplainedRun& run, const std::string& digits) {
  std::set<std::string> whole;
  for (const RolloutRow& answer : run.record.answers) {
    if (answer.id.starts_with(digits)) whole.insert(answer.id);
  }
  if (run.live) {
    for (const LiveWorker& worker : run.live->heard) {
      for (const ContentId& id : worker.held) {
        if (const std::string hex = FormatHex(id); hex.starts_with(digits)) whole.insert(hex);
      }
    }
  }
  std::set<std::string> found = whole;
  for (const RequestSetback& setback : run.record.setbacks) {
    const std::string& id = setback.id;
    if (!id.starts_with(digits) && !digits.starts_with(id)) continue;
    const auto next = whole.lower_bound(id);
    if (next == whole.end() || !next->starts_with(id)) found.insert(id);
  }
  return {found.begin(), found.end()};
}

std::string ExplainRequest(const ExplainedRun& run, const std::string& id) {
  Explanation text;
  text.Add("request", id);
  const RolloutRow* answer = FindAnswer(run.record, id);
  std::optional<RequestOrigin> origin;
  if (answer != nullptr) {
    if (run.names) origin = FindOrigin(*answer, *run.names);
    // Without the question, what the worker spent on it tells.
    const bool has_gradient = origin ? origin->gradient : answer->gradient_s > 0.0;
    text.Add("kind", answer->kind + (has_gradient ? ", with gradient" : ""));
    AddVariation(run, *answer, &text);
    AddTheta(run, origin, &text);
    if (answer->waited_s >= 0.0) text.Add("asked", "at " + FormatInstant(answer->time_s - answer->waited_s));
    AddAttempts(run, ListAttempts(run.record, id), false, &text);
    AddAnswer(run, *answer, has_gradient, &text);
  } else {
    text.Add("kind", "not on record before it is answered; the command below finds out");
    AddAttempts(run, ListAttempts(run.record, id), run.live.has_value(), &text);
    text.Add("answer", "none");
    AddPresent(run, id, &text);
  }
  AddRepetition(run, id, answer, origin, &text);
  return text.Take();
}

}  // namespace knap
