// Scenario files: read, checked and written again.
#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/parse_scene.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/sim/scenarios/sample_scenes.h"

std::vector<std::string> MakeSeeds() { return {knap::kEverythingYaml}; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const knap::ParseResult result = knap::ParseScene(text, "scene.yaml");
  Require(result.ok() == result.FormatErrors().empty(), "a scene or errors, never both");
  if (!result.ok()) return 0;
  const std::string written = knap::DumpScene(result.scene);
  const knap::ParseResult again = knap::ParseScene(written, "written.yaml");
  Require(again.ok() && knap::DumpScene(again.scene) == written, "what is written is read again");
  return 0;
}
