#!/usr/bin/env bash
# tests/cluster/datagram_storm.sh KNAP STORM CONFIG [COUNT [RATE]]
#
# `knap learn` in the middle of COUNT random and mutated datagrams, RATE a second, again and again until all are thrown:
# no process dies, strangers' messages are counted, and every run learns the same bits as an undisturbed one.
# The bar of a million: tests/cluster/datagram_storm.sh build/release/bin/knap{,-datagram-storm} configs/pushing.yaml
set -euo pipefail
knap=$(realpath "$1") storm=$(realpath "$2") config=$(realpath "$3") count=${4:-1000000} rate=${5:-20000}
folder=$(mktemp -d)
children=()
finish() {
  for child in "${children[@]}"; do kill "$child" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf -- "$folder"
}
trap finish EXIT
cd -- "$folder"

overrides=("rollout.horizon=2 s" learning.variations=8 learning.batch=4 learning.max_evaluations=4
  evaluation.variations=6)
# A group of its own among 65,536: another suite on this machine has another bus.
url="udpm://239.255.$((RANDOM % 256)).$((RANDOM % 256)):$((20000 + RANDOM % 12000))?ttl=0"
"$knap" learn "$config" "${overrides[@]}" --out calm --workers 2 --quiet

# theta.learned is the one list in result.json with this name.
read_theta() { sed -n '/"learned": \[/,/\]/p' "$1/result.json"; }
test -n "$(read_theta calm)"
runs=0 refused=0
while ((runs == 0)) || kill -0 "$storming" 2>/dev/null; do
  runs=$((runs + 1))
  run=stormy-$runs
  "$knap" learn "$config" "${overrides[@]}" --out "$run" --workers 2 --lcm-url "$url" --quiet &
  learning=$!
  children+=("$learning")
  if ((runs == 1)); then
    # A small storm on a slow build would be over before the first run listens.
    until grep -q local- "$run/rollouts.csv" 2>/dev/null; do
      kill -0 "$learning" || { echo "the run ended before a worker answered"; exit 1; }
      sleep 0.02
    done
    "$storm" "$url" "$count" "$rate" 1 >storm.log &
    storming=$!
    children+=("$storming")
  fi
  wait "$learning"
  if [[ $(read_theta calm) != "$(read_theta "$run")" ]]; then
    echo "the learned theta differs:"
    read_theta calm
    read_theta "$run"
    exit 1
  fi
  if grep '"event":"workers_restarted"' "$run/events.jsonl"; then
    echo "a worker died in the storm; its last lines:"
    tail -n 5 "$run"/workers/*.log
    exit 1
  fi
  if grep -q '"event":"messages_refused"' "$run/events.jsonl"; then refused=$((refused + 1)); fi
done
wait "$storming"
cat storm.log
echo "$runs runs, the same bits in all; $refused of them refused messages"
((refused > 0))
