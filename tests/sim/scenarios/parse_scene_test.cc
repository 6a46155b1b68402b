// Each class of error of a single field: place and words.
#include "sim/scenarios/parse_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/sim/scenarios/edited_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace parse_scene_test {

TEST(ParseScene, ReadsAPendulumWithDefaults) {
  const ParseResult result = ParseScene(kPendulumYaml, "f.yaml");
  ASSERT_TRUE(result.ok()) << result.FormatErrors();
  const Scene& scene = result.scene;
  EXPECT_EQ(scene.gravity, Eigen::Vector3d(0.0, 0.0, -9.81));
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].parent, "world");
  EXPECT_EQ(scene.bodies[1].parent, "upper");
  const auto& joint = std::get<RevoluteJoint>(scene.bodies[0].joint.kind);
  EXPECT_EQ(joint.axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(joint.damping, 0.0);
  EXPECT_DOUBLE_EQ(joint.initial.angle, 0.52359877559829887);
  EXPECT_FALSE(!scene.bodies[0].shapes.empty());
  EXPECT_EQ(std::get<ExplicitInertia>(*scene.bodies[0].inertia).center, Eigen::Vector3d(0.0, 0.0, -0.1));
  EXPECT_EQ(std::get<DensityInertia>(*scene.bodies[1].inertia).density, 1000.0);
  EXPECT_EQ(scene.rollout.integrator, Integrator::kBdf1);
  EXPECT_FALSE(scene.design.has_value());
  EXPECT_FALSE(scene.success.has_value());
  EXPECT_TRUE(scene.contacts.empty() && scene.variation.empty() && scene.loss.task.empty());
  EXPECT_EQ(scene.learning.variations, 1);  // nothing varies
  EXPECT_TRUE(result.files.empty());
}

TEST(ParseScene, ReadsEveryKindOfThing) {
  const ParseResult result = ParseScene(kEverythingYaml, "f.yaml");
  ASSERT_TRUE(result.ok()) << result.FormatErrors();
  const Scene& scene = result.scene;
  EXPECT_EQ(scene.description, "quotes \" and \\, lines\n, ünïcode: yes");
  EXPECT_EQ(std::get<ZigzagMotion>(std::get<PrescribedJoint>(scene.bodies[1].joint.kind).motion).amplitude, 0.06);
  EXPECT_EQ(std::get<FreeJoint>(scene.bodies.back().joint.kind).initial.position, Eigen::Vector3d(0.0, 0.1, 0.01));
  EXPECT_EQ(scene.contacts[1].slip_speed, 1e-3);
  EXPECT_EQ(std::get<StraightState>(scene.ropes[1].initial).start, Eigen::Vector3d(0.0, 0.0, 0.03));
  EXPECT_EQ(scene.grips[0].limit, 2.0);
  EXPECT_EQ(scene.grips[1].held, "pill");
  EXPECT_EQ(std::get<DriftSignal>(scene.signals[13].kind).carried_by, "wall");
  EXPECT_EQ(std::get<DistanceSignal>(scene.signals[10].kind).in, "tool");
  EXPECT_EQ(std::get<AtCrossing>(scene.loss.task[0].when).crossing.at, 0.37);
  EXPECT_EQ(std::get<OverSamples>(scene.loss.task[1].when).reduce, Reduction::kMean);
  EXPECT_EQ(std::get<ScheduleTarget>(scene.loss.task[4].target).values[1].value, 0.02);
  EXPECT_EQ(scene.loss.task[4].side, Side::kBelow);
  EXPECT_EQ(scene.loss.task[5].shape, TermShape::kSaturating);
  const auto& any = std::get<AnyOf>(std::get<AllOf>(scene.success->kind).of[1].kind);
  EXPECT_EQ(std::get<Lasting>(std::get<Within>(any.of[2].kind).when).duration, 0.1);
  EXPECT_EQ(std::get<Within>(any.of[3].kind).below, std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.design->bodies[0].moves[1].group, "right");
  EXPECT_EQ(scene.design->bodies[0].vertex_groups[1].vertices, (std::vector<std::int64_t>{4, 5}));
  EXPECT_EQ(scene.loss.distillation[0].signals, (std::vector<std::string>{"pea_x", "pea_y"}));
  EXPECT_EQ(std::get<UniformDistribution>(scene.variation[0].distribution).lower, -0.02);
  EXPECT_EQ(scene.learning.method, SceneLearningMethod::kSimpleContinual);
  EXPECT_EQ(scene.learning.seed, 9007199254740991);
  ASSERT_EQ(result.files.size(), 2u);
  EXPECT_EQ(result.files[0].field, "design.bodies.tool.mesh");
  EXPECT_EQ(result.files[1].path, "meshes/tool_cage.obj");
}

