#include "sim/scenarios/config_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace knap {
namespace config_tree_test {

std::string ParseErrors(const std::string& text) {
  std::vector<ConfigError> errors;
  ParseConfigTree(text, errors);
  return FormatErrors(errors, "f.yaml");
}

TEST(ParseConfigTree, KeepsTextAndPositions) {
  std::vector<ConfigError> errors;
  const ConfigNode root = ParseConfigTree("a: 010\nb:\n  - name: x\n    c: [1 mm, yes]\n", errors);
  ASSERT_TRUE(errors.empty());
  ASSERT_EQ(root.entries.size(), 2u);
  EXPECT_EQ(root.Find("a")->text, "010");
  const ConfigNode& element = root.Find("b")->items.at(0);
  EXPECT_EQ(CalcElementStep(*root.Find("b"), 0), ".x");
  const ConfigNode& yes = element.Find("c")->items.at(1);
  EXPECT_EQ(yes.text, "yes");
  EXPECT_EQ(yes.position.line, 4);
  EXPECT_EQ(yes.position.column, 15);
  EXPECT_EQ(element.entries.at(1).position.line, 4);
  EXPECT_EQ(element.entries.at(1).position.column, 5);
}

TEST(ParseConfigTree, RefusesWhatScenariosDoNotUse) {
  EXPECT_EQ(ParseErrors("a: 1\nb: 2\na: 3\n"), "f.yaml:3:1: a: duplicate key, first given in line 1\n");
  EXPECT_EQ(ParseErrors("a: {x: 1, x: 2}\n"), "f.yaml:1:11: a.x: duplicate key, first given in line 1\n");
  EXPECT_EQ(ParseErrors("l:\n  - {name: n, b: {x: 1, x: 2}}\n  - {x: 1, x: 2}\n"),
            "f.yaml:2:25: l.n.b.x: duplicate key, first given in line 2\n"
            "f.yaml:3:12: l[1].x: duplicate key, first given in line 3\n");
  EXPECT_EQ(ParseErrors("a: &k 1\nb: *k\n"),
            "f.yaml:1:4: anchors (&name) are not part of the scenario format\n"
            "f.yaml:2:4: aliases (*name) are not part of the scenario format\n");
  EXPECT_EQ(ParseErrors("a: !!int 1\n"),
            "f.yaml:1:4: tag 'tag:yaml.org,2002:int': tags are not part of the scenario format\n");
  EXPECT_EQ(ParseErrors("? [1, 2]\n: 3\n"), "f.yaml:1:3: a key must be a name, not a list or a map\n");
  EXPECT_EQ(ParseErrors("a: 1\n---\nb: 2\n"),
            "f.yaml:3:1: a scenario file holds one YAML document, this is a second\n");
}

TEST(ParseConfigTree, ReportsBrokenYamlWhereItBreaks) {
  EXPECT_EQ(ParseErrors("a: [1, 2\nb: 3\n"), "f.yaml:2:2: not valid YAML: end of sequence flow not found\n");
  EXPECT_THAT(ParseErrors("a: 1\n\tb: 2\n"), testing::StartsWith("f.yaml:2:"));
  EXPECT_THAT(ParseErrors(std::string(100000, '[')), testing::HasSubstr("not valid YAML"));
}

TEST(ParseConfigTree, TakesAnEmptyTextAsNothing) {
  for (const char* text : {"", "\n\n", "# only a comment\n"}) {
    std::vector<ConfigError> errors;
    EXPECT_EQ(ParseConfigTree(text, errors).kind, ConfigNode::Kind::kNull) << text;
    EXPECT_TRUE(errors.empty()) << text;
  }
}

class ApplyOverridesTest : public testing::Test {
 protected:
  std::string Apply(const std::vector<std::string>& overrides) {
    std::vector<ConfigError> errors;
    root_ = ParseConfigTree("learning: {batch: 5}\nbodies:\n  - {name: pea, mass: 1 g}\n  - {x: 2}\nempty:\n", errors);
    ApplyOverrides(root_, overrides, errors);
    return FormatErrors(errors, "f.yaml", overrides);
  }

  ConfigNode root_;
};

TEST_F(ApplyOverridesTest, ReplacesAndAdds) {
  EXPECT_EQ(Apply({"learning.batch=10", "learning.seed=3", "bodies.pea.mass=5 g", "bodies[1].x=[1, 2]",
                   "new.deep.key=a=b", "empty.x=1"}),
            "");
  EXPECT_EQ(root_.Find("learning")->Find("batch")->text, "10");
  EXPECT_EQ(root_.Find("learning")->Find("batch")->position.override_index, 0);
  EXPECT_EQ(root_.Find("learning")->Find("seed")->text, "3");
  EXPECT_EQ(root_.Find("bodies")->items[0].Find("mass")->text, "5 g");
  EXPECT_EQ(root_.Find("bodies")->items[1].Find("x")->items.at(1).text, "2");
  EXPECT_EQ(root_.Find("bodies")->items[1].Find("x")->items.at(1).position.override_index, 3);
  EXPECT_EQ(root_.Find("new")->Find("deep")->Find("key")->text, "a=b");
  EXPECT_EQ(root_.Find("empty")->Find("x")->text, "1");
}

TEST_F(ApplyOverridesTest, TheLastOneWins) {
  EXPECT_EQ(Apply({"learning.batch=10", "learning.batch=20"}), "");
  EXPECT_EQ(root_.Find("learning")->Find("batch")->text, "20");
}

TEST_F(ApplyOverridesTest, ReportsWhatDoesNotExist) {
  EXPECT_EQ(Apply({"batch", "=1", "bodies.pae.mass=1", "bodies[2].x=1", "bodies[x]=1", "learning.batch.x=1",
                   "learning[0]=1", "learning.=1", "a..b=1", "learning.batch=[1"}),
            "command line: batch: expected KEY=VALUE, such as 'learning.batch=10'\n"
            "command line: =1: expected KEY=VALUE, such as 'learning.batch=10'\n"
            "command line: bodies.pae.mass=1: bodies: has no element 'pae'; did you mean 'pea'?\n"
            "command line: bodies[2].x=1: bodies: has 2 elements, there is no [2]\n"
            "command line: bodies[x]=1: bodies[x]: expected an index such as [0]\n"
            "command line: learning.batch.x=1: learning.batch: is the value '5', it has no key 'x'\n"
            "command line: learning[0]=1: learning: is not a list, there is no [0]\n"
            "command line: learning.=1: learning.: expected a key such as 'learning.batch'\n"
            "command line: a..b=1: a..b: expected a key such as 'learning.batch'\n"
            "command line: learning.batch=[1: not valid YAML: end of sequence flow not found\n");
}

TEST(FormatErrors, SortsByPositionAndPutsTheCommandLineLast) {
  const std::vector<std::string> overrides{"x=1"};
  EXPECT_EQ(FormatErrors({{{0, 1, 1}, "x", "third"}, {{-1, 10, 2}, "a", "second"}, {{-1, 9, 30}, "", "first"}}, "f",
                         overrides),
            "f:9:30: first\nf:10:2: a: second\ncommand line: x=1: x: third\n");
}

}  // namespace config_tree_test
}  // namespace knap
