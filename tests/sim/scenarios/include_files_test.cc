// Files that a scenario includes: names, places, folders, and messages that say in which file they stand.
#include "sim/scenarios/include_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/scenarios/parse_scene.h"

namespace knap {
namespace include_files_test {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr char kScenario[] = R"(schema: 2
name: picking
include:
  - {file: robots/arm.yaml, name: arm, parent: table, position: [0 mm, 0 mm, 20 mm]}
  - {file: robots/arm.yaml, name: other}
bodies:
  - name: table
    joint: {type: fixed}
    shapes: [{type: half_space}]
contacts:
  - {bodies: [arm_hand, table], stiffness: 1e7 N/m^3}
rollout: {horizon: 1 s, step: 10 ms}
)";

constexpr char kArm[] = R"(schema: 2
description: of two parts
bodies:
  - name: base
    joint: {type: fixed}
  - name: hand
    parent: base
    joint: {type: prescribed, motion: {type: joint_path, file: paths/arm.csv, column: j1}}
    shapes: [{type: mesh, file: meshes/hand.stl, unit: 1 mm}, {type: sphere, radius: 1 cm}]
  - name: tip
    parent: hand
    joint: {type: revolute}
    inertia: {type: explicit, mass: 1 g, moments: [1e-6 kg*m^2, 1e-6 kg*m^2, 1e-6 kg*m^2]}
  - name: loose
    parent: world
    joint: {type: free}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
ropes:
  - name: cord
    links: 2
    pitch: 20 mm
    thickness: 4 mm
    link_mass: 1 g
    initial: {type: straight, start: [1 m, 0 m, 0 m], direction: [0, 1, 0]}
contacts:
  - {bodies: [hand, cord], stiffness: 1e7 N/m^3}
grips:
  - {body: hand, held: cord, stiffness: 10 N/m, until: 1 s}
)";

ParseResult Parse(const std::string& text, const std::map<std::string, std::string>& files,
                  const std::vector<std::string>& overrides = {}) {
  return ParseScene(text, "scene.yaml", overrides, [files](const std::string& path) {
    const auto file = files.find(path);
    if (file == files.end()) throw std::runtime_error("no such file");
    return IncludedText{"at/" + path, file->second};
  });
}

std::string Replace(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(IncludeFiles, TakeOverBodiesUnderNamesOfTheirOwn) {
  const ParseResult result =
      Parse(kScenario, {{"robots/arm.yaml", kArm}}, {"bodies.arm_tip.joint.damping=2 N*m*s/rad"});
  ASSERT_TRUE(result.ok()) << result.FormatErrors();
  const Scene& scene = result.scene;
  std::vector<std::string> names, parents;
  for (const Body& body : scene.bodies) {
    names.push_back(body.name);
    parents.push_back(body.parent);
  }
  EXPECT_THAT(names, ElementsAre("table", "arm", "arm_base", "arm_hand", "arm_tip", "arm_loose", "other", "other_base",
                                 "other_hand", "other_tip", "other_loose"));
  EXPECT_THAT(parents, ElementsAre("world", "table", "arm", "arm_base", "arm_hand", "arm", "world", "other",
                                   "other_base", "other_hand", "other"));
  EXPECT_TRUE(std::holds_alternative<FixedJoint>(scene.bodies[1].joint.kind));
  EXPECT_EQ(scene.bodies[1].joint.position.z(), 0.02);
  EXPECT_EQ(scene.bodies[6].joint.position.z(), 0.0);
  EXPECT_EQ(std::get<RevoluteJoint>(scene.bodies[4].joint.kind).damping, 2.0);
  EXPECT_EQ(std::get<RevoluteJoint>(scene.bodies[9].joint.kind).damping, 0.0);
  EXPECT_EQ(std::get<MeshShape>(scene.bodies[3].shapes[0].kind).file, "robots/meshes/hand.stl");
  const auto& motion = std::get<PrescribedJoint>(scene.bodies[3].joint.kind).motion;
  EXPECT_EQ(std::get<JointPathMotion>(motion).file, "robots/paths/arm.csv");
  EXPECT_EQ(std::get<JointPathMotion>(motion).column, "j1");
  ASSERT_EQ(scene.ropes.size(), 2u);
  EXPECT_EQ(scene.ropes[1].name, "other_cord");
  ASSERT_EQ(scene.contacts.size(), 3u);
  EXPECT_EQ(scene.contacts[1].bodies[0], "arm_hand");
  EXPECT_EQ(scene.contacts[1].bodies[1], "arm_cord");
  ASSERT_EQ(scene.grips.size(), 2u);
  EXPECT_EQ(scene.grips[1].body, "other_hand");
  EXPECT_EQ(scene.grips[1].held, "other_cord");
}

TEST(IncludeFiles, MessagesNameTheFileThatIsWrong) {
  const std::map<std::string, std::string> wrong = {
      {"robots/arm.yaml", Replace(kArm, "{type: sphere, radius: 1 cm}]", "{type: sphere, radius: 1 kg}]")}};
  EXPECT_EQ(Parse(kScenario, wrong).FormatErrors(),
            "at/robots/arm.yaml:9:86: bodies.arm_hand.shapes[1].radius: value '1 kg': expected a length with its unit, "
            "such as '10 mm', more than 0 m\n"
            "at/robots/arm.yaml:9:86: bodies.other_hand.shapes[1].radius: value '1 kg': expected a length with its "
            "unit, such as '10 mm', more than 0 m\n");
  EXPECT_THAT(Parse(kScenario, {{"robots/arm.yaml", "bodies: ["}}).FormatErrors(),
              HasSubstr("at/robots/arm.yaml:1:1: not valid YAML: "));
}

TEST(IncludeFiles, RefuseWhatTheyCannotTakeOver) {
  const auto complaint = [](const std::string& text, const std::string& arm) {
    return Parse(text, {{"robots/arm.yaml", arm}}).FormatErrors();
  };
  EXPECT_THAT(complaint(kScenario, std::string(kArm) + "loss: {}\n"),
              HasSubstr("at/robots/arm.yaml:30:1: loss: unknown key; "));
  EXPECT_THAT(complaint(kScenario, Replace(kArm, "schema: 2", "schema: 1")),
              HasSubstr("at/robots/arm.yaml:1:9: schema: value '1': expected 2\n"));
  EXPECT_THAT(complaint(Replace(kScenario, "robots/arm.yaml", "../arm.yaml"), kArm),
              HasSubstr("scene.yaml:4:12: include[0].file: value '../arm.yaml': expected a file below"));
  EXPECT_THAT(complaint(Replace(kScenario, "robots/arm.yaml", "robots/leg.yaml"), kArm),
              HasSubstr("scene.yaml:4:12: include[0].file: value 'robots/leg.yaml': cannot be read: no such file\n"));
  EXPECT_THAT(complaint(Replace(kScenario, "name: other", "naem: other"), kArm),
              HasSubstr("scene.yaml:5:29: include[1].naem: unknown key; did you mean 'name'?\n"));
  EXPECT_THAT(complaint(Replace(kScenario, "name: other", "name: arm"), kArm), HasSubstr("another body has this name"));
  EXPECT_THAT(ParseScene(kScenario, "scene.yaml").FormatErrors(),
              HasSubstr("scene.yaml:3:1: include: files can be included by a scenario file alone\n"));
}

}  // namespace include_files_test
}  // namespace knap
