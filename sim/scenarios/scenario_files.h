// A scenario with the files it names: read from disk once, then carried as names and bytes, so that whoever simulates
// it needs no shared disk.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "sim/scenarios/parse_scene.h"
#include "sim/scenarios/scenario_paths.h"

namespace knap {

struct LoadedScenario {
  ParseResult parsed;
  // Each file's path as written → its bytes, as far as it could be read; when parsed.ok() also kScenarioFileName →
  // DumpScene's text, overrides included.
  std::map<std::string, std::string> files;
};

// Where the file lies that a scenario in `folder` names: folder/path; for a path with a component "library" that is not
// there, a/library/b, the nearest library/b upwards from folder/a, so that scenarios of several folders share one. The
// name stays as written, and a run keeps its own copy under it.
std::filesystem::path FindScenarioFile(const std::filesystem::path& folder, const std::string& path);

// Reads the scenario at `config` and the files it names (FindScenarioFile). All that is wrong,
// unreadable files included, is in parsed.FormatErrors(). Messages name the scenario as `config` is written.
LoadedScenario LoadScenario(const std::filesystem::path& config, std::span<const std::string> overrides = {});

// What a rollout follows from: the files with a scene that says nothing of how it is learned and evaluated. All runs of
// one task, whatever their seeds and methods, ask workers for the same rollouts of the same scenario. parsed.ok().
std::map<std::string, std::string> ListTaskFiles(const LoadedScenario& scenario);

// The scene in files of LoadScenario or ListTaskFiles. Touches no disk. Throws std::runtime_error with one line when
// they do not hold a valid scene and exactly the files it names.
Scene ParseScenarioFiles(const std::map<std::string, std::string>& files);

}  // namespace knap
