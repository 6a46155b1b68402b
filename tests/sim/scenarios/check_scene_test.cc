// Fields that are right each by itself but contradict each other.
#include "sim/scenarios/check_scene.h"

#include <gtest/gtest.h>

#include "tests/sim/scenarios/edited_scene.h"
#include "tests/sim/scenarios/sample_scenes.h"

namespace knap {
namespace check_scene_test {

class Contradiction : public testing::TestWithParam<SceneErrorCase> {};

TEST_P(Contradiction, IsReportedOnceAtItsPlace) {
  const EditedScene scene = EditScene(kEverythingYaml, GetParam().original, GetParam().edited);
  EXPECT_EQ(ParseEditedScene(scene), "f.yaml:" + scene.place + ": " + GetParam().error + "\n");
}

const SceneErrorCase kContradictions[] = {
    {"LimitsUpsideDown", "limits: {lower: -90 deg", "limits: {lower: @91 deg",
     "bodies.hinge.joint.limits.lower: value '91 deg': must be less than upper, 1.5707963267948966 rad"},
    {"TargetsUpsideDown", "lower: -9 mm", "lower: @10 mm",
     "bodies.slider.joint.actuator.lower: value '10 mm': must be less than upper, 0.009 m"},
    {"NothingToRideOn", "parent: tool\n    joint: {type: free, attachment: {",
     "parent: wall\n    joint: {type: free, attachment: @{",
     "bodies.brick.joint.attachment: only a designed parent has a mesh that joints move with"},
    {"NoActuator", "actuators: [slider]", "actuators: [slider, @swivel]",
     "controls.actuators[1]: value 'swivel': the joint of this body has no actuator"},
    {"TooMuchForACommand", "lower: -1, upper: 0.75", "lower: -1, upper: @1.5",
     "controls.upper: value '1.5': commands lie from -1 to 1, and so must controls that are not squashed"},
    {"PlacesOutOfOrder", "{after: 0.5 s, position", "{after: @0 s, position",
     "signals.pill_error.targets[1].after: value '0 s': must be later than the one before"},
    {"ValuesOutOfOrder", "{after: 0.6 s, value", "{after: @0.2 s, value",
     "loss.task[4].target.values[2].after: value '0.2 s': must be later than the one before"},
    {"TargetsBetweenSteps", "every: 10 ms", "every: @11 ms",
     "loss.task[3].when.every: value '11 ms': must be a whole number of steps of 0.002 s"},
    {"ActuatorTwice", "actuators: [slider]", "actuators: @[slider, slider]",
     "controls.actuators: names an actuator twice"},
    {"IntervalBetweenSteps", "[slider], interval: 100 ms", "[slider], interval: @101 ms",
     "controls.interval: value '101 ms': must be a whole number of steps of 0.002 s"},
    {"IntervalAcrossTheEnd", "[slider], interval: 100 ms", "[slider], interval: @300 ms",
     "controls.interval: value '300 ms': the horizon, 1 s, must be a whole number of intervals"},
    {"ControlBoundsSwapped", "lower: -1, upper: 0.75", "lower: @3, upper: 0.75",
     "controls.lower: value '3': must be less than upper, 0.75"},
    {"ControlStartsOutside", "initial: 0.5", "initial: @2.5",
     "controls.initial: value '2.5': must lie from lower, -1, to upper, 0.75"},
    {"OursMovesNoPolicy", "method: simple_continual, optimize: [design, control]",
     "method: ours, optimize: [design, @policy]",
     "learning.optimize[1]: value 'policy': method ours chooses among design parameters alone; diffhand and "
     "simple_continual move policies"},
    {"ActuatorOfControlsToo", "actuators: [hinge]", "actuators: [@slider]",
     "policy.actuators[0]: value 'slider': open-loop controls drive this actuator already"},
    {"PolicyWithoutActuator", "actuators: [hinge]", "actuators: [@puck]",
     "policy.actuators[0]: value 'puck': the joint of this body has no actuator"},
    {"PolicyHasAnotherClock", "[hinge]\n  interval: 100 ms", "[hinge]\n  interval: @50 ms",
     "policy.interval: value '50 ms': must be that of the controls, 0.1 s"},
    {"OutputsWithoutBounds", "squash: tanh", "squash: @none",
     "policy.squash: value 'none': outputs that are not squashed have no bounds, and the force actuator of hinge has "
     "no "
     "limit of its own: squash them with tanh"},
    {"AngleOfASlider", "type: angle, joint: hinge", "type: angle, joint: @slider",
     "signals.hinge_angle.joint: value 'slider': the joint of this body is not revolute; of others the body's "
     "position, "
     "direction, velocity and angular_velocity can be watched"},
    {"RateOfASlider", "type: rate, joint: hinge", "type: rate, joint: @slider",
     "signals.hinge_rate.joint: value 'slider': the joint of this body is not revolute; of others the body's position, "
     "direction, velocity and angular_velocity can be watched"},
    {"DisplacementOfABall", "type: displacement, joint: slider", "type: displacement, joint: @swivel",
     "signals.slider_shift.joint: value 'swivel': the joint of this body is not prismatic; of others the body's "
     "position, "
     "direction, velocity and angular_velocity can be watched"},
    {"SpeedOfABall", "type: speed, joint: slider", "type: speed, joint: @swivel",
     "signals.slider_speed.joint: value 'swivel': the joint of this body is not prismatic; of others the body's "
     "position, "
     "direction, velocity and angular_velocity can be watched"},
    {"SeenFromItself", "in: pea, axis: y", "in: @pill, axis: y",
     "signals.pill_seen.in: value 'pill': a body does not move in its own frame; name another one, or the world"},
    {"DirectionSeenFromItself", "in: slider, axis: y", "in: @swivel, axis: y",
     "signals.swivel_up.in: value 'swivel': a body does not move in its own frame; name another one, or the world"},
    {"FarFromItself", "in: tool,", "in: @pill,",
     "signals.pill_error.in: value 'pill': a body does not move in its own frame; name another one, or the world"},
    {"CenterOfOneTwice", "of: [rope, pill]", "of: @[rope, rope]", "signals.center_z.of: names something twice"},
    {"HeightOfOneTwice", "type: height, of: [rope]", "type: height, of: @[rope, rope]",
     "signals.rope_height.of: names something twice"},
    {"DriftOfOneTwice", "type: drift, of: [rope]", "type: drift, of: @[rope, rope]",
     "signals.rope_drift.of: names something twice"},
    {"CenterOfWhatHasNoInertia", "of: [rope, pill]", "of: [rope, @wall]",
     "signals.center_z.of[1]: value 'wall': has no inertia, and so no centre of mass"},
    {"CenterThatTheDesignMoves", "of: [rope, pill]", "of: [rope, @tool]",
     "signals.center_z.of[1]: value 'tool': the centre of mass of this body moves with its design: give it an explicit "
     "inertia, or watch a point"},
    {"DepthWithoutAContact", "type: depth, bodies: [rope, tool]", "type: depth, bodies: @[pill, ground]",
     "signals.rope_depth.bodies: pill has no contact with ground; see contacts"},
    {"ForceWithoutAContact", "type: force, bodies: [rope, rope]", "type: force, bodies: @[ground, ground]",
     "signals.rope_force.bodies: ground has no contact with ground; see contacts"},
    {"VolumeOfWhatNothingDesigns", "type: volume, body: tool", "type: volume, body: @pill",
     "signals.tool_volume.body: value 'pill': none of its shapes is a designed mesh; others stay as they are"},
    {"ExtentOfWhatNothingDesigns", "type: extent, body: tool", "type: extent, body: @pill",
     "signals.tool_length.body: value 'pill': none of its shapes is a designed mesh; others stay as they are"},
    {"ThicknessOfWhatNothingDesigns", "type: thickness, body: tool", "type: thickness, body: @pill",
     "signals.tool_wall.body: value 'pill': none of its shapes is a designed mesh; others stay as they are"},
    {"GroupInTwoWays", "{name: front, box", "{name: @front, vertices: [0], box",
     "design.bodies.tool.vertex_groups.front.name: value 'front': needs one of vertices, box and plane to say which "
     "vertices of the cage it has"},
    {"BoxUpsideDown", "lower: [-1 m, 0 mm, -1 m]", "lower: [-1 m, @2 cm, -1 m]",
     "design.bodies.tool.vertex_groups.front.box.lower[1]: value '2 cm': must not be more than upper, 0.01 m"},
    {"PlaneWithoutASide", "normal: [0, 0, 2]", "normal: @[0, 0, 0]",
     "design.bodies.tool.vertex_groups.top.plane.normal: must not be zero"},
    {"CommandOfWhatNothingDrives", "actuator: slider}", "actuator: @swivel}",
     "signals.slider_command.actuator: value 'swivel': neither controls nor a policy drive this body's joint"},
    {"DifferenceOfThree", "of: [pea_x, goal]", "of: @[pea_x, pea_y, goal]",
     "signals.pea_off.of: a difference is of two signals"},
    {"DifferenceOfALaterOne", "of: [pea_x, goal]", "of: [pea_x, @away]",
     "signals.pea_off.of[1]: value 'away': must stand before this signal"},
    {"NormOfItself", "of: [pea_off, pea_y]", "of: [pea_off, @away]",
     "signals.away.of[1]: value 'away': must stand before this signal"},
    {"LeastOfALaterOne", "of: [away, pill_error]", "of: [away, @farthest]",
     "signals.nearest.of[1]: value 'farthest': must stand before this signal"},
    {"LargestOfItself", "of: [away, nearest]", "of: [away, @farthest]",
     "signals.farthest.of[1]: value 'farthest': must stand before this signal"},
    {"DifferenceOfTwoUnits", "of: [pea_x, goal]", "of: [pea_x, @clock]",
     "signals.pea_off.of[1]: value 'clock': 'clock' is in s and 'pea_x' in m; they must have one unit"},
    {"LargestOfTwoUnits", "of: [away, nearest]", "of: [away, @swivel_up]",
     "signals.farthest.of[1]: value 'swivel_up': 'swivel_up' is in no unit and 'away' in m; they must have one unit"},
    {"DriftBetweenSteps", "since: 80 ms", "since: @81 ms",
     "signals.rope_drift.since: value '81 ms': must be a whole number of steps of 0.002 s"},
    {"DriftSinceAfterTheEnd", "since: 80 ms", "since: @1.1 s",
     "signals.rope_drift.since: value '1.1 s': must be at most the horizon, 1 s"},
    {"TermOfTwoUnits", "- {signals: [pea_x, pea_y], target", "- {signals: [pea_x, @hinge_rate], target",
     "loss.task[5].signals[1]: value 'hinge_rate': 'hinge_rate' is in rad/s and 'pea_x' in m; they must have one "
     "unit"},
    {"TargetOfAnotherUnit", "signal: goal}, shape", "signal: @clock}, shape",
     "loss.task[5].target.signal: value 'clock': 'clock' is in s and 'pea_x' in m; they must have one unit"},
    {"ReferenceInATask", "target: {type: signal, signal: goal}, shape", "target: {type: @reference}, shape",
     "loss.task[5].target.type: value 'reference': the reference trajectory is known in loss.distillation alone"},
    {"ReferenceOfACrossing", "when: {type: samples, every: 20 ms, reduce: mean}",
     "when: {type: @crossing, signal: pea_y, at: 370 mm}",
     "loss.distillation[0].when.type: value 'crossing': the reference trajectory is known at the end, at a time and "
     "over samples"},
    {"SuccessOfTwoUnits", "signals: [away], below", "signals: [away, @clock], below",
     "success.of[1].of[2].signals[1]: value 'clock': 'clock' is in s and 'away' in m; they must have one unit"},
    {"AMomentBetweenSteps", "type: at, time: 0.4 s", "type: at, time: @401 ms",
     "loss.task[4].when.time: value '401 ms': must be a whole number of steps of 0.002 s"},
    {"AMomentAfterTheEnd", "type: at, time: 0.4 s", "type: at, time: @1.2 s",
     "loss.task[4].when.time: value '1.2 s': must be at most the horizon, 1 s"},
    {"SuccessBetweenSteps", "type: at, time: 0.6 s", "type: at, time: @601 ms",
     "success.of[2].of[0].when.time: value '601 ms': must be a whole number of steps of 0.002 s"},
    {"SuccessAfterTheEnd", "type: at, time: 0.6 s", "type: at, time: @1.2 s",
     "success.of[2].of[0].when.time: value '1.2 s': must be at most the horizon, 1 s"},
    {"BoundsUpsideDown", "above: -20 mm, below: 20 mm", "above: @30 mm, below: 20 mm",
     "success.of[0].above: value '30 mm': must be less than `below`"},
    {"EverAfterItsEnd", "type: ever, from: 0.5 s", "type: ever, from: @0.7 s",
     "success.of[1].of[0].when.from: value '0.7 s': must be less than `until`, 0.7 s"},
    {"EverAfterTheEnd", "type: ever, from: 0.5 s, until: 0.7 s", "type: ever, from: @1 s",
     "success.of[1].of[0].when.from: value '1 s': must be less than the horizon, 1 s"},
    {"AlwaysBeyondTheEnd", "type: always, from: 0.25 s, until: 0.8 s", "type: always, from: 0.25 s, until: @1.5 s",
     "success.of[1].of[1].when.until: value '1.5 s': must be at most the horizon, 1 s"},
    {"LastingLongerThanItsSpan", "duration: 0.1 s", "duration: @0.7 s",
     "success.of[1].of[2].when.duration: value '0.7 s': must fit into the span, 0.65 s"},
    {"LastingBeyondTheEnd", "until: 0.9 s", "until: @1.9 s",
     "success.of[1].of[2].when.until: value '1.9 s': must be at most the horizon, 1 s"},
    {"PolicySeesADrift", "{signal: goal, offset: 1 mm", "{signal: @rope_drift, offset: 1 mm",
     "policy.observations[9].signal: value 'rope_drift': a policy sees the present state alone, and 'rope_drift' looks "
     "at more: drifts, commands, contacts and shapes cannot be observed"},
    {"PolicySeesACommand", "{signal: swivel_up, offset: 0.1", "{signal: @slider_command, offset: 0.1",
     "policy.observations[6].signal: value 'slider_command': a policy sees the present state alone, and "
     "'slider_command' looks at more: drifts, commands, contacts and shapes cannot be observed"},
    {"PolicySeesAContact", "{signal: goal, offset: 1 mm", "{signal: @rope_depth, offset: 1 mm",
     "policy.observations[9].signal: value 'rope_depth': a policy sees the present state alone, and 'rope_depth' looks "
     "at "
     "more: drifts, commands, contacts and shapes cannot be observed"},
    {"PolicySeesAShape", "{signal: goal, offset: 1 mm", "{signal: @tool_length, offset: 1 mm",
     "policy.observations[9].signal: value 'tool_length': a policy sees the present state alone, and 'tool_length' "
     "looks at more: drifts, commands, contacts and shapes cannot be observed"},
    {"WeightBoundsSwapped", "lower: -2\n  upper: 2.5", "lower: @2.6\n  upper: 2.5",
     "policy.lower: value '2.6': must be less than upper, 2.5"},
    {"RandomWeightsOutside", "lower: -2\n  upper: 2.5", "lower: @0.5\n  upper: 2.5",
     "policy.lower: value '0.5': random weights lie around 0, and biases begin there: the bounds must enclose it"},
    {"TooManyWeights", "hidden: [4, 3]", "hidden: @[1000, 1000]",
     "policy.hidden: the network has 1013001 weights, at most 400000 are allowed"},
    {"OptimizedTwice", "optimize: [design, control]", "optimize: @[control, control]",
     "learning.optimize: names something twice"},
    {"OursMovesNoControls", "method: simple_continual, optimize: [design, control]",
     "method: ours, optimize: [design, @control]",
     "learning.optimize[1]: value 'control': method ours chooses among design parameters alone; diffhand and "
     "simple_continual move controls"},
    {"OwnParent", "parent: wall", "parent: @hinge",
     "bodies.hinge.parent: value 'hinge': the bodies must form a tree, but here is a cycle: hinge → hinge"},
    {"NoInertia",
     "    joint: {type: free}\n    shapes: [{type: sphere, radius: 1 cm}]\n    inertia: {type: solid, mass: 4.2 g}",
     "    joint: {type: @free}\n    shapes: [{type: sphere, radius: 1 cm}]",
     "bodies.pea.inertia: a body that forces move needs an inertia; only fixed and prescribed ones do without"},
    {"InertiaOfAHalfSpace", "{type: half_space}]\n  - name: tool",
     "{type: half_space}]\n    inertia: {type: @solid, mass: 1 g}\n  - name: tool",
     "bodies.ground.inertia.type: value 'solid': needs shapes with a volume (sphere, capsule, cylinder, box, "
     "designed_mesh or mesh) and no other; else give an explicit inertia"},
    {"RoundingOfABox", "9 mm], rounding: 1 mm", "9 mm], rounding: @5 mm",
     "bodies.brick.shapes[0].rounding: value '5 mm': must be at most half the least size, 0.004 m"},
    {"ImpossibleMoments", "moments: [3e-6 kg*m^2, 3e-6 kg*m^2, 3e-6 kg*m^2]",
     "moments: @[1e-6 kg*m^2, 1e-6 kg*m^2, 3e-6 kg*m^2]",
     "bodies.hinge.inertia.moments: no body has such moments: the principal ones are 9e-07, 1.1e-06 and 3e-06, but "
     "each must be positive and no larger than the sum of the others"},
    {"ZeroAxis", "axis: [1, 1, 0]", "axis: @[0, 0, 0]", "bodies.hinge.joint.axis: must not be zero"},
    {"ContactWithItself", "bodies: [pea, ground]", "bodies: @[pea, pea]",
     "contacts[0].bodies: a contact needs two different bodies"},
    {"ContactTwice", "bodies: [tool, pea]", "bodies: @[ground, pea]",
     "contacts[1].bodies: ground and pea already have a contact, contacts[0]"},
    {"ContactWithoutShape", "bodies: [tool, pea]", "bodies: [tool, @hinge]",
     "contacts[1].bodies[1]: value 'hinge': this body has no shape to touch with"},
    {"DesignedBodyWithoutAMesh",
     "velocity: [1 m/s, 0 m/s, 0 m/s], angular_velocity: [0 rad/s, 0 rad/s, 9 deg/s]}\n    shapes: "
     "[{type: half_space}]",
     "velocity: [1 m/s, 0 m/s, 0 m/s], angular_velocity: [0 rad/s, 0 rad/s, 9 deg/s]}\n    shapes: "
     "[{type: @designed_mesh}]",
     "bodies.wall.shapes[0].type: value 'designed_mesh': needs an entry of design.bodies that gives the mesh"},
    {"DesignOfAnotherBody", "    - name: tool\n      mesh", "    - name: @wall\n      mesh",
     "design.bodies.wall.name: value 'wall': one of the shapes of this body must be of type designed_mesh"},
    {"LowerAboveUpper", "lower: 20 mm", "lower: @60 mm",
     "design.parameters.width.lower: value '60 mm': must be less than upper, 0.056 m"},
    {"InitialOutside", "initial: 44 mm", "initial: @57 mm",
     "design.parameters.width.initial: value '57 mm': must lie from lower, 0.02 m, to upper, 0.056 m"},
    {"VertexTwice", "[4, 5]", "@[4, 4]", "design.bodies.tool.vertex_groups.right.vertices: names a vertex twice"},
    {"IdleParameter", "    - {name: depth",
     "    - {name: @idle, initial: 0 mm, lower: 0 mm, upper: 1 mm}\n    - {name: depth",
     "design.parameters.idle.name: value 'idle': moves no vertex of a cage; see design.bodies"},
    {"FractionOfAStep", "horizon: 1 s", "horizon: @1.001 s",
     "rollout.horizon: value '1.001 s': must be a whole number of steps of 0.002 s"},
    {"StepsWithoutEnd", "horizon: 1 s, step: 2 ms", "horizon: @8589934.792 s, step: 2 ms",
     "rollout.horizon: value '8589934.792 s': these are 4294967396 steps of 0.002 s, at most 1000000 are allowed"},
    {"EvaluationsWithoutEnd",
     "variations: 10, batch: 2, dimensions_per_batch: 1,\n           alpha: 0.2, "
     "learning_rate: 0.5, decay: 0.4, optimizer: LD_MMA, max_evaluations: 7",
     "variations: 10000, batch: 2, dimensions_per_batch: 1,\n           alpha: 0.2, "
     "learning_rate: 0.5, decay: 0.4, optimizer: LD_MMA, max_evaluations: @1000000",
     "learning.max_evaluations: value '1000000': 5000000000 evaluations in all 5000 batches, at most 1000000000 are "
     "allowed"},
    {"TestsWithoutEnd", "{variations: 20, seed: 12}", "{variations: @1000001, seed: 12}",
     "evaluation.variations: value '1000001': must be from 1 to 1e+06"},
    {"NoHeightInTime", "every: 40 ms, from: 80 ms, until: 0.5 s", "every: @40 ms, from: 80 ms, until: 0.1 s",
     "loss.task[1].when.every: value '40 ms': no sample lies between 0.08 s and 0.1 s; one comes every 0.04 s"},
    {"SamplesBetweenSteps", "every: 20 ms", "every: @21 ms",
     "loss.distillation[0].when.every: value '21 ms': must be a whole number of steps of 0.002 s"},
    {"SamplesAfterTheEnd", "every: 20 ms", "every: @2 s",
     "loss.distillation[0].when.every: value '2 s': no sample lies between 0 s and 1 s; one comes every 2 s"},
    {"GapOfARope", "gap: 1 mm", "gap: @30 mm", "ropes.rope.gap: value '30 mm': must be less than the pitch, 0.03 m"},
    {"RoundingOfARope", "rounding: 0.9 mm", "rounding: @5 mm",
     "ropes.rope.rounding: value '5 mm': must be at most half the least size, 0.004 m"},
    {"SteepHelix", "advance: 10 mm", "advance: @300 mm",
     "ropes.rope.initial.advance: value '300 mm': must be less than the links of a turn are long, 0.24 m"},
    {"HeightAfterTheEnd", "every: 40 ms, from: 80 ms, until: 0.5 s", "every: 40 ms, from: 80 ms, until: @2 s",
     "loss.task[1].when.until: value '2 s': must be at most the horizon, 1 s"},
    {"HeightFromAfterItsEnd", "every: 40 ms, from: 80 ms", "every: 40 ms, from: @520 ms",
     "loss.task[1].when.from: value '520 ms': must be less than `until`, 0.5 s"},
    {"HeightFromBetweenSteps", "every: 40 ms, from: 80 ms", "every: 40 ms, from: @81 ms",
     "loss.task[1].when.from: value '81 ms': must be a whole number of steps of 0.002 s"},
    {"RampOfASegment", "ramp: 0.4 s", "ramp: @0.6 s",
     "bodies.hand.joint.motion.segments[0].ramp: value '0.6 s': must be at most half the duration, 0.5 s"},
    {"TurnAboutTwoAxes", "angle: 90 deg, axis: [0, 0, 3]", "angle: @90 deg, axis: [0, 0, 3], tips: [1, 0, 0]",
     "bodies.hand.joint.motion.segments[0].angle: value '90 deg': a turn needs either `axis` or `tips`"},
    {"TurnAboutNoAxis", "angle: 90 deg, axis: [0, 0, 3]", "angle: @90 deg",
     "bodies.hand.joint.motion.segments[0].angle: value '90 deg': a turn needs either `axis` or `tips`"},
    {"LevelInAMovingFrame",
     "  - name: hand\n    joint:\n      type: prescribed\n      motion:\n        type: segments\n        segments:\n   "
     "       - {duration: 1 s, ramp: 0.4 s, shift: [1 cm, 2 cm, 0 cm], angle: 90 deg, axis: [0, 0, 3]}\n          - "
     "{duration: 2 s, ramp: 1 s, angle: 1 rad, tips: [1, 0, 0]}",
     "  - name: hand\n    parent: wall\n    joint:\n      type: prescribed\n      motion:\n        type: segments\n    "
     "    segments:\n          - {duration: 1 s, ramp: 0.4 s, shift: [1 cm, 2 cm, 0 cm], angle: 90 deg, axis: [0, 0, "
     "3]}\n          - {duration: 2 s, ramp: 1 s, angle: 1 rad, tips: @[1, 0, 0]}",
     "bodies.hand.joint.motion.segments[1].tips: what is level is known only where the world carries the joint"},
    {"NoDirectionOfARope", "direction: [0, 2, 0]}", "direction: @[0, 0, 0]}",
     "ropes.cord.initial.direction: must not be zero"},
    {"GripOfItself", "{body: wall, held: pill", "{body: wall, held: @wall",
     "grips[1].held: value 'wall': a body cannot hold itself"},
    {"GripThatNeverHolds", "until: 0.75 s", "until: @0.25 s",
     "grips[0].until: value '0.25 s': must be more than `from`, 0.25 s"},
    {"GripBesideTheRope", "held_point: [50 mm, 1 mm", "held_point: [@70 mm, 1 mm",
     "grips[0].held_point[0]: value '70 mm': must lie on the rope, from 0 m to 0.06 m"},
    {"VariedTwice", "\"contacts[0].friction\", distribution: normal, mean: 0.4, std: 0.05, truncate_at: 2",
     "@\"bodies.pea.initial.position[0]\", distribution: normal, mean: 0 m, std: 1 mm",
     "variation[1].key: value 'bodies.pea.initial.position[0]': already varies, see variation[0]"},
    {"VariationUpsideDown", "lower: -20 mm", "lower: @21 mm",
     "variation[0].lower: value '21 mm': must be at most upper, 0.02 m"},
    {"VariationOutOfRange", "bodies.pea.initial.position[0]\", distribution: uniform, lower: -20 mm",
     "bodies.pea.shapes[0].radius\", distribution: uniform, lower: @-20 mm",
     "variation[0].lower: value '-20 mm': the key must be more than 0 m"},
    {"VariationReachesOut", "std: 0.05", "std: @0.25",
     "variation[1].std: value '0.25': draws reach from -0.09999999999999998 to 0.9, but the key must be from 0 to 10"},
    {"BatchOfTooMany", "batch: 2", "batch: @11", "learning.batch: value '11': a batch has at most all 10 variations"},
    {"TooManyDimensions", "dimensions_per_batch: 1", "dimensions_per_batch: @4",
     "learning.dimensions_per_batch: value '4': must be at most the number of design parameters, 3"},
};

INSTANTIATE_TEST_SUITE_P(All, Contradiction, testing::ValuesIn(kContradictions),
                         [](const auto& the_case) { return std::string(the_case.param.name); });

TEST(CheckScene, BoundsThePairsOfLinksAndTheControls) {
  const EditedScene links = EditScene(kEverythingYaml, "    links: 12\n", "    links: 2000\n");
  const std::string errors = ParseEditedScene(links);
  EXPECT_TRUE(errors.ends_with(": contacts[3].bodies: these are 4000000 pairs of links, at most 1000000 are allowed\n"))
      << errors;
  const std::vector<std::string> overrides{"rollout.horizon=1000 s", "rollout.step=1 ms", "controls.interval=1 ms",
                                           "controls.actuators=[slider]", "policy.interval=1 ms"};
  EXPECT_EQ(ParseScene(kEverythingYaml, "f.yaml", overrides).FormatErrors(),
            "command line: controls.interval=1 ms: controls.interval: value '1 ms': these are 1000000 controls beside "
            "the 63 weights of the policy, at most 400000 are allowed\n");
}

TEST(CheckScene, FindsLongCycles) {
  const EditedScene scene = EditScene(kPendulumYaml, "  - name: upper\n", "  - name: upper\n    parent: @lower\n");
  EXPECT_EQ(ParseEditedScene(scene),
            "f.yaml:" + scene.place +
                ": bodies.upper.parent: value 'lower': the bodies must form a tree, but here is a cycle: upper → lower "
                "→ upper\n"
                "f.yaml:10:13: bodies.lower.parent: value 'upper': the bodies must form a tree, but here is a cycle: "
                "lower → upper → lower\n");
}

TEST(CheckScene, OneDesignParameterNeedsNoCountOfDimensions) {
  const std::vector<std::string> one{
      "design.parameters=[{name: width, initial: 44 mm, lower: 20 mm, upper: 56 mm}]",
      "design.bodies.tool.moves=[{parameter: width, group: left, direction: [1, 0, 0]}]"};
  const std::string given = "dimensions_per_batch: 1,";
  std::string left_out = kEverythingYaml;
  left_out.erase(left_out.find(given), given.size());
  const ParseResult result = ParseScene(left_out, "f.yaml", one);
  EXPECT_EQ(result.FormatErrors(), "");
  EXPECT_EQ(result.scene.learning.dimensions_per_batch, 1);
  EXPECT_EQ(ParseScene(left_out, "f.yaml").scene.learning.dimensions_per_batch, 2);
}

constexpr char kPendulumEnd[] = "rollout: {horizon: 1 s, step: 5 ms, integrator: bdf1}\n";

TEST(CheckScene, WhereNothingVariesThereIsOneRollout) {
  const Scene scene = ParseScene(kPendulumYaml, "f.yaml").scene;
  EXPECT_EQ(scene.learning.variations, 1);
  EXPECT_EQ(scene.learning.batch, 1);
  EXPECT_EQ(scene.evaluation.variations, 1);
  const EditedScene edited =
      EditScene(kPendulumYaml, kPendulumEnd, std::string(kPendulumEnd) + "learning: {variations: @2, batch: 1}\n");
  EXPECT_EQ(ParseEditedScene(edited),
            "f.yaml:" + edited.place +
                ": learning.variations: value '2': the scenario has no section variation, so all rollouts are alike: "
                "must be 1\n");
}

TEST(CheckScene, WhatCostsOrIsOptimisedExists) {
  const EditedScene cost = EditScene(kPendulumYaml, kPendulumEnd,
                                     std::string(kPendulumEnd) +
                                         "signals: [{name: u, type: command, actuator: @upper}]\n"
                                         "loss: {task: [{signals: [u]}]}\n");
  EXPECT_EQ(ParseEditedScene(cost), "f.yaml:" + cost.place +
                                        ": signals.u.actuator: value 'upper': neither controls nor a policy drive this "
                                        "body's joint\n");
  for (const std::string part : {"control", "policy"}) {
    const EditedScene scene =
        EditScene(kPendulumYaml, kPendulumEnd,
                  std::string(kPendulumEnd) + "learning: {method: diffhand, optimize: [@" + part + "]}\n");
    EXPECT_EQ(ParseEditedScene(scene), "f.yaml:" + scene.place + ": learning.optimize[0]: value '" + part +
                                           "': the scenario has no section " +
                                           (part == "control" ? "controls" : "policy") + "\n");
  }
}

// 0.3 s less 0.2 s is less than 0.1 s in binary.
TEST(CheckScene, DecimalTimesFit) {
  EXPECT_EQ(ParseEditedScene(EditScene(kEverythingYaml, "duration: 0.1 s, from: 0.25 s, until: 0.9 s",
                                       "duration: 0.1 s, from: 0.2 s, until: 0.3 s")),
            "");
}

// What a signal is made of counts as much as the signal.
TEST(CheckScene, MadeOfAContactLooksAtAContact) {
  const std::string made = EditScene(kEverythingYaml, "of: [away, nearest]", "of: [away, rope_depth]").text;
  const EditedScene seen = EditScene(made, "{signal: goal, offset: 1 mm", "{signal: @farthest, offset: 1 mm");
  EXPECT_EQ(ParseEditedScene(seen),
            "f.yaml:" + seen.place +
                ": policy.observations[9].signal: value 'farthest': a policy sees the present "
                "state alone, and 'farthest' looks at more: drifts, commands, contacts and shapes "
                "cannot be observed\n");
}

// The longest of at most 4 ms of which every time that has to be a whole number of steps is one.
TEST(CheckScene, AStepLeftOutFitsEveryTime) {
  const auto choose = [](const std::string& since, const std::string& every, const std::string& at,
                         const std::string& success_at) {
    const std::string text =
        EditScene(kPendulumYaml, kPendulumEnd,
                  "rollout: {horizon: 1.2 s}\n"
                  "signals: [{name: a, type: angle, joint: upper}, {name: d, type: drift, of: [upper], since: " +
                      since + "}]\nloss: {task: [{signals: [a], when: {type: samples, every: " + every +
                      ", from: 60 ms}}, {signals: [a], when: {type: at, time: " + at +
                      "}}]}\nsuccess: {type: any, of: [{type: within, signals: [a], when: {type: at, time: " +
                      success_at + "}}]}\n")
            .text;
    const ParseResult result = ParseScene(text, "f.yaml");
    EXPECT_EQ(result.FormatErrors(), "");
    return result.scene.rollout.step;
  };
  EXPECT_DOUBLE_EQ(choose("0 s", "60 ms", "0.6 s", "0.6 s"), 4e-3);
  EXPECT_DOUBLE_EQ(choose("9 ms", "60 ms", "0.6 s", "0.6 s"), 3e-3);
  EXPECT_DOUBLE_EQ(choose("0 s", "10 ms", "0.6 s", "0.6 s"), 10e-3 / 3);
  EXPECT_DOUBLE_EQ(choose("0 s", "60 ms", "7 ms", "0.6 s"), 1e-3);
  EXPECT_DOUBLE_EQ(choose("0 s", "60 ms", "0.6 s", "7.5 ms"), 3.75e-3);
}

TEST(CheckScene, ControlsAloneAreOptimisedByName) {
  const std::string driven =
      EditScene(kPendulumYaml, "damping: 0.1 N*m*s/rad", "@actuator: {type: force, limit: 1 N*m}").text;
  const std::string controls =
      std::string(kPendulumEnd) + "controls: {actuators: [lower], interval: 50 ms}\nlearning: {method: diffhand";
  EXPECT_EQ(ParseEditedScene(EditScene(driven, kPendulumEnd, controls + ", optimize: [control]}\n")), "");
  const EditedScene design = EditScene(driven, kPendulumEnd, controls + ", optimize: [@design]}\n");
  EXPECT_EQ(ParseEditedScene(design),
            "f.yaml:" + design.place +
                ": learning.optimize[0]: value 'design': the scenario has no section design; write optimize: "
                "[control]\n");
}

TEST(CheckScene, ADesignedMeshNeedsADesign) {
  const EditedScene scene = EditScene(kPendulumYaml, "{type: sphere, radius: 20 mm}", "{type: @designed_mesh}");
  EXPECT_EQ(ParseEditedScene(scene),
            "f.yaml:" + scene.place +
                ": bodies.lower.shapes[0].type: value 'designed_mesh': needs a section 'design' "
                "that gives the mesh\n");
}

}  // namespace check_scene_test
}  // namespace knap
