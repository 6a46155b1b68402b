// Designs and variations as the command line writes them, and the command knap validate.
#include "coordinator/cli/rollout_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/cli/exit_codes.h"
#include "coordinator/cli/validate_command.h"
#include "coordinator/run/usage_error.h"
#include "sim/scenarios/parse_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace rollout_arguments_test {

using testing::ElementsAre;
using testing::HasSubstr;

ParameterSpec MakeParameters() { return {{"width", "depth"}, {0.02, -0.015}, {0.056, 0.03}, {0.044, 0.0}, {"m", "m"}}; }

std::vector<double> Parse(const std::string& text) {
  return ParseTheta(text, "--theta", MakeParameters(), MakeParameters().initial);
}

template <class Function>
std::string FindUsageError(const Function& function) {
  try {
    function();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "none";
}

TEST(ParseTheta, TakesNamesListsAndUnits) {
  EXPECT_THAT(Parse("initial"), ElementsAre(0.044, 0.0));
  EXPECT_THAT(Parse("depth=10 mm"), ElementsAre(0.044, 0.01));
  EXPECT_THAT(Parse("depth=0.01 m,width=2 cm"), ElementsAre(0.02, 0.01));
  EXPECT_THAT(Parse("0.05,-3 mm"), ElementsAre(0.05, -0.003));
  EXPECT_THAT(Parse("1,1"), ElementsAre(1.0, 1.0)) << "out of bounds is allowed";
}

TEST(ParseTheta, NamesWhatIsWrong) {
  const auto error = [](const std::string& text) { return FindUsageError([&] { Parse(text); }); };
  EXPECT_EQ(error("widht=1 mm"), "--theta: no parameter 'widht'; did you mean width?");
  EXPECT_EQ(error("x=1 m"), "--theta: no parameter 'x'; there are width, depth");
  EXPECT_EQ(error("width=1 m,width=2 m"), "--theta: width is given twice");
  EXPECT_EQ(error("width=1 m,depth"), "--theta: 'depth': expected NAME=VALUE");
  EXPECT_EQ(error("width=1 kg"), "--theta: width: value '1 kg': expected a length with its unit, such as '10 mm'");
  EXPECT_EQ(error("width=30"), "--theta: width: value '30': expected a length with its unit, such as '10 mm'");
  EXPECT_EQ(error("best"), "--theta: 'best': expected initial, NAME=VALUE,… or all 2 values");
  EXPECT_EQ(error("1"), "--theta: 1 values; the scenario has 2 parameters");
  EXPECT_EQ(error("1,"), "--theta: depth: value '': expected a number in m or with its unit");
  EXPECT_EQ(error("1,nan"), "--theta: depth: value 'nan': expected a number in m or with its unit");
}

TEST(ParseTheta, ControlsHaveNoUnit) {
  const ParameterSpec spec{{"width", "control[0][hip]", "control[1][hip]"},
                           {0.0, -3.0, -3.0},
                           {1.0, 3.0, 3.0},
                           {0.5, 0.0, 0.0},
                           {"m", "", ""}};
  EXPECT_THAT(ParseTheta("control[1][hip]=-0.5,width=2 cm", "--theta", spec, spec.initial),
              ElementsAre(0.02, 0.0, -0.5));
  EXPECT_THAT(ParseTheta("2 cm,1,2", "--theta", spec, spec.initial), ElementsAre(0.02, 1.0, 2.0));
  EXPECT_EQ(FindUsageError([&] { ParseTheta("control[0][hip]=1 mm", "--theta", spec, spec.initial); }),
            "--theta: control[0][hip]: value '1 mm': expected a number without a unit, such as '0.4'");
  EXPECT_EQ(FindUsageError([&] { FindParameter("control[0][hop]", "--x", spec); }),
            "--x: no parameter 'control[0][hop]'; did you mean control[0][hip]?");
}

TEST(ParseVariationValues, FollowsTheKeys) {
  const Scene scene = ParseScene(kEverythingYaml, "f.yaml").scene;
  EXPECT_THAT(ReadNominalVariation(scene), ElementsAre(0.0, 0.4, 0.001));
  EXPECT_THAT(ParseVariationValues("3 mm,0.5,-0.002", "--v", scene), ElementsAre(0.003, 0.5, -0.002));
  const auto error = [&](const std::string& text) {
    return FindUsageError([&] { ParseVariationValues(text, "--v", scene); });
  };
  EXPECT_EQ(error("1,2"), "--v: 2 values; the scenario has 3 varied keys");
  EXPECT_EQ(error("1,-2,0"), "--v: contacts[0].friction: value '-2': must be from 0 to 10");
  EXPECT_EQ(error("1,2 m,0"), "--v: contacts[0].friction: value '2 m': expected a number");
}

TEST(QuoteForShell, KeepsAWordAWord) {
  EXPECT_EQ(QuoteForShell("configs/a.yaml"), "configs/a.yaml");
  EXPECT_EQ(QuoteForShell("rollout.step=2 ms"), "'rollout.step=2 ms'");
  EXPECT_EQ(QuoteForShell("it's"), "'it'\\''s'");
  EXPECT_EQ(QuoteForShell(""), "''");
}

// What `knap validate …` throws or prints.
std::string Validate(std::vector<std::string> arguments) {
  CLI::App app;
  std::function<int()> command;
  AddValidateCommand(&app, &command);
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  arguments.push_back("validate");
  app.parse(std::move(arguments));
  testing::internal::CaptureStdout();
  const std::string error = FindUsageError([&] { EXPECT_EQ(command(), kExitDone); });
  const std::string output = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(error == "none" || output.empty());
  return error == "none" ? output : error;
}

const std::string kPushing = KNAP_CONFIGS "/pushing.yaml";

TEST(ValidateCommand, SumsUpWhatIsRight) {
  const std::string summary = Validate({kPushing, "rollout.horizon=100 ms"});
  // The bar on file, and what one of its parameters does at either bound.
  EXPECT_THAT(summary,
              testing::StartsWith("pusher: 104.00 x 12.00 x 20.00 mm, 24.960 cm^3 as on file, 880 triangles, edges "
                                  "up to 11.66 mm\n"));
  EXPECT_THAT(summary, testing::ContainsRegex("  middle_width +30 mm 90.*\n +50 mm 110.00 x 12.00 x 20.00 mm"));
  EXPECT_THAT(summary, testing::EndsWith(kPushing +
                                         ": valid: 3 bodies, 2 contacts, 7 design parameters, 2 varied keys, 10 steps "
                                         "of 0.01 s\n"));
  EXPECT_THAT(Validate({"--describe"}), HasSubstr("# Scenario files\n"));
}

TEST(ValidateCommand, ShowsThePiecesOfAMesh) {
  const std::string trough = KNAP_TEST_DATA "/mesh/trough.yaml";
  // A floor of 210 x 10 mm and a wall of 10 x 40 mm, cut from corner to corner.
  EXPECT_THAT(Validate({trough}),
              testing::StartsWith(trough +
                                  ": trough.obj of trough is not convex and touches as 2 convex pieces, of its "
                                  "volume 18.0% + 82.0% = 100.0%\n" +
                                  trough + ": valid: "));
}

TEST(ValidateCommand, TellsAllErrorsOfFormatModelAndOptimizer) {
  const std::string errors =
      Validate({kPushing, "rollout.step=3x", "design.bodies.pusher.vertex_groups.left_tip.vertices=[0,77]"});
  EXPECT_THAT(errors, HasSubstr("rollout.step: value '3x': expected a time"));
  EXPECT_THAT(errors, HasSubstr("vertices[1]: value '77': the cage has 24 vertices, 0 to 23"));
  EXPECT_THAT(Validate({kPushing, "learning.optimizer=FOO"}),
              testing::AllOf(testing::StartsWith(kPushing + ": "), HasSubstr("FOO")));
  EXPECT_EQ(Validate({"none.yaml"}), "none.yaml:1:1: cannot be read: No such file or directory");
  EXPECT_THROW(Validate({}), CLI::ParseError);
}

}  // namespace rollout_arguments_test
}  // namespace knap