class FieldError : public testing::TestWithParam<SceneErrorCase> {};

TEST_P(FieldError, StandsWhereItIsAndSaysWhatIsAllowed) {
  const EditedScene scene = EditScene(kEverythingYaml, GetParam().original, GetParam().edited);
  EXPECT_EQ(ParseEditedScene(scene), "f.yaml:" + scene.place + ": " + GetParam().error + "\n");
}

const SceneErrorCase kFieldErrors[] = {
    {"UnknownKey", "evaluation: {variations: 20", "evaluation: {@variation: 20",
     "evaluation.variation: unknown key; did you mean 'variations'?"},
    {"UnknownKeyAtTheTop", "evaluation: {", "@evalution: {", "evalution: unknown key; did you mean 'evaluation'?"},
    {"UnknownKeyWithoutNeighbour", "seed: 12}", "@qqqq: 12}",
     "evaluation.qqqq: unknown key; expected one of: variations, seed"},
    {"UnknownKeyOfAnAlternative", "radius: 1 cm}]\n    inertia: {type: solid, mass: 4.2 g}",
     "radius: 1 cm, @height: 1 cm}]\n    inertia: {type: solid, mass: 4.2 g}",
     "bodies.pea.shapes[0].height: unknown key; expected one of: type, radius, position, orientation_rpy"},
    {"StateOfAJointWithoutOne", "    shapes: [{type: half_space}]\n  - name: tool",
     "    shapes: [{type: half_space}]\n    @initial: {}\n  - name: tool",
     "bodies.ground.initial: unknown key; expected one of: name, parent, joint, shapes, inertia"},
    {"DuplicateKey", "evaluation: {variations: 20", "evaluation: {variations: 20, @variations: 21",
     "evaluation.variations: duplicate key, first given in line 216"},
    {"MissingNumber", "{type: solid, mass: 4.2 g}", "@{type: solid}",
     "bodies.pea.inertia.mass: missing; expected a mass with its unit, such as "
     "'4.2 g', more than 0 kg"},
    {"MissingType", "{type: half_space}]\n  - name: tool", "@{}]\n  - name: tool",
     "bodies.ground.shapes[0].type: missing; expected one of: half_space, sphere, capsule, cylinder, box, "
     "designed_mesh, "
     "mesh"},
    {"MissingSection",
     "      type: prescribed\n      motion: {type: zigzag, amplitude: 6 cm, period: 3 s, sharpness: 0.9, "
     "forward_speed: 60 mm/s, stop_at: 37 cm}",
     "      @type: prescribed", "bodies.tool.joint.motion: missing; expected a section of keys"},
    {"NoValue", "seed: 12}", "seed: @}",
     "evaluation.seed: has no value; expected an integer, from 0 to "
     "9007199254740991"},
    {"UnitMissing", "mass: 4.2 g", "mass: @4.2",
     "bodies.pea.inertia.mass: value '4.2': expected a mass with its unit, such as '4.2 g', more than 0 kg"},
    {"UnitWrong", "mass: 4.2 g", "mass: @4.2 mm",
     "bodies.pea.inertia.mass: value '4.2 mm': expected a mass with its unit, such as '4.2 g', more than 0 kg"},
    {"UnitUnknown", "mass: 4.2 g", "mass: @4.2 stone",
     "bodies.pea.inertia.mass: value '4.2 stone': expected a mass with its unit, such as '4.2 g', more than 0 kg"},
    {"UnitWhereNoneBelongs", "friction: 0.4", "friction: @0.4 m",
     "contacts[0].friction: value '0.4 m': expected a number without a unit, such as '0.4', from 0 to 10"},
    {"OutOfRange", "friction: 0.4", "friction: @-0.4", "contacts[0].friction: value '-0.4': must be from 0 to 10"},
    {"NotPositive", "mass: 4.2 g", "mass: @0 g", "bodies.pea.inertia.mass: value '0 g': must be more than 0 kg"},
    {"OctalTrap", "seed: 12}", "seed: @012}",
     "evaluation.seed: value '012': expected an integer, from 0 to 9007199254740991"},
    {"FractionalInteger", "seed: 12}", "seed: @1.5}",
     "evaluation.seed: value '1.5': expected an integer, from 0 to 9007199254740991"},
    {"IntegerOutOfRange", "seed: 12}", "seed: @-1}", "evaluation.seed: value '-1': must be from 0 to 9007199254740991"},
    {"YesTrap", "friction: 0.4", "friction: @yes",
     "contacts[0].friction: value 'yes': expected a number without a unit, such as '0.4', from 0 to 10"},
    {"WrongSchema", "schema: 2", "schema: @3", "schema: value '3': must be 2"},
    {"EarlierSchema", "schema: 2", "schema: @1",
     "schema: value '1': a file of an earlier format; this one is 2: docs/migrating.md tells what became of its keys"},
    {"ListForANumber", "mass: 4.2 g", "mass: @[4.2 g]",
     "bodies.pea.inertia.mass: is a list, expected a mass with its unit, such as '4.2 g', more than 0 kg"},
    {"SectionForANumber", "mass: 4.2 g", "mass: @{a: 1}",
     "bodies.pea.inertia.mass: is a section, expected a mass with its unit, such as '4.2 g', more than 0 kg"},
    {"NumberForAList", "[0 m/s^2, 0 m/s^2, -1.62 m/s^2]", "@-1.62 m/s^2",
     "gravity: value '-1.62 m/s^2': expected a list of exactly 3 elements"},
    {"WrongCount", "[0 m/s^2, 0 m/s^2, -1.62 m/s^2]", "@[0 m/s^2, 0 m/s^2]",
     "gravity: has 2 elements, expected exactly 3 elements"},
    {"WrongElement", "[0 m/s^2, 0 m/s^2, -1.62 m/s^2]", "[0 m/s^2, @zero, -1.62 m/s^2]",
     "gravity[1]: value 'zero': expected an acceleration with its unit, such as '-9.81 m/s^2'"},
    {"EmptyList", "optimize: [design, control]", "optimize: @[]",
     "learning.optimize: has 0 elements, expected at least 1 element"},
    {"ScalarForASection", "evaluation: {variations: 20, seed: 12}", "evaluation: @20",
     "evaluation: value '20': expected a section with the keys [variations] and [seed]"},
    {"ScalarForASectionOfAKind",
     "{type: zigzag, amplitude: 6 cm, period: 3 s, sharpness: 0.9, forward_speed: 60 mm/s, stop_at: 37 cm}", "@0.1 m/s",
     "bodies.tool.joint.motion: value '0.1 m/s': expected a section with the key type (zigzag, constant_velocity, "
     "segments, path, joint_path)"},
    {"UnknownType", "{type: free}\n    shapes: [{type: sphere", "{type: @fre}\n    shapes: [{type: sphere",
     "bodies.pea.joint.type: value 'fre': expected one of: fixed, prescribed, revolute, prismatic, ball, planar, free; "
     "did you mean 'free'?"},
    {"UnknownChoice", "integrator: bdf2", "integrator: @rk4",
     "rollout.integrator: value 'rk4': expected one of: tr_bdf2, bdf1, bdf2"},
    {"UnknownBody", "bodies: [pea, ground]", "bodies: [@pae, ground]",
     "contacts[0].bodies[0]: value 'pae': no such body or rope; did you mean 'pea'?"},
    {"UnknownParent", "parent: wall", "parent: @wal",
     "bodies.hinge.parent: value 'wal': no such body; did you mean "
     "'wall'?"},
    {"WorldHasNoShape", "bodies: [pea, ground]", "bodies: [pea, @world]",
     "contacts[0].bodies[1]: value 'world': no such body or rope; expected one of: ground, tool, wall, hinge, slider, "
     "swivel, puck, brick, hand, pill, pea, rope, cord"},
    {"UnknownParameter", "parameter: depth", "parameter: @dept",
     "design.bodies.tool.moves[2].parameter: value 'dept': no such parameter; did you mean 'depth'?"},
    {"UnknownGroup", "width, group: right", "width, group: @rihgt",
     "design.bodies.tool.moves[1].group: value 'rihgt': no such vertex group; did you mean 'right'?"},
    {"BadName", "name: everything", "name: @every-thing",
     "name: value 'every-thing': expected a name of letters, digits and _ that does not begin with a digit"},
    {"NameOfTheWorld", "name: puck", "name: @world",
     "bodies.world.name: value 'world': is the name of the world, which every scene has"},
    {"NameTwice", "name: puck", "name: @slider", "bodies.slider.name: value 'slider': another body has this name"},
    {"FileOutside", "meshes/tool.obj", "@../tool.obj",
     "design.bodies.tool.mesh: value '../tool.obj': expected a file below the scenario's folder, as a relative path "
     "without '..', "
     "such as 'meshes/tool.obj'"},
    {"FileAbsolute", "meshes/tool.obj", "@/tmp/tool.obj",
     "design.bodies.tool.mesh: value '/tmp/tool.obj': expected a file below the scenario's folder, as a relative path "
     "without "
     "'..', such as 'meshes/tool.obj'"},
    {"SignalTwice", "name: farthest,", "name: @nearest,",
     "signals.nearest.name: value 'nearest': another signal has this name"},
    {"UnknownSignal", "signals: [pill_error], when", "signals: [@pil_error], when",
     "loss.task[3].signals[0]: value 'pil_error': no such signal; did you mean 'pill_error'?"},
    {"UnknownSignalOfASignal", "of: [away, pill_error]", "of: [away, @pillerror]",
     "signals.nearest.of[1]: value 'pillerror': no such signal; did you mean 'pill_error'?"},
    {"UnknownKindOfSignal", "type: height, of: [rope]", "type: @hight, of: [rope]",
     "signals.rope_height.type: value 'hight': expected one of: angle, rate, displacement, speed, position, velocity, "
     "direction, angular_velocity, distance, center_of_mass, height, drift, depth, force, volume, extent, thickness, "
     "command, time, number, "
     "difference, norm, least, largest; did you mean 'height'?"},
    {"TermInTheUnitOfItsSignal", "scale: 3 cm/s", "scale: @3 cm",
     "loss.task[4].scale: value '3 cm': expected a speed with its unit, such as '60 mm/s', more than 0 m/s"},
    {"BoundInTheUnitOfItsSignal", "below: 3 N", "below: @3",
     "success.of[1].of[1].below: value '3': expected a force with its unit, such as '2 N'"},
    {"ObservationInTheUnitOfItsSignal", "offset: 10 deg", "offset: @10",
     "policy.observations[0].offset: value '10': expected an angle with its unit, such as '90 deg'"},
    {"WatchedNumberUnknown", "key: \"signals.pill_error.targets[0].position[0]\"",
     "key: @\"signals.pill_error.target[0].position[0]\"",
     "signals.goal.key: value 'signals.pill_error.target[0].position[0]': the scene has no such number; did you mean "
     "'signals.pill_error.targets[0].position[0]'?"},
    {"WatchedNumberOfTheLoss", "key: \"signals.pill_error.targets[0].position[0]\"", "key: @\"loss.task[0].margin\"",
     "signals.goal.key: value 'loss.task[0].margin': numbers of the loss and of success cannot be watched; make the "
     "goal "
     "a part of a signal"},
    {"VariationKeyUnknown", "\"contacts[0].friction\"", "@\"contacts[0].fricton\"",
     "variation[1].key: value 'contacts[0].fricton': the scene has no such number; did you mean "
     "'contacts[0].friction'?"},
    {"VariationKeyOfAnInteger", "\"contacts[0].friction\"", "@rollout.newton_max_iterations",
     "variation[1].key: value 'rollout.newton_max_iterations': the scene has no such number"},
    {"VariationKeyThatMayNotVary", "\"contacts[0].friction\"", "@learning.alpha",
     "variation[1].key: value 'learning.alpha': may not vary; numbers of gravity, bodies (but unit and pose of a "
     "mesh), "
     "contacts, grips, signals, loss and success may"},
    {"MeshWithoutAUnit", "    shapes: [{type: half_space}]\n  - name: hinge",
     "    shapes: [@{type: mesh, file: wall.obj}]\n  - name: hinge",
     "bodies.wall.shapes[0].unit: missing; expected a length with its unit, such as '10 mm', more than 0 m"},
    {"MeshAbove", "    shapes: [{type: half_space}]\n  - name: hinge",
     "    shapes: [{type: mesh, file: @../wall.obj, unit: 1 mm}]\n  - name: hinge",
     "bodies.wall.shapes[0].file: value '../wall.obj': expected a file below the scenario's folder, as a relative path "
     "without '..', such as 'meshes/tool.obj'"},
    {"VariationUnit", "lower: -20 mm", "lower: @-20",
     "variation[0].lower: value '-20': expected a length with its unit, such as '10 mm'"},
    {"BrokenYaml", "evaluation: {variations: 20, seed: 12}\n", "evaluation: {variations: 20, seed: 12\n@",
     "not valid YAML: end of map flow not found"},
};

