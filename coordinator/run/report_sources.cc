#include "coordinator/run/report_sources.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "coordinator/run/loss_unit.h"

namespace knap {

ReportSource MakeReportSource(const LoadedScenario& scenario, const RunDirectory& run, const Problem& problem,
                              RolloutModel& model, std::int64_t variations) {
  const Scene& scene = scenario.parsed.scene;
  ReportSource source;
  source.run = &run;
  source.problem = &problem;
  source.model = &model;
  source.loss_unit = FormatLossUnit(scene);
  source.loss_unit.erase(0, source.loss_unit.find_first_not_of(' '));
  const auto seed = static_cast<std::uint64_t>(scene.evaluation.seed);
  for (std::int64_t i = 0; i < variations; ++i) {
    source.variations.push_back(
        SampleVariation(problem.variations, seed, RandomStream::kTestVariations, static_cast<std::uint64_t>(i)));
  }
  return source;
}

ReportedTest MakeReportedTest(const ReportSource& source, const ContentId& task, const std::string& name,
                              std::vector<double> theta, const Answers& answers) {
  ReportedTest test{name, std::move(theta), {}, {}};
  const std::span<const double> all = test.theta;
  const std::size_t design = all.size() - source.problem->parameters.controls;
  for (const std::vector<double>& variation : source.variations) {
    const ContentId id = CalcRequestId({"knap", task, all.first(design), all.subspan(design), {}, variation, false});
    test.ids.push_back(FormatHex(id));
    const auto found = answers.find(id);
    test.outcomes.push_back(found == answers.end() ? std::nullopt : std::optional(found->second));
  }
  return test;
}

}  // namespace knap
