// Small scenario files for the tests of the scenario layer.
#pragma once

namespace knap {

// A double pendulum: no design, no contact, nothing that varies.
inline constexpr char kPendulumYaml[] = R"(schema: 2
name: pendulum
bodies:
  - name: upper
    joint: {type: revolute, axis: [0, 1, 0], position: [0 m, 0 m, 1 m]}
    inertia: {type: explicit, mass: 1 kg, center: [0 mm, 0 mm, -100 mm], moments: [2 kg*m^2, 2 kg*m^2, 1 kg*m^2]}
    initial: {angle: 30 deg}
  - name: lower
    parent: upper
    joint: {type: revolute, axis: [0, 1, 0], damping: 0.1 N*m*s/rad}
    shapes: [{type: sphere, radius: 20 mm}]
    inertia: {type: density, density: 1000 kg/m^3}
rollout: {horizon: 1 s, step: 5 ms, integrator: bdf1}
)";

// Everything that a file can hold: each joint, motion, shape, inertia, distribution, signal, term of a
// loss and condition.
inline constexpr char kEverythingYaml[] = R"(schema: 2
name: everything
description: "quotes \" and \\, lines\n, ünïcode: yes"
gravity: [0 m/s^2, 0 m/s^2, -1.62 m/s^2]
gravity_direction: {azimuth: 10 deg, rise: -0.9}
bodies:
  - name: ground
    joint: {type: fixed, position: [0 m, 0 m, -1 m], orientation_rpy: [1 deg, 2 deg, 3 deg]}
    shapes: [{type: half_space}]
  - name: tool
    joint:
      type: prescribed
      motion: {type: zigzag, amplitude: 6 cm, period: 3 s, sharpness: 0.9, forward_speed: 60 mm/s, stop_at: 37 cm}
    shapes: [{type: designed_mesh}]
    inertia: {type: density, density: 1.2 g/cm^3}
  - name: wall
    joint:
      type: prescribed
      motion: {type: constant_velocity, velocity: [1 m/s, 0 m/s, 0 m/s], angular_velocity: [0 rad/s, 0 rad/s, 9 deg/s]}
    shapes: [{type: half_space}]
  - name: hinge
    parent: wall
    joint: {type: revolute, axis: [1, 1, 0], damping: 0.2 N*m*s/rad, stiffness: 0.1 N*m/rad, rest: 5 deg,
            limits: {lower: -90 deg, upper: 90 deg, stiffness: 2 N*m/rad, damping: 0.1 s/rad, width: 1 deg},
            actuator: {type: force, limit: 0.06 N*m}}
    inertia: {type: explicit, mass: 3 g, center: [1 mm, 2 mm, 3 mm],
              moments: [3e-6 kg*m^2, 3e-6 kg*m^2, 3e-6 kg*m^2], products: [1e-7 kg*m^2, 0 kg*m^2, 0 kg*m^2]}
    initial: {angle: 45 deg, rate: 1 rad/s}
  - name: slider
    parent: hinge
    joint: {type: prismatic, axis: [0, 0, 2], damping: 3 N*s/m, stiffness: 4 N/m, rest: 5 mm,
            limits: {lower: -1 cm, upper: 1 cm, stiffness: 200 N/m, damping: 2 s/m, width: 1 mm},
            actuator: {type: position, limit: 5 N, stiffness: 80 N/m, damping: 1 N*s/m, lower: -9 mm, upper: 9 mm}}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {displacement: 3 mm, speed: 1 mm/s}
  - name: swivel
    parent: slider
    joint: {type: ball, damping: 0.1 N*m*s/rad, stiffness: 0.2 N*m/rad, rest_rpy: [1 deg, 2 deg, 3 deg]}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {orientation_rpy: [10 deg, 20 deg, 30 deg], angular_velocity: [1 rad/s, 2 rad/s, 3 rad/s]}
  - name: puck
    joint: {type: planar, linear_damping: 1 N*s/m, angular_damping: 1 N*m*s/rad}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 1 g}
    initial: {position: [1 mm, 2 mm], angle: 3 deg, velocity: [4 mm/s, 5 mm/s], angular_velocity: 6 deg/s}
  - name: brick
    parent: tool
    joint: {type: free, attachment: {point: [1 mm, 2 mm, 3 mm]}}
    shapes: [{type: box, size: [29 mm, 8 mm, 9 mm], rounding: 1 mm, position: [15 mm, 0 mm, 0 mm]}]
    inertia: {type: solid, mass: 1.5 g}
  - name: hand
    joint:
      type: prescribed
      motion:
        type: segments
        segments:
          - {duration: 1 s, ramp: 0.4 s, shift: [1 cm, 2 cm, 0 cm], angle: 90 deg, axis: [0, 0, 3]}
          - {duration: 2 s, ramp: 1 s, angle: 1 rad, tips: [1, 0, 0]}
  - name: pill
    joint: {type: free}
    shapes: [{type: capsule, radius: 4 mm, length: 2 cm, position: [0 mm, 0 mm, 1 cm]}]
    inertia: {type: density, density: 1 g/cm^3}
  - name: pea
    joint: {type: free}
    shapes: [{type: sphere, radius: 1 cm}]
    inertia: {type: solid, mass: 4.2 g}
    initial: {position: [0 mm, 100 mm, 10 mm], orientation_rpy: [1 deg, 2 deg, 3 deg],
              velocity: [1 mm/s, 2 mm/s, 3 mm/s], angular_velocity: [1 rad/s, 2 rad/s, 3 rad/s]}
