// The folder of one run and the files in it that are written whole [README.md]. The growing ones are in run_logs.h and
// journal.h.
//
//   config.yaml  run.json  journal  metrics.csv  rollouts.csv  events.jsonl  result.json  evaluation.json  report.html
//   tool/
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "coordinator/run_directory/journal.h"
#include "coordinator/run_directory/result_document.h"

namespace knap {

struct RunInfo {
  std::string version;  // knap's
  std::string build;    // identifies the binary
  std::string scenario, method;
  std::uint64_t seed = 0;
  std::string host;
  std::string config_hash;  // hexadecimal
  std::string
      started_from{};  // the run whose learned values it starts at, as given; empty: it starts at the initial ones
  std::chrono::system_clock::time_point started;
  RunIdentity identity;  // as in the journal's header, which can be written again from it
};

// "pushing-20250131T235959Z".
std::string MakeRunName(const std::string& scenario, std::chrono::system_clock::time_point started);

// All members throw std::system_error or std::filesystem::filesystem_error with the path when the disk refuses.
class RunDirectory {
 public:
  // `path` must not exist, or be an empty folder or one that a crash left before it was a run (run.json, but not yet
  // config.yaml); std::runtime_error otherwise. Parents are made.
  static RunDirectory Create(const std::filesystem::path& path);

  // runs/<MakeRunName>, with -2, -3, … behind it when taken.
  static RunDirectory CreateNamed(const std::filesystem::path& runs, const std::string& scenario,
                                  std::chrono::system_clock::time_point started);

  // Removes the folder and all in it, as far as the disk allows: a run that could not be begun leaves nothing.
  void Remove() const noexcept;

  // Lets the link `latest` beside the folder lead to it. A convenience that not every disk offers: returns what was in
  // the way, in one line, and then has changed nothing.
  std::optional<std::string> LinkLatest() const;

  // An existing run, for resuming or reading; std::runtime_error when the folder holds no config.yaml.
  static RunDirectory Open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path config_path() const { return path_ / "config.yaml"; }
  std::filesystem::path info_path() const { return path_ / "run.json"; }
  std::filesystem::path journal_path() const { return path_ / "journal"; }
  std::filesystem::path metrics_path() const { return path_ / "metrics.csv"; }
  std::filesystem::path rollouts_path() const { return path_ / "rollouts.csv"; }
  std::filesystem::path events_path() const { return path_ / "events.jsonl"; }
  std::filesystem::path study_path() const { return path_ / "study.json"; }  // of a study alone
  std::filesystem::path trace_path() const { return path_ / "trace.json"; }  // of `knap trace`
  std::filesystem::path result_path() const { return path_ / "result.json"; }
  std::filesystem::path evaluation_path() const { return path_ / "evaluation.json"; }
  std::filesystem::path report_path() const { return path_ / "report.html"; }
  std::filesystem::path tool_path() const { return path_ / "tool"; }
  std::filesystem::path policy_path() const { return path_ / "policy"; }

  // Each replaces its file in one step (durable_file.h).
  void WriteConfig(const std::string& yaml) const;
  void WriteRunInfo(const RunInfo& info) const;
  // From run.json: RunInfo::identity. std::runtime_error with one line when the file does not hold it.
  RunIdentity ReadIdentity() const;
  // result.json, after evaluation.json with the two tests in full.
  void WriteResult(const ResultDocument& document) const;

 private:
  explicit RunDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

}  // namespace knap
