#!/usr/bin/env bash
# tests/cluster/fault_runs.sh KNAP KNAP_WORKER BRIDGE CONFIG [RUNS [a.b=c …]]
#
# The promise with real processes: `knap learn CONFIG`, RUNS times (20), while everything goes wrong at random. Workers
# and coordinator sit on two buses that BRIDGE (lossy_bridge.cc) joins: 20% of the packets are lost, some come twice or
# late. Of three workers one is killed with kill -9 or stopped with SIGSTOP for up to 3 s, again and again; the
# coordinator is killed with kill -9 and resumed, at most three times a run. Every run must end with the same theta and
# the same test, to the last bit, as an undisturbed one. The bar:
#
#   tests/cluster/fault_runs.sh build/release/bin/knap{,-worker,-lossy-bridge} configs/pushing.yaml 20 \
#     learning.variations=20
set -euo pipefail
knap=$(realpath "$1") knap_worker=$(realpath "$2") bridge=$(realpath "$3") config=$(realpath "$4") runs=${5:-20}
shift 4
shift $(($# > 0))
overrides=("$@")
folder=$(mktemp -d)
workers=() coordinator="" bridging=""
finish() {
  for child in "${workers[@]}" $coordinator $bridging; do kill -9 "$child" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf -- "$folder"
}
trap finish EXIT
cd -- "$folder"
(umask 077 && head -c 32 /dev/urandom >key)

# A group of their own among 65,536: another suite on this machine has other buses.
group=239.255.$((RANDOM % 256)).$((RANDOM % 256)) port=$((20000 + RANDOM % 11900))
coordinators_url="udpm://$group:$port?ttl=0"
workers_url="udpm://$group:$((port + 50))?ttl=0"

start_worker() {
  "$knap_worker" --lcm-url "$workers_url" --key key --name "worker-$1" 2>>workers.log &
  workers[$1]=$!
}
start_coordinator() {
  "$knap" learn "$@" --external --lcm-url "$coordinators_url" --key key --wait 600 --quiet 2>>coordinator.log &
  coordinator=$!
}
# Kills a child and waits until it is gone, without the shell's word on it.
slay() {
  kill -9 "$1" 2>/dev/null || true
  wait "$1" 2>/dev/null || true
}
# What must be the same of two runs: everything in result.json before the counts of rollouts and the time.
read_result() { sed '/"rollouts":/,$d' "$1/result.json"; }

"$knap" learn "$config" "${overrides[@]}" --out calm --workers 2 --quiet
read_result calm | grep -q '"learned"'

all_killed=0 all_stopped=0 all_resumed=0 blows=0
for ((run = 1; run <= runs; ++run)); do
  RANDOM=$run
  began=$SECONDS killed=0 stopped=0 resumed=0
  "$bridge" "$coordinators_url" "$workers_url" "$run" >bridge.log &
  bridging=$!
  for k in 0 1 2; do start_worker "$k"; done
  start_coordinator "$config" "${overrides[@]}" --out "run-$run"
  asleep=() wake_at=()
  until [[ -e run-$run/journal ]]; do
    kill -0 "$coordinator" || { cat coordinator.log && exit 1; }
    sleep 0.01
  done
  next_resume=$((RANDOM % 3)) answers=0 strikes=0
  for ((turn = 0; ; ++turn)); do
    sleep 0.05
    if ! kill -0 "$coordinator" 2>/dev/null; then
      wait "$coordinator" && break
      echo "run $run failed:"
      tail -n 5 coordinator.log
      exit 1
    fi
    for k in "${!asleep[@]}"; do
      if ((turn >= wake_at[k])); then
        kill -CONT "${workers[k]}" 2>/dev/null || true  # it had ended before it was put to sleep
        unset "asleep[$k]"
      fi
    done
    # Paced by answers: the run gets on between two blows however slow the machine is, and is hit however fast it is.
    now=$(wc -l <"run-$run/rollouts.csv" 2>/dev/null || echo 0)
    if ((now < answers + 4)); then continue; fi
    answers=$now strikes=$((strikes + 1))
    k=$((RANDOM % 3))
    if ((strikes > next_resume && resumed < 3)); then
      slay "$coordinator"
      start_coordinator --resume "run-$run"
      resumed=$((resumed + 1)) next_resume=$((strikes + 2 + RANDOM % 5))
    elif ((RANDOM % 9 < 5)); then
      # By turns, so that even a short run sees both.
      if ((++blows % 2)); then
        slay "${workers[k]}"
        unset "asleep[$k]"
        start_worker "$k"
        killed=$((killed + 1))
      elif [[ -z ${asleep[k]-} ]]; then
        if kill -STOP "${workers[k]}" 2>/dev/null; then
          asleep[k]=1 wake_at[k]=$((turn + 10 + RANDOM % 50))
          stopped=$((stopped + 1))
        elif ! wait "${workers[k]}"; then
          # One that the coordinator, on its way out, has told to stop ends well; no other may be gone.
          echo "run $run: worker $k has died"
          exit 1
        fi
      fi
    fi
  done
  coordinator=""
  for worker in "${workers[@]}"; do slay "$worker"; done
  workers=()
  kill "$bridging"
  wait "$bridging"
  bridging=""
  echo "run $run: $((SECONDS - began)) s, workers killed $killed, stopped $stopped, coordinator killed $resumed;" \
    "$(cat bridge.log)"
  if ! diff <(read_result calm) <(read_result "run-$run"); then
    echo "run $run did not end like the undisturbed one"
    exit 1
  fi
  all_killed=$((all_killed + killed)) all_stopped=$((all_stopped + stopped)) all_resumed=$((all_resumed + resumed))
done
echo "$runs runs, the same bits of theta and test in all and in an undisturbed one; in all, workers killed" \
  "$all_killed, stopped $all_stopped, coordinators killed $all_resumed"
((all_killed > 0 && all_stopped > 0 && all_resumed > 0))