INSTANTIATE_TEST_SUITE_P(All, FieldError, testing::ValuesIn(kFieldErrors),
                         [](const auto& the_case) { return std::string(the_case.param.name); });

TEST(ParseScene, ReportsAllErrorsAtOnceInTheirOrder) {
  const std::string text =
      "schema: 2\n"
      "nmae: x\n"
      "bodies:\n"
      "  - name: pea\n"
      "    joint: {type: fre}\n"
      "    shapes: [{type: sphere, radius: 10}]\n"
      "    initial: {position: [0 m, 0 m, 0 m]}\n"
      "  - name: ball\n"
      "    parent: pe\n"
      "    joint: {type: free}\n"
      "contacts:\n"
      "  - {bodies: [pea, pea], stiffness: 1 N/m^2, friction: 0.4}\n"
      "rollout: {horizon: 1 s, step: 0.3 s}\n"
      "variation:\n"
      "  - {key: \"bodies.pea.initial.position[0]\", distribution: uniform, lower: 1 m, upper: 0 m}\n"
      "learning: {batch: 200}\n";
  EXPECT_EQ(
      ParseScene(text, "f.yaml", std::vector<std::string>{"learning.alpha=x"}).FormatErrors(),
      "f.yaml:1:1: name: missing; expected a text\n"
      "f.yaml:2:1: nmae: unknown key; did you mean 'name'?\n"
      "f.yaml:5:19: bodies.pea.joint.type: value 'fre': expected one of: fixed, prescribed, revolute, prismatic, ball, "
      "planar, free; did you mean 'free'?\n"
      "f.yaml:6:37: bodies.pea.shapes[0].radius: value '10': expected a length with its unit, such as '10 mm', more "
      "than 0 "
      "m\n"
      "f.yaml:9:13: bodies.ball.parent: value 'pe': no such body; did you mean 'pea'?\n"
      "f.yaml:10:19: bodies.ball.inertia: a body that forces move needs an inertia; only fixed and prescribed ones do "
      "without\n"
      "f.yaml:12:14: contacts[0].bodies: a contact needs two different bodies\n"
      "f.yaml:12:37: contacts[0].stiffness: value '1 N/m^2': expected a contact stiffness with its unit, such as '1e8 "
      "N/m^3', more than 0 N/m^3\n"
      "f.yaml:13:20: rollout.horizon: value '1 s': must be a whole number of steps of 0.3 s\n"
      "f.yaml:16:19: learning.batch: value '200': a batch has at most all 100 variations\n"
      "command line: learning.alpha=x: learning.alpha: value 'x': expected a number without a unit, such as '0.4', at "
      "least 0\n");
}

