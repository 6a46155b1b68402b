#include "coordinator/run_directory/run_logs.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <sstream>

#include "coordinator/run_directory/json_text.h"
#include "sim/scenarios/csv_text.h"

namespace knap {
namespace {

std::string FormatMicroseconds(std::int64_t time_us) {
  return fmt::format("{}.{:06}", time_us / 1000000, time_us % 1000000);
}

std::int64_t RoundToMicroseconds(double time_s) { return std::llround(std::max(0.0, time_s) * 1e6); }

// Opens for appending whole lines; a last line without its end is the trace of a crash and goes.
DurableFile OpenLines(const std::filesystem::path& path, const std::string& first_line) {
  DurableFile file(path, O_RDWR | O_CREAT | O_APPEND);
  const std::string text = file.ReadAll();
  const std::size_t end = text.rfind('\n');
  const std::size_t whole = end == std::string::npos ? 0 : end + 1;
  if (whole < text.size()) file.Truncate(whole);
  if (whole == 0) file.Write(first_line);
  return file;
}

std::string MakeMetricsHeader(const std::vector<std::string>& parameter_names) {
  std::string line =
      "time_s,batch,evaluation,loss,task_loss,distillation_loss,gradient_norm,best_loss,accepted,successes,rollouts,"
      "untrusted,validation_loss,validation_success";
  for (const std::string& name : parameter_names) line.append(1, ',').append(MakeCsvField(name));
  return line + "\n";
}

}  // namespace

MetricsLog::MetricsLog(const std::filesystem::path& path, const std::vector<std::string>& parameter_names)
    : file_(path, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND) {
  file_.Write(MakeMetricsHeader(parameter_names));
}

void MetricsLog::Append(double time_s, const LearningEvaluation& evaluation) {
  last_time_us_ = std::max(RoundToMicroseconds(time_s), last_time_us_ + 1);
  const BatchEvaluation& value = evaluation.value;
  std::string line = fmt::format("{},{},{},{},{},{},{},{},{:d},{},{},{},{}", FormatMicroseconds(last_time_us_),
                                 evaluation.batch, evaluation.evaluation, value.loss, value.task_loss,
                                 value.distillation_loss, value.gradient_norm, evaluation.best_loss, value.accepted,
                                 value.successes, evaluation.rollouts, value.untrusted, validation_);
  for (const double theta : value.theta) line += fmt::format(",{}", theta);
  file_.Write(line + "\n");
}

void MetricsLog::SetValidation(const BatchValidation& validation, bool has_success) {
  validation_ = fmt::format("{},", validation.test.loss_mean);
  if (has_success) validation_ += fmt::format("{}", validation.test.success_rate);
}

RolloutLog::RolloutLog(const std::filesystem::path& path)
    : file_(
          OpenLines(path,
                    "id,kind,variation,worker,attempt,loss,success,converged,gradient_reliable,loss_error,penetration,"
                    "largest_force,distrust,time_s,forward_s,gradient_s,waited_s,held_s\n")) {}

void RolloutLog::Append(const RolloutRow& row) {
  std::string variation;
  for (const double value : row.variation) variation += fmt::format("{}{}", variation.empty() ? "" : " ", value);
  const std::string loss_error = std::isfinite(row.loss_error) ? fmt::format("{}", row.loss_error) : "";
  const auto format_time = [](double time_s) {
    return std::isfinite(time_s) ? FormatMicroseconds(RoundToMicroseconds(time_s)) : "";
  };
  file_.Write(fmt::format("{},{},{},{},{},{},{:d},{:d},{:d},{},{},{},{},{},{},{},{},{}\n", MakeCsvField(row.id),
                          MakeCsvField(row.kind), variation, MakeCsvField(row.worker), row.attempt, row.loss,
                          row.success, row.converged, row.gradient_reliable, loss_error, row.penetration,
                          row.largest_force, MakeCsvField(row.distrust),
                          FormatMicroseconds(RoundToMicroseconds(row.time_s)), row.forward_s, row.gradient_s,
                          format_time(row.waited_s), format_time(row.held_s)));
}

std::vector<RolloutRow> ReadRollouts(const std::filesystem::path& path) {
  const CsvTable table(ReadFile(path));
  std::vector<RolloutRow> rows;
  for (std::size_t i = 0; i < table.size(); ++i) {
    RolloutRow& row = rows.emplace_back();
    row.time_s = table.GetNumber(i, "time_s");
    row.id = table.Get(i, "id");
    row.kind = table.Get(i, "kind");
    std::istringstream variation(table.Get(i, "variation"));
    for (std::string value; variation >> value;) row.variation.push_back(std::strtod(value.c_str(), nullptr));
    row.worker = table.Get(i, "worker");
    if (const double attempt = table.GetNumber(i, "attempt"); attempt >= 1.0 && attempt <= 1e9) {
      row.attempt = static_cast<int>(attempt);
    }
    row.loss = table.GetNumber(i, "loss");
    row.success = table.Get(i, "success") == "1";
    row.converged = table.Get(i, "converged") == "1";
    row.gradient_reliable = table.Get(i, "gradient_reliable") == "1";
    row.loss_error = table.GetNumber(i, "loss_error");
    row.penetration = table.GetNumber(i, "penetration");
    row.largest_force = table.GetNumber(i, "largest_force");
    row.distrust = table.Get(i, "distrust");
    row.forward_s = table.GetNumber(i, "forward_s");
    row.gradient_s = table.GetNumber(i, "gradient_s");
    row.waited_s = table.GetNumber(i, "waited_s");
    row.held_s = table.GetNumber(i, "held_s");
  }
  return rows;
}

std::vector<nlohmann::ordered_json> ParseEvents(const std::string& lines) {
  std::vector<nlohmann::ordered_json> events;
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);) {
    nlohmann::ordered_json event = nlohmann::ordered_json::parse(line, nullptr, false);
    if (event.is_object()) events.push_back(std::move(event));
  }
  return events;
}

EventLog::EventLog(const std::filesystem::path& path) : file_(OpenLines(path, "")) {}

void EventLog::Append(double time_s, const std::string& event, const nlohmann::ordered_json& details) {
  nlohmann::ordered_json line = {{"time_s", static_cast<double>(RoundToMicroseconds(time_s)) * 1e-6}, {"event", event}};
  for (const auto& [key, value] : details.items()) line[key] = value;
  file_.Write(MakeJsonText(line, -1) + "\n");
}

}  // namespace knap
