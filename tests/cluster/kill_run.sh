#!/usr/bin/env bash
# tests/cluster/kill_run.sh [--workers N] [--draw D] [CONFIG [a.b=c …]]
#
# The promise at full size: `knap learn CONFIG --seed 0` with 1, 2 and 4 workers, and with N (2) workers of which one is
# killed with kill -9 every two seconds; the random numbers that choose it begin at D (1). Prints a line a run, and
# fails unless theta.learned has the same bits in all four. CONFIG is configs/pushing.yaml unless given. Builds nothing.
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/../../cmake/setup.sh"

usage() {
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
}
stormy_workers=2
draw=1
arguments=("$@")
while [[ ${1-} == -* ]]; do
  case $1 in
    --workers) stormy_workers=$2 && shift 2 ;;
    --draw) draw=$2 && shift 2 ;;
    -h | --help) usage && exit 0 ;;
    *) usage >&2 && exit 2 ;;
  esac
done
knap=$knap_root/build/release/bin/knap
if [[ ! -x $knap ]]; then
  say "$knap does not exist; ./run.sh builds it"
  exit 2
fi
if ! has_multicast_route && has_private_network; then
  in_private_network "${BASH_SOURCE[0]}" "${arguments[@]}"
  exit
fi
(($#)) || set -- "$knap_root/configs/pushing.yaml"

runs=$(mktemp -d)
learning=
finish() {
  if [[ -n $learning ]]; then kill "$learning" 2>/dev/null || true; fi
  wait
  rm -rf -- "$runs"
}
trap finish EXIT

# theta.learned is the one list in result.json with this name; the text of a number is the shortest with its bits.
read_theta() { sed -n '/"learned": \[/,/\]/p' "$runs/$1/result.json"; }

# report NAME KILLED: what result.json and events.jsonl say of the run.
report() {
  local json=$runs/$1/result.json restarts figures
  restarts=$(sed -n 's/.*"event":"workers_restarted".*"total":\([0-9]*\).*/\1/p' "$runs/$1/events.jsonl" | tail -1)
  figures=$(sed -nE 's/^ *"(total|distinct|reissued|wall_s)": ([0-9.]+),?$/\1 \2/p' "$json" | paste -sd ' ')
  printf '%-8s killed %-3s restarted %-3s %s  theta %.16s\n' "$1" "$2" "${restarts:-0}" "$figures" \
    "$(read_theta "$1" | sha256sum)"
}

for workers in 1 2 4; do
  "$knap" learn "$@" --seed 0 --workers "$workers" --out "$runs/$workers" --quiet
  report "$workers" 0
done

"$knap" learn "$@" --seed 0 --workers "$stormy_workers" --out "$runs/stormy" --quiet &
learning=$!
RANDOM=$draw
killed=0
while sleep 2 && kill -0 "$learning" 2>/dev/null; do
  mapfile -t alive < <(pgrep --parent "$learning" --exact knap-worker)
  if ((${#alive[@]} > 0)) && kill -9 "${alive[RANDOM % ${#alive[@]}]}" 2>/dev/null; then
    killed=$((killed + 1))
  fi
done
wait "$learning"
learning=
report stormy "$killed"

if ((killed == 0)); then
  say "the run ended before a worker could be killed: give it more to learn"
  exit 1
fi
test -n "$(read_theta 1)"
for run in 2 4 stormy; do
  if [[ "$(read_theta "$run")" != "$(read_theta 1)" ]]; then
    say "theta.learned differs between one worker and '$run':"
    diff <(read_theta 1) <(read_theta "$run") >&2
    exit 1
  fi
done
say "theta.learned has the same bits in all four runs"