TEST(ParseScene, AppliesOverrides) {
  const std::vector<std::string> overrides{"learning.batch=7", "bodies.pea.inertia.mass=5 g",
                                           "bodies.pea.initial.position=[1 mm, 2 mm, 3 mm]", "variation[0].upper=3 cm"};
  const ParseResult result = ParseScene(kEverythingYaml, "f.yaml", overrides);
  ASSERT_TRUE(result.ok()) << result.FormatErrors();
  EXPECT_EQ(result.scene.learning.batch, 7);
  EXPECT_EQ(std::get<SolidInertia>(*result.scene.bodies.back().inertia).mass, 0.005);
  EXPECT_EQ(std::get<FreeJoint>(result.scene.bodies.back().joint.kind).initial.position,
            Eigen::Vector3d(0.001, 0.002, 0.003));
  EXPECT_EQ(std::get<UniformDistribution>(result.scene.variation[0].distribution).upper, 0.03);
}

TEST(ParseScene, ReportsOverridesOnTheCommandLine) {
  const std::vector<std::string> overrides{"learning.bacth=7", "learning.batch=11", "bodies.pea.shapes[0].radius=1"};
  EXPECT_EQ(
      ParseScene(kEverythingYaml, "f.yaml", overrides).FormatErrors(),
      "command line: learning.bacth=7: learning.bacth: unknown key; did you mean 'batch'?\n"
      "command line: learning.batch=11: learning.batch: value '11': a batch has at most all 10 variations\n"
      "command line: bodies.pea.shapes[0].radius=1: bodies.pea.shapes[0].radius: value '1': expected a length with its "
      "unit, such as '10 mm', more than 0 m\n");
}

TEST(ParseScene, SaysWhatAnEmptyFileLacks) {
  EXPECT_EQ(ParseScene("", "f.yaml").FormatErrors(),
            "f.yaml:1:1: schema: missing; expected an integer, 2\n"
            "f.yaml:1:1: name: missing; expected a text\n"
            "f.yaml:1:1: bodies: missing; expected a list in [ ], at least 1 element\n"
            "f.yaml:1:1: rollout: missing; expected a section of keys\n");
  EXPECT_EQ(ParseScene("[1, 2]", "f.yaml").FormatErrors(), "f.yaml:1:1: expected a scenario: keys with values\n");
}

}  // namespace parse_scene_test
}  // namespace knap