ropes:
  - name: rope
    links: 12
    pitch: 30 mm
    thickness: 8 mm
    gap: 1 mm
    rounding: 0.9 mm
    link_mass: 1.5 g
    joint_damping: 2e-5 N*m*s/rad
    initial: {type: helix, center: [0 mm, 1 mm, 2 mm], links_per_side: 2, advance: 10 mm}
  - name: cord
    links: 3
    pitch: 20 mm
    thickness: 4 mm
    rounding: 1 mm
    link_mass: 1 g
    initial: {type: straight, start: [0 mm, 0 mm, 30 mm], direction: [0, 2, 0]}
contacts:
  - {bodies: [pea, ground], stiffness: 1.3e8 N/m^3, damping: 2 s/m, friction: 0.4,
     rolling_resistance: 0.03, slip_speed: 2 mm/s, stick_distance: 20 um}
  - {bodies: [tool, pea], stiffness: 1e8 N/m^3}
  - {bodies: [tool, rope], stiffness: 1e8 N/m^3}
  - {bodies: [rope, rope], stiffness: 1e8 N/m^3}
grips:
  - {body: tool, point: [1 mm, 2 mm, 3 mm], held: cord, held_point: [50 mm, 1 mm, 0 mm], stiffness: 200 N/m,
     damping: 0.1 N*s/m, limit: 2 N, from: 0.25 s, until: 0.75 s}
  - {body: wall, held: pill, stiffness: 10 N/m, until: 2 s}
signals:
  - {name: hinge_angle, type: angle, joint: hinge}
  - {name: hinge_rate, type: rate, joint: hinge}
  - {name: slider_shift, type: displacement, joint: slider}
  - {name: slider_speed, type: speed, joint: slider}
  - {name: pea_x, type: position, body: pea, axis: x}
  - {name: pea_y, type: position, body: pea, axis: y}
  - {name: pill_seen, type: position, body: pill, point: [0 mm, 0 mm, 2 cm], in: pea, axis: y}
  - {name: pea_speed, type: velocity, body: pea, point: [1 mm, 0 mm, 0 mm], axis: x}
  - {name: swivel_up, type: direction, body: swivel, of: z, in: slider, axis: y}
  - {name: pea_spin, type: angular_velocity, body: pea, axis: z}
  - {name: pill_error, type: distance, body: pill, point: [0 mm, 0 mm, 1 cm], in: tool,
     targets: [{position: [1 cm, 2 cm, 3 cm]}, {after: 0.5 s, position: [0 m, 0 m, 1 m]}]}
  - {name: center_z, type: center_of_mass, of: [rope, pill], in: wall, axis: z}
  - {name: rope_height, type: height, of: [rope]}
  - {name: rope_drift, type: drift, of: [rope], carried_by: wall, since: 80 ms}
  - {name: rope_depth, type: depth, bodies: [rope, tool]}
  - {name: rope_force, type: force, bodies: [rope, rope]}
  - {name: tool_volume, type: volume, body: tool}
  - {name: tool_length, type: extent, body: tool, axis: y}
  - {name: tool_wall, type: thickness, body: tool, blend: 0.3 mm}
  - {name: slider_command, type: command, actuator: slider}
  - {name: clock, type: time}
  - {name: goal, type: number, key: "signals.pill_error.targets[0].position[0]"}
  - {name: pea_off, type: difference, of: [pea_x, goal]}
  - {name: away, type: norm, of: [pea_off, pea_y]}
  - {name: nearest, type: least, of: [away, pill_error]}
  - {name: farthest, type: largest, of: [away, nearest]}
design:
  parameters:
    - {name: width, initial: 44 mm, lower: 20 mm, upper: 56 mm}
    - {name: depth, initial: 0 mm, lower: -15 mm, upper: 30 mm}
    - {name: height, kind: scale, initial: 1, lower: 0.5, upper: 4}
  bodies:
    - name: tool
      mesh: meshes/tool.obj
      cage: meshes/tool_cage.obj
      mesh_unit: 1 mm
      refine: 2 mm
      vertex_groups:
        - {name: left, vertices: [0, 1, 2, 3]}
        - {name: right, vertices: [4, 5]}
        - {name: front, box: {lower: [-1 m, 0 mm, -1 m], upper: [1 m, 1 cm, 1 m]}}
        - {name: top, plane: {point: [0 mm, 0 mm, 5 mm], normal: [0, 0, 2]}}
      moves:
        - {parameter: width, group: left, direction: [-0.5, 0, 0]}
        - {parameter: width, group: right, direction: [0.5, 0, 0]}
        - {parameter: depth, group: left, direction: [0, 1, 0]}
        - {parameter: height, group: right, direction: [0, 0, 1]}
