// The folder of one run and the files in it that are written whole [README.md]. The growing ones are in run_logs.h and
// journal.h.
//
//   config.yaml  run.json  journal  metrics.csv  rollouts.csv  events.jsonl  result.json  evaluation.json  tool/
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "coordinator/run_directory/result_document.h"

namespace knap {

struct RunInfo {
  std::string version;  // knap's
  std::string build;    // identifies the binary
  std::string scenario, method;
  std::uint64_t seed = 0;
  std::string host;
  std::string config_hash;  // hexadecimal
  std::chrono::system_clock::time_point started;
};

// "pushing-20250131T235959Z".
std::string MakeRunName(const std::string& scenario, std::chrono::system_clock::time_point started);

// All members throw std::system_error or std::filesystem::filesystem_error with the path when the disk refuses.
class RunDirectory {
 public:
  // `path` must not exist, or be an empty folder; std::runtime_error otherwise. Parents are made.
  static RunDirectory Create(const std::filesystem::path& path);

  // runs/<MakeRunName>, with -2, -3, … behind it when taken, and the link runs/latest to it.
  static RunDirectory CreateNamed(const std::filesystem::path& runs, const std::string& scenario,
                                  std::chrono::system_clock::time_point started);

  // An existing run, for resuming or reading; std::runtime_error when the folder holds no config.yaml.
  static RunDirectory Open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path config_path() const { return path_ / "config.yaml"; }
  std::filesystem::path info_path() const { return path_ / "run.json"; }
  std::filesystem::path journal_path() const { return path_ / "journal"; }
  std::filesystem::path metrics_path() const { return path_ / "metrics.csv"; }
  std::filesystem::path rollouts_path() const { return path_ / "rollouts.csv"; }
  std::filesystem::path events_path() const { return path_ / "events.jsonl"; }
  std::filesystem::path result_path() const { return path_ / "result.json"; }
  std::filesystem::path evaluation_path() const { return path_ / "evaluation.json"; }
  std::filesystem::path tool_path() const { return path_ / "tool"; }
  std::filesystem::path policy_path() const { return path_ / "policy"; }

  // Each replaces its file in one step (durable_file.h).
  void WriteConfig(const std::string& yaml) const;
  void WriteRunInfo(const RunInfo& info) const;
  // result.json, after evaluation.json with the two tests in full.
  void WriteResult(const ResultDocument& document) const;

 private:
  explicit RunDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

}  // namespace knap
