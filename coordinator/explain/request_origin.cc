#include "coordinator/explain/request_origin.h"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <span>

#include "coordinator/random/counter_random.h"

namespace knap {
namespace {

// Whether the answer's request is this question, with a gradient (1), without one (0), or is not (empty).
std::optional<bool> Matches(const RolloutRow& answer, const RunNames& names, std::span<const double> theta,
                            std::span<const double> reference) {
  const std::size_t controls = names.problem.parameters.controls;
  if (theta.size() != names.problem.parameters.names.size() || theta.size() < controls) return std::nullopt;
  const std::size_t design = theta.size() - controls;
  for (const bool gradient : {true, false}) {
    const ContentId id = CalcRequestId({names.engine, names.scenario, theta.first(design), theta.subspan(design),
                                        reference, answer.variation, gradient});
    if (FormatHex(id) == answer.id) return gradient;
  }
  return std::nullopt;
}

std::optional<int> FindVariation(const std::vector<double>& variation, const RunNames& names, std::uint64_t seed,
                                 RandomStream stream, int count) {
  for (int i = 0; i < count; ++i) {
    if (SampleVariation(names.problem.variations, seed, stream, static_cast<std::uint64_t>(i)) == variation) return i;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RequestOrigin> FindOrigin(const RolloutRow& answer, const RunNames& names) {
  RequestOrigin origin;
  const auto try_design = [&](const std::vector<double>& theta, const std::vector<double>& reference) {
    const std::optional<bool> gradient = Matches(answer, names, theta, reference);
    if (!gradient) return false;
    origin.theta = theta;
    origin.reference = reference;
    origin.gradient = *gradient;
    return true;
  };
  if (answer.kind == "test" || answer.kind == "validation") {
    origin.design = "initial";
    if (try_design(names.problem.parameters.initial, {})) return origin;
    origin.design = "learned";
    if (try_design(names.learned, {})) return origin;
    origin.design.clear();
  }
  std::map<int, std::vector<double>> starts;  // by batch: what its distillation refers to
  for (const TriedDesign& tried : names.tried) {
    starts.try_emplace(tried.batch, tried.theta);
    origin.batch = tried.batch;
    origin.evaluation = tried.evaluation;
    if (answer.kind != "distillation") {
      if (try_design(tried.theta, {})) return origin;
    } else if (try_design(tried.theta, starts.at(tried.batch))) {
      origin.reference_batch = tried.batch;
      return origin;
    }
  }
  return std::nullopt;
}

std::optional<int> FindTestVariation(const std::vector<double>& variation, const RunNames& names) {
  return FindVariation(variation, names, names.test_seed, RandomStream::kTestVariations, names.tests);
}

std::string DescribeVariationNumber(const RolloutRow& answer, const RunNames& names) {
  const auto describe = [](const char* what, std::optional<int> i, int count) {
    return i ? fmt::format("{} variation {} of 0 to {}", what, *i, count - 1) : "";
  };
  const LearningOptions& learning = names.learning;
  if (answer.kind == "test") return describe("test", FindTestVariation(answer.variation, names), names.tests);
  if (answer.kind == "validation") {
    return describe(
        "validation",
        FindVariation(answer.variation, names, learning.seed, RandomStream::kValidation, learning.validation),
        learning.validation);
  }
  const bool first_batch = learning.method == LearningMethod::kDiffHand;
  const int count = first_batch ? learning.batch : learning.variations;
  return describe("training",
                  FindVariation(answer.variation, names, learning.seed,
                                first_batch ? RandomStream::kFirstBatch : RandomStream::kTrainingVariations, count),
                  count);
}

}  // namespace knap
