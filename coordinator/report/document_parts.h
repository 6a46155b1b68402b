// The parts that the documents of a run's page are put together from (page/README.md).
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "coordinator/report/report_source.h"

namespace knap {

// format, knap, run, loss_unit, loss_note, has_success. `result`: of result.json; an object without members while the
// run goes on. Throws std::runtime_error where run.json is not readable.
nlohmann::ordered_json MakeHeadJson(const ReportSource& source, const nlohmann::ordered_json& result);

nlohmann::ordered_json MakeThetaJson(const ReportSource& source);

nlohmann::ordered_json MakeVariationJson(const ReportSource& source);

// Simulates a test of `source` on the variation again. The first time `page` gets bodies, gravity and fixed_poses too.
nlohmann::ordered_json RecordReplayJson(const ReportSource& source, const ReportedTest& test, std::size_t variation,
                                        nlohmann::ordered_json* page);

}  // namespace knap
