#!/usr/bin/env bash
# tests/soak.sh [N [ctest args…]]
#
# Builds, and runs the whole suite N times (5), three tests a core at a time, beside two busy loops a core: no test's
# outcome may hang on how fast the machine is. Prints a line a run and a final figure. What a failed run printed is kept
# in build/soak/; exits with 1 if there is one. The arguments choose tests as those of test.sh do.
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/../cmake/setup.sh"

if [[ ${1-} == -h || ${1-} == --help ]]; then
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  exit 0
fi
runs=${1:-5}
shift $(($# > 0))
if ! [[ $runs =~ ^[1-9][0-9]{0,3}$ ]]; then
  say "N is '$runs'; a number from 1 to 9999 is allowed"
  exit 2
fi
build_release all
cd -- "$knap_root"

loops=()
finish() {
  for loop in "${loops[@]}"; do kill "$loop" 2>/dev/null || true; done
  wait 2>/dev/null || true
}
trap finish EXIT
trap 'exit 130' INT TERM
for ((i = 0; i < 2 * $(nproc); ++i)); do
  (while :; do :; done) &
  loops+=($!)
done

run=(ctest --preset release --no-tests=error --parallel $((3 * $(nproc))) "$@")
if has_private_network; then
  run=(in_private_network "${run[@]}")
elif ! has_multicast_route; then
  say "LCM needs a route for multicast and there is none; ./test.sh tells how to get one"
  exit 2
fi
mkdir -p build/soak
failed=0 began=$SECONDS
for ((i = 1; i <= runs; ++i)); do
  log=build/soak/run-$(date -u +%Y%m%dT%H%M%SZ)-$i.log started=$SECONDS
  if "${run[@]}" >"$log" 2>&1; then
    echo "run $i of $runs: passed, $((SECONDS - started)) s"
    rm -- "$log"
  else
    echo "run $i of $runs: failed, $((SECONDS - started)) s, see $log:"
    sed -n '/^The following tests FAILED/,/^Errors/p' "$log"
    failed=$((failed + 1))
  fi
done
echo "$((runs - failed)) of $runs runs passed beside ${#loops[@]} busy loops on $(nproc) cores, $((SECONDS - began)) s"
((failed == 0))