rollout: {horizon: 1 s, step: 2 ms, integrator: bdf2, newton_tolerance: 1e-9, newton_max_iterations: 20}
loss:
  task:
    - signals: [pea_x]
      when: {type: crossing, signal: pea_y, at: 370 mm, never_cost: 48, never_scale: 4 cm}
      target: {type: number, value: 1 mm}
      margin: 20 mm
      scale: 1 cm
      weight: 2
    - {signals: [rope_drift], when: {type: samples, every: 40 ms, from: 80 ms, until: 0.5 s, reduce: mean}, scale: 1 cm,
       weight: 2}
    - {signals: [slider_command], when: {type: samples, every: 100 ms}, weight: 0.1}
    - {signals: [pill_error], when: {type: samples, every: 10 ms}, shape: absolute, scale: 1 cm, weight: 10}
    - signals: [pea_speed]
      when: {type: at, time: 0.4 s}
      target: {type: schedule, values: [{value: 1 cm/s}, {after: 0.2 s, value: 2 cm/s}, {after: 0.6 s, value: 0 m/s}]}
      shape: log
      side: below
      scale: 3 cm/s
    - {signals: [pea_x, pea_y], target: {type: signal, signal: goal}, shape: saturating, side: above, scale: 4 cm}
  distillation:
    - {signals: [pea_x, pea_y], when: {type: samples, every: 20 ms, reduce: mean}, target: {type: reference},
       scale: 1 cm, weight: 5}
    - signals: [rope_height]
      when: {type: samples, every: 40 ms, until: 0.5 s, reduce: largest}
      target: {type: reference}
      scale: 1 cm
success:
  type: all
  of:
    - {type: within, signals: [pea_x], above: -20 mm, below: 20 mm, when: {type: crossing, signal: pea_y, at: 370 mm}}
    - type: any
      of:
        - {type: within, signals: [rope_depth], above: 0 mm, when: {type: ever, from: 0.5 s, until: 0.7 s}}
        - {type: within, signals: [rope_force], below: 3 N, when: {type: always, from: 0.25 s, until: 0.8 s}}
        - {type: within, signals: [away], below: 1 m,
           when: {type: lasting, duration: 0.1 s, from: 0.25 s, until: 0.9 s}}
        - {type: within, signals: [clock], above: 0.5 s}
    - type: none
      of:
        - {type: within, signals: [swivel_up], below: -0.5, when: {type: at, time: 0.6 s}}
variation:
  - {key: "bodies.pea.initial.position[0]", distribution: uniform, lower: -20 mm, upper: 20 mm}
  - {key: "contacts[0].friction", distribution: normal, mean: 0.4, std: 0.05, truncate_at: 2}
  - {key: "loss.task[0].target.value", distribution: uniform, lower: -1 mm, upper: 1 mm}
controls: {actuators: [slider], interval: 100 ms, squash: none, initial: 0.5, lower: -1, upper: 0.75}
learning: {method: simple_continual, optimize: [design, control], variations: 10, batch: 2, dimensions_per_batch: 1,
           alpha: 0.2, learning_rate: 0.5, decay: 0.4, optimizer: LD_MMA, max_evaluations: 7, seed: 9007199254740991,
           start: [0.04, 1e-3]}
policy:
  actuators: [hinge]
  interval: 100 ms
  observations:
    - {signal: hinge_angle, offset: 10 deg, scale: 90 deg}
    - {signal: hinge_rate, offset: 1 rad/s, scale: 5 rad/s}
    - {signal: slider_shift, offset: 1 mm, scale: 1 cm}
    - {signal: slider_speed, offset: 2 mm/s, scale: 10 cm/s}
    - {signal: pill_seen, offset: 1 cm, scale: 5 cm}
    - {signal: pea_speed, offset: 1 cm/s, scale: 20 cm/s}
    - {signal: swivel_up, offset: 0.1, scale: 2}
    - {signal: pea_spin, offset: 1 rad/s, scale: 9 rad/s}
    - {signal: clock, offset: 0.1 s, scale: 0.5 s}
    - {signal: goal, offset: 1 mm, scale: 10 mm}
  hidden: [4, 3]
  squash: tanh
  initial: {type: random, seed: 3, scale: 0.8}
  lower: -2
  upper: 2.5
gradient: {tolerance: 1e-4, step: 1e-5, flagged: 0.1}
evaluation: {variations: 20, seed: 12}
)";

}  // namespace knap
