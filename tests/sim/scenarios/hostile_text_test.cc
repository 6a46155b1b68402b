// Reading never throws, hangs or accepts what it cannot write back, whatever the text.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

#include "sim/scenarios/dump_scene.h"
#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace hostile_text_test {

RC_GTEST_PROP(HostileText, SurvivesDamagedFiles, ()) {
  std::string text = kEverythingYaml;
  const int edits = *rc::gen::inRange(1, 4);
  for (int i = 0; i < edits; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    const auto length = *rc::gen::inRange<std::size_t>(0, 3);
    const std::string piece = *rc::gen::element<std::string>(
        "", " ", "\n", "\t", "-", ": ", "{", "}", "[", "]", ",", "#", "\"", "'", "|", ">", "&a", "*a", "!", "? ", "0",
        "1e999", "null", "\xff", std::string(1, '\0'), "\xef\xbb\xbf");
    text.replace(at, length, piece);
  }
  const ParseResult result = ParseScene(text, "f.yaml");
  RC_CLASSIFY(result.ok());
  if (!result.ok()) {
    RC_ASSERT(!result.FormatErrors().empty());
    return;
  }
  const std::string dump = DumpScene(result.scene);
  const ParseResult again = ParseScene(dump, "f.yaml");
  RC_ASSERT(again.FormatErrors() == "");
  RC_ASSERT(DumpScene(again.scene) == dump);
}

RC_GTEST_PROP(HostileText, SurvivesAnyOverride, (const std::string& text)) {
  const std::string path = *rc::gen::element<std::string>("", "learning", "bodies.pea", "bodies[0]", "gravity",
                                                          "variation[0].key", "x.y[0]");
  const std::vector<std::string> overrides{text, path + "=" + text, path + text + "=1"};
  const ParseResult result = ParseScene(kEverythingYaml, "f.yaml", overrides);
  RC_ASSERT(result.ok() == result.FormatErrors().empty());
}

}  // namespace hostile_text_test
}  // namespace knap
