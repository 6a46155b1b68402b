#!/usr/bin/env bash
# tests/cluster/external_workers.sh KNAP KNAP_WORKER CONFIG [KNAP_RELAY]
#
# Three workers started by hand, `knap learn --external`, one worker killed for good while it learns: the learned theta
# has the same bits as that of one local worker. The other two are held until the one has answered and the coordinator
# has noticed its loss, so that it does answer however little it gets of a busy machine, and a fast run cannot end
# before. With KNAP_RELAY they talk over tcpq:// through it, and it too is killed and started
# again in the middle.
set -euo pipefail
knap=$1 knap_worker=$2 config=$3 knap_relay=${4-}
folder=$(mktemp -d)
children=()
finish() {
  for child in "${children[@]}"; do kill -9 "$child" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf -- "$folder"
}
trap finish EXIT
cd -- "$folder"

overrides=("rollout.horizon=2 s" "rollout.step=2 ms" learning.variations=8 learning.batch=4
  learning.max_evaluations=4 evaluation.variations=6)
if [[ $knap_relay ]]; then
  "$knap_relay" --port 0 2>relay.log &
  relay=$!
  children+=("$relay")
  until grep -q listening relay.log; do
    kill -0 "$relay" || { cat relay.log && exit 1; }
    sleep 0.02
  done
  url=$(sed -n 's/.*listening at //p' relay.log)
else
  # A group of its own among 65,536: another suite on this machine has another bus.
  url="udpm://239.255.$((RANDOM % 256)).$((RANDOM % 256)):$((20000 + RANDOM % 12000))?ttl=0"
fi
(umask 077 && head -c 32 /dev/urandom >key)
for name in first second mortal; do
  "$knap_worker" --lcm-url "$url" --key key --name "$name" &
  children+=($!)
done
mortal=$!
others=("${children[@]: -3:2}")

"$knap" learn "$config" "${overrides[@]}" --out reference --workers 1 --quiet

kill -STOP "${others[@]}"
"$knap" learn "$config" "${overrides[@]}" --out external --external --lcm-url "$url" --key key --wait 600 --quiet &
learning=$!
children+=("$learning")
# Killed as soon as it has answered something.
until grep -q ,mortal, external/rollouts.csv 2>/dev/null; do
  kill -0 "$learning" || { echo "the run ended before the worker 'mortal' answered"; exit 1; }
  sleep 0.02
done
kill -9 "$mortal"
if [[ $knap_relay ]]; then
  kill -9 "$relay"
  wait "$relay" || true
  "$knap_relay" --port "${url##*:}" &
  children+=($!)
fi
until grep -q '"event":"workers_lost"' external/events.jsonl; do
  kill -0 "$learning" || { echo "the run ended before it noticed the loss of the worker 'mortal'"; exit 1; }
  sleep 0.02
done
kill -CONT "${others[@]}"
wait "$learning"

# theta.learned is the one list in result.json with this name.
read_theta() { sed -n '/"learned": \[/,/\]/p' "$1/result.json"; }
test -n "$(read_theta reference)"
if [[ "$(read_theta reference)" != "$(read_theta external)" ]]; then
  echo "the learned theta differs:"
  read_theta reference
  read_theta external
  exit 1
fi
cut -d, -f4 external/rollouts.csv | sort | uniq -c
# The run has told the others to stop.
for worker in "${others[@]}"; do wait "$worker"; done
"$knap_worker" --lcm-url "$url" --key key --name fourth &
fourth=$!
children+=("$fourth")
"$knap" evaluate external --external --lcm-url "$url" --key key --wait 600 --quiet
wait "$fourth"
