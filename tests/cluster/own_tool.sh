#!/usr/bin/env bash
# tests/cluster/own_tool.sh KNAP [LEARNING_KEY=VALUE…]
#
# From TOOL.stl to a learned and sliced tool, as docs/tutorial.md tells it, for three meshes: a plate, a spatula and a
# hook. Each gets a cage by `knap cage`, sweeps a ball that lies anywhere in front of it, and learns to bring it to one
# place of its face. The learned one is better on variations it never saw, and PrusaSlicer slices it.
# Exits with 77 where prusa-slicer is not installed.
set -euo pipefail
knap=$(realpath "$1")
shift
if ! command -v prusa-slicer >/dev/null; then
  echo "SKIPPED: prusa-slicer is not installed; a learned tool is not sliced"
  exit 77
fi
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT
cd -- "$folder"
python3 "$here/make_own_tools.py" .

# scenario TOOL SHIFT BALL KEY LOWER UPPER AXIS TARGET: all of it but the design, which knap cage writes.
scenario() {
  cat <<YAML
schema: 2
name: own_$1
bodies:
  - {name: table, joint: {type: fixed}, shapes: [{type: half_space}]}
  - name: tool
    joint:
      type: prescribed
      motion: {type: segments, segments: [{duration: 2.5 s, ramp: 0.4 s, shift: $2}]}
    shapes: [{type: designed_mesh}]
  - name: ball
    joint: {type: free}
    shapes: [{type: sphere, radius: 7 mm}]
    inertia: {type: solid, mass: 4 g}
    initial: {position: $3}
contacts:
  - {bodies: [ball, table], stiffness: 3e7 N/m^3, damping: 10 s/m, friction: 0.4, rolling_resistance: 0.05,
     slip_speed: 1 mm/s}
  - {bodies: [ball, tool], stiffness: 3e7 N/m^3, damping: 10 s/m, friction: 0.1, slip_speed: 1 mm/s}
variation:
  - {key: "bodies.ball.initial.position[$4]", distribution: uniform, lower: $5, upper: $6}
rollout: {horizon: 2.6 s, tolerance: 1e-2}
signals:
  - {name: along, type: position, body: ball, in: tool, axis: $7}
loss:
  task: [{signals: [along], target: {type: number, value: $8}, scale: 10 mm, shape: log}]
  distillation: [{signals: [along], target: {type: reference}, scale: 10 mm}]
success: {type: within, signals: [along], above: ${9}, below: ${10}}
learning: {variations: 30, learning_rate: 0.5}
YAML
}

# keep NAMES FILE: drops all other parameters of a design, and their moves, as a person would.
keep() { awk -v names="^($1)$" '
  /^    - \{name: [a-z_0-9]+, initial/ { name = $3; sub(/,/, "", name); if (name !~ names) next }
  /\{parameter: / { name = $3; sub(/,/, "", name); if (name !~ names) next }
  { print }' "$2"; }

# try TOOL AXIS STATIONS SHAPE NAMES, and the scenario's text on stdin.
try() {
  local tool=$1 begun=$SECONDS
  "$knap" cage "$tool.stl" --axis "$2" --stations "$3" --shape "$4" --picture "$tool.svg" >"$tool.design"
  { cat; keep "$5" "$tool.design"; } >"$tool.yaml"
  grep -q '</svg>' "$tool.svg"
  "$knap" validate "$tool.yaml" >"$tool.validated"
  "$knap" learn "$tool.yaml" "${overrides[@]}" --workers 2 --out "run_$tool" --quiet
  "$knap" export "run_$tool" --format 3mf --out "$tool.3mf" >"$tool.exported"
  # It says how it went in what it writes, not in its exit code.
  timeout 300 prusa-slicer --export-gcode "$tool.3mf" --output "$tool.gcode" \
    --bed-shape 0x0,250x0,250x210,0x210 >/dev/null 2>&1 || true
  python3 - "run_$tool/result.json" "$tool" "$tool.gcode" "$((SECONDS - begun))" <<'PY'
import json, sys
test = json.load(open(sys.argv[1]))["test"]
before, after = test["initial"], test["learned"]
layers = open(sys.argv[3]).read().count(";LAYER_CHANGE\n")
print(f"{sys.argv[2]}: mean loss {before['loss_mean']:.3f} -> {after['loss_mean']:.3f}, success "
      f"{100 * before['success_rate']:.0f}% -> {100 * after['success_rate']:.0f}%, {layers} layers, {sys.argv[4]} s")
if not after["loss_mean"] < before["loss_mean"]:
    sys.exit("the learned tool is no better")
if layers < 10:
    sys.exit("it was not sliced")
PY
}

overrides=("$@")
scenario plate "[0 mm, 200 mm, 0 mm]" "[0 mm, 30 mm, 7 mm]" 0 "-28 mm" "28 mm" x "0 mm" "-6 mm" "6 mm" |
  try plate x 5 box 'offset_[1-5]_y'
scenario spatula "[200 mm, 0 mm, 0 mm]" "[36 mm, 32 mm, 7 mm]" 1 "12 mm" "52 mm" y "32 mm" "26 mm" "38 mm" |
  try spatula y 7 fitted 'offset_[4-7]_x'
scenario hook "[0 mm, -200 mm, 0 mm]" "[40 mm, 40 mm, 7 mm]" 0 "24 mm" "60 mm" x "40 mm" "34 mm" "46 mm" |
  try hook x 5 fitted 'offset_[2-5]_y'
