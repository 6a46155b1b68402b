#!/usr/bin/env bash
# tests/cluster/slurm_workers.sh KNAP KNAP_WORKER KNAP_RELAY JOB_SCRIPT CONFIG
#
# A Slurm cluster of three one-core nodes on this machine (munged, slurmctld and three slurmd as ordinary processes, no
# systemd): workers started by sbatch learn over tcpq, one of them is requeued by Slurm in the middle, and the learned
# theta has the same bits as that of one local worker. Exits with 77 where Slurm is not installed.
set -euo pipefail
PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch scontrol; do
  if ! command -v "$program" >/dev/null; then
    echo "SKIPPED: $program is not installed (packages munge slurmctld slurmd slurm-client); Slurm is not tested"
    exit 77
  fi
done
if [[ $(cat /proc/self/setgroups 2>/dev/null) == deny ]]; then
  echo "SKIPPED: this user namespace forbids supplementary groups, without which Slurm does not start; run as root"
  exit 77
fi
if ! getent ahosts "$(hostname -s)" >/dev/null; then
  echo "SKIPPED: this machine's name, $(hostname -s), has no address (/etc/hosts), without which Slurm does not start"
  exit 77
fi
if ! mountpoint -q /sys/fs/cgroup; then
  echo "SKIPPED: no cgroups at /sys/fs/cgroup, without which Slurm does not start"
  exit 77
fi
# Slurm resolves addresses only where one beyond the loopback's exists, so it gets a network of its own if it may.
if [[ ${KNAP_SLURM_INSIDE-} != yes ]]; then
  unshare=(unshare --net --mount --pid --fork --kill-child --mount-proc)
  if ((EUID == 0)) && "${unshare[@]}" -- ip link add slurm0 type veth peer name slurm1 2>/dev/null; then
    exec env KNAP_SLURM_INSIDE=yes "${unshare[@]}" -- "$0" "$@"
  fi
  if [[ -z $(ip -o addr show up scope global) ]]; then
    echo "SKIPPED: no address but the loopback's, and no network of its own may be made; Slurm would not start"
    exit 77
  fi
else
  ip link set lo up
  ip route add 224.0.0.0/4 dev lo
  ip link add slurm0 type veth peer name slurm1
  ip addr add 10.76.68.1/24 dev slurm0
  ip link set slurm0 up
fi
knap=$1 knap_worker=$2 knap_relay=$3 job_script=$4 config=$5
folder=$(mktemp -d)
chmod 755 "$folder"  # munged wants a folder that others cannot write to
children=()
no_jobs() { [[ -z $(timeout 5 squeue --noheader) ]]; }
finish() {
  timeout 5 scancel --user "$(id -un)" 2>/dev/null || true
  for ((i = 0; i < 50; ++i)); do
    if no_jobs; then break; fi
    sleep 0.1
  done
  for child in "${children[@]}"; do kill -9 "$child" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf -- "$folder"
}
trap finish EXIT
cd -- "$folder"

# wait_until SECONDS WHAT COMMAND…
wait_until() {
  local end=$((SECONDS + $1)) what=$2
  shift 2
  until "$@" >/dev/null 2>&1; do
    if ((SECONDS >= end)); then
      echo "$what: not within the time; the logs say:"
      tail -n 5 -- *.log || true
      exit 1
    fi
    sleep 0.1
  done
}

port=$((20000 + RANDOM % 12000))
user=$(id -un) host=$(hostname -s)
mkdir state
(umask 077 && head -c 1024 /dev/urandom >munge.key && head -c 32 /dev/urandom >key)
cat >slurm.conf <<END
ClusterName=knap
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
SlurmctldPort=$port
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool-%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd-%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
KillWait=5
NodeName=n[1-3] NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1))-$((port + 3)) CPUs=1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$folder/slurm.conf
munged --foreground --force --socket "$folder/munge.socket" --key-file "$folder/munge.key" \
  --log-file "$folder/munged.log" --pid-file "$folder/munged.pid" --seed-file "$folder/munge.seed" 2>munged.out &
children+=($!)
wait_until 600 munged test -S munge.socket
slurmctld -D >slurmctld.out 2>&1 &
children+=($!)
for node in n1 n2 n3; do
  slurmd -D -N "$node" >"slurmd-$node.out" 2>&1 &
  children+=($!)
done
all_idle() { [[ $(sinfo --noheader --Node --states=idle | wc -l) == 3 ]]; }
wait_until 600 "three idle nodes" all_idle

"$knap_relay" --port $((port + 4)) &
children+=($!)
url=tcpq://127.0.0.1:$((port + 4))
export KNAP_WORKER=$knap_worker
job=$(sbatch --parsable --array=0-2 "$job_script" "$url" key)

overrides=("rollout.horizon=2 s" "rollout.step=2 ms" learning.variations=8 learning.batch=4
  learning.max_evaluations=4 evaluation.variations=6)
"$knap" learn "$config" "${overrides[@]}" --out reference --workers 1 --quiet
"$knap" learn "$config" "${overrides[@]}" --out slurm --external --lcm-url "$url" --key key --quiet --wait 600 &
learning=$!
children+=("$learning")
wait_until 600 "an answer of the array's task 1" grep -q ",slurm-$job-1," slurm/rollouts.csv
scontrol requeue "${job}_1"
wait "$learning"
scontrol show job "${job}_1" | grep -o 'Restarts=[0-9]*' | grep -qx Restarts=1
grep -o '"event":"workers_[a-z]*"' slurm/events.jsonl | sort | uniq -c || true
cut -d, -f4 slurm/rollouts.csv | sort | uniq -c

# theta.learned is the one list in result.json with this name.
read_theta() { sed -n '/"learned": \[/,/\]/p' "$1/result.json"; }
test -n "$(read_theta reference)"
if [[ $(read_theta reference) != "$(read_theta slurm)" ]]; then
  echo "the learned theta differs:"
  read_theta reference
  read_theta slurm
  exit 1
fi
