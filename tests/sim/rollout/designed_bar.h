// A designed bar, its short rollout, and a loss that sees its corner: what ends the scenes of several tests.
#pragma once

namespace knap::test {

inline constexpr char kDesignedBar[] = R"(design:
  parameters:
    - {name: width, initial: 24 mm, lower: 20 mm, upper: 28 mm}
    - {name: slant, initial: 0 mm, lower: -1 mm, upper: 1 mm}
  bodies:
    - name: tool
      mesh: tool.obj
      cage: cage.obj
      mesh_unit: 1 mm
      vertex_groups:
        - {name: right, vertices: [1, 3, 5, 7]}
        - {name: lower_right, vertices: [1, 3]}
      moves:
        - {parameter: width, group: right, direction: [1, 0, 0]}
        - {parameter: slant, group: lower_right, direction: [0, 0, 1]}
rollout: {horizon: 60 ms, step: 1 ms, integrator: bdf2, newton_tolerance: 1e-12}
signals:
  - {name: off, type: distance, body: tool, point: [6 mm, 1 mm, 0 mm], targets: [{position: [0 m, 0 m, 0 m]}]}
loss: {task: [{signals: [off], shape: absolute}]}
)";

}  // namespace knap::test
