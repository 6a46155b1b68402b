#!/usr/bin/env bash
# tests/cluster/network_hosts.sh KNAP KNAP_WORKER CONFIG
#
# Three hosts on one LAN: network namespaces on a bridge, each with an address of its own and no other way out. The
# coordinator learns on one with workers on the two others, over udpm with TTL 1, to the same bits as with one worker of
# its own; with TTL 0 no packet leaves a host, so no worker is heard. Exits with 77 where no namespaces may be made.
set -euo pipefail

# Inside namespaces of our own nothing has to be cleaned up, and no name can collide.
if [[ ${KNAP_HOSTS_INSIDE-} != yes ]]; then
  unshare=(unshare --net --mount --pid --fork --kill-child --mount-proc)
  if ((EUID != 0)); then unshare+=(--user --map-root-user); fi
  probe='ip link add bridge0 type bridge && ip link add veth0 type veth peer name veth1 && unshare --net true'
  if ! "${unshare[@]}" -- sh -c "$probe" 2>/dev/null; then
    echo "SKIPPED: this machine lets nobody make network namespaces with a bridge; many hosts are not tested"
    exit 77
  fi
  exec env KNAP_HOSTS_INSIDE=yes "${unshare[@]}" -- "$0" "$@"
fi

knap=$1 knap_worker=$2 config=$3
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT
cd -- "$folder"

ip link set lo up
ip link add bridge0 type bridge mcast_snooping 0
ip link set bridge0 up
hosts=()
for i in 1 2 3; do
  # The host itself says that it is away: from outside, a process about to leave looks as if it had left.
  unshare --net -- sh -c 'touch "$0" && exec sleep infinity' "$folder/host-$i-is-up" &
  pid=$!
  hosts+=("$pid")
  until [[ -e host-$i-is-up ]]; do sleep 0.01; done
  ip link add "port$i" type veth peer name eth0 netns "$pid"
  ip link set "port$i" master bridge0 up
  for command in "link set lo up" "link set eth0 up" "addr add 10.76.67.$i/24 dev eth0" \
    "route add 224.0.0.0/4 dev eth0"; do
    # shellcheck disable=SC2086  # words of one ip command
    nsenter --net="/proc/$pid/ns/net" -- ip $command
  done
done
# Replaces the shell, so that a signal sent to a background job reaches the program.
enter_host() {
  local pid=${hosts[$1]}
  shift
  exec nsenter --net="/proc/$pid/ns/net" -- "$@"
}
on_host() { (enter_host "$@"); }

overrides=("rollout.horizon=2 s" learning.variations=8 learning.batch=4 learning.max_evaluations=4
  evaluation.variations=6)
far='udpm://239.255.76.67:7667?ttl=1' near='udpm://239.255.76.67:7667?ttl=0'
(umask 077 && head -c 32 /dev/urandom >key)
workers=()
for host in 1 2; do
  enter_host "$host" "$knap_worker" --lcm-url "$far" --key key --name "host-$host" &
  workers+=($!)
done
on_host 0 "$knap" learn "$config" "${overrides[@]}" --out reference --workers 1 --quiet
on_host 0 "$knap" learn "$config" "${overrides[@]}" --out hosts --external --lcm-url "$far" --key key --quiet \
  --wait 600

# theta.learned is the one list in result.json with this name.
read_theta() { sed -n '/"learned": \[/,/\]/p' "$1/result.json"; }
test -n "$(read_theta reference)"
if [[ $(read_theta reference) != "$(read_theta hosts)" ]]; then
  echo "the learned theta differs:"
  read_theta reference
  read_theta hosts
  exit 1
fi
for host in 1 2; do
  count=$(grep -c ",host-$host," hosts/rollouts.csv || true)
  echo "host-$host answered $count requests"
  ((count > 0))
done

for worker in "${workers[@]}"; do wait "$worker"; done  # the run has told them to stop
enter_host 1 "$knap_worker" --lcm-url "$near" --key key --name kept-in &
code=0
on_host 0 "$knap" learn "$config" "${overrides[@]}" --out alone --external --lcm-url "$far" --key key --quiet \
  --wait 1.5 || code=$?
if ((code != 4)); then
  echo "with TTL 0 a worker was heard on another host (exit code $code, not 4)"
  exit 1
fi
