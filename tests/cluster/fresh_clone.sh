#!/usr/bin/env bash
# tests/cluster/fresh_clone.sh [knap learn args…]
#
# What a new user does: clones HEAD into a temporary folder (with a blank in its name), runs ./run.sh with the given
# arguments and then ./test.sh there, and prints how long each took. The folder is removed when all went well.
# Example, a small run: tests/cluster/fresh_clone.sh configs/pushing.yaml learning.variations=10
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
clone="$(mktemp -d)/fresh clone"

timed() {
  local name=$1 start=$EPOCHREALTIME
  shift
  echo "== $name: $*"
  "$@" || { echo "fresh_clone.sh: $name failed; it is left in $clone" >&2 && exit 1; }
  timings+=("$(awk -v a="$start" -v b="$EPOCHREALTIME" -v name="$name" 'BEGIN {printf "%-6s %8.1f s", name, b - a}')")
}

timings=()
# --no-local copies objects as a remote would; an alternate or hard link could hide what is not committed.
timed clone git clone --quiet --no-local "$root" "$clone"
cd -- "$clone"
echo "== $(git log -1 --format='%h %s')"
timed run ./run.sh "$@"
timed test ./test.sh
printf '%s\n' "${timings[@]}"
cd / && rm -rf -- "$(dirname -- "$clone")"
