#!/usr/bin/env bash
# tests/cluster/hostile_ends.sh KNAP KNAP_WORKER FAILING_DISK CONFIG [STEP [a.b=c …]]
#
# A learning whose ends are hostile: `knap learn CONFIG` with descriptors 0, 1 and 2 closed in every combination; with
# stdout, stderr and the run directory full from every STEP-th write on (10; FAILING_DISK, made of failing_disk.cc, lets
# them fail where nobody may mount a small disk); with a reader of stderr that goes away; with a run directory that
# becomes read-only; and with a worker that is starved of memory beside a healthy one. Each time there is the theta and
# the test of an undisturbed run, to the last bit, or a line that says what is wrong and a run that goes on to them. The
# bar:
#
#   tests/cluster/hostile_ends.sh build/release/bin/{knap,knap-worker,libknap_failing_disk.so} configs/pushing.yaml 10 \
#     learning.variations=6 learning.batch=3 learning.max_evaluations=3 evaluation.variations=6
set -euo pipefail
knap=$(realpath "$1") knap_worker=$(realpath "$2") failing_disk=$(realpath "$3") config=$(realpath "$4") step=${5:-10}
shift 4
shift $(($# > 0))
overrides=("$@")
folder=$(realpath "$(mktemp -d)")
# A path in LD_PRELOAD ends at the first space.
cp -- "$failing_disk" "$folder/failing_disk.so"
failing_disk=$folder/failing_disk.so
workers=()
finish() {
  for worker in "${workers[@]}"; do kill -9 "$worker" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf -- "$folder"
}
trap finish EXIT
cd -- "$folder"
export ASAN_OPTIONS="${ASAN_OPTIONS-}:verify_asan_link_order=0"

fail() {
  echo "$1"
  if [[ -e err ]]; then tail -n 5 err; fi
  exit 1
}
learn() { "$knap" learn "$config" "${overrides[@]}" --workers 2 "$@"; }
resume() { "$knap" learn --workers 2 --quiet --resume "$1"; }
# What must be the same of two runs: everything in result.json before the counts of rollouts and the time.
read_result() { sed '/"rollouts":/,$d' "$1/result.json"; }
expect_reference() {
  diff <(read_result reference) <(read_result "$2") || fail "$1: not the bits of the undisturbed run"
}
# expect_way_on CASE RUN CODE LINE: what became of `knap learn --out RUN`, which ended with CODE. A failed one has said
# why in a line that holds LINE, has not died of a signal, and goes on where it stopped, or can be begun again.
expect_way_on() {
  local name=$1 run=$2 code=$3 line=$4
  if ((code != 0)); then
    ((code < 126)) || fail "$name: ended with $code"
    grep -q "^knap: .*$line" err || fail "$name: failed with $code and does not say that '$line'"
    if [[ -e $run/config.yaml ]]; then
      resume "$run" 2>err || fail "$name: cannot be resumed"
    else
      learn --out "$run" --quiet 2>err || fail "$name: cannot be begun again"
    fi
  fi
  expect_reference "$name" "$run"
}

learn --out reference --quiet
read_result reference | grep -q '"learned"'

# Only stdout is missed: by the document.
for closed in 0 1 2 01 02 12 012; do
  code=0
  (
    [[ $closed != *2* ]] || exec 2>&-
    [[ $closed != *1* ]] || exec >&-
    [[ $closed != *0* ]] || exec <&-
    learn --json --out "closed-$closed"
  ) >out 2>err || code=$?
  expected=$([[ $closed == *1* ]] && echo 1 || echo 0)
  ((code == expected)) || fail "descriptors $closed closed: ended with $code"
  expect_reference "descriptors $closed closed" "closed-$closed"
  if [[ $closed == 1* || $closed == 01 ]]; then
    [[ $closed == *2* ]] || grep -q '^knap: .*stdout' err || fail "descriptors $closed closed: does not say so"
  fi
  # Nobody has written into the journal but the journal.
  resume "closed-$closed" 2>err || fail "descriptors $closed closed: cannot be resumed"
  expect_reference "descriptors $closed closed, resumed" "closed-$closed"
done
echo "descriptors 0, 1 and 2 closed in every combination: the same bits"

# full_from TARGET N COMMAND…: what a process writes to TARGET fails from its N-th write on.
full_from() {
  local target=$1 number=$2
  shift 2
  rm -f note
  LD_PRELOAD=$failing_disk KNAP_FULL=$target KNAP_FULL_FROM=$number KNAP_FULL_NOTE=$folder/note "$@"
}
for target in 1 2 run; do
  cases=0 failed=0
  for ((n = 1; ; n += step)); do
    run=full-$target-$n code=0 descriptor=$target
    [[ $target != run ]] || descriptor=$folder/$run
    full_from "$descriptor" "$n" "$knap" learn "$config" "${overrides[@]}" --workers 2 --json --out "$run" >out 2>err ||
      code=$?
    [[ -e note ]] || break
    case $target in
      1) ((code == 1)) || fail "stdout full from write $n on: ended with $code" ;;
      2) ((code == 0)) || fail "stderr full from write $n on: ended with $code" ;;
    esac
    expect_way_on "$target full from write $n on" "$run" "$code" 'No space left on device'
    cases=$((cases + 1)) failed=$((failed + (code != 0)))
  done
  [[ $target != 2 ]] || grep -q progress_dropped "full-2-1/events.jsonl" || fail "nothing tells of dropped progress"
  ((code == 0 && cases > 0)) || fail "$target: $cases cases, the last ended with $code"
  echo "$target full from every ${step}th write on: $cases cases, $failed of them failed and went on to the same bits"
done

# A reader that has gone away is no reason to stop either.
code=$({ learn --out gone 2>&1 >/dev/null || echo $? >gone.code; } | true && cat gone.code 2>/dev/null || echo 0)
((code == 0)) || fail "the reader of stderr gone: ended with $code"
expect_reference "the reader of stderr gone" gone

# A run directory that becomes read-only can be read, and goes on when it can be written again.
cp -r reference read-only
rm read-only/result.json
head -c $(($(stat -c %s reference/journal) / 2)) reference/journal >read-only/journal
code=0
LD_PRELOAD=$failing_disk KNAP_READ_ONLY=$folder/read-only "$knap" learn --quiet --workers 2 --resume read-only 2>err ||
  code=$?
((code == 1)) || fail "a read-only run: ended with $code"
expect_way_on "a read-only run" read-only "$code" 'Read-only file system'
LD_PRELOAD=$failing_disk KNAP_READ_ONLY=$folder/read-only "$knap" evaluate read-only --quiet --workers 1 >out 2>err ||
  fail "a read-only run cannot be evaluated"

# A disk without symbolic links has no runs/latest, and a run all the same.
LD_PRELOAD=$failing_disk KNAP_NO_LINKS=1 "$knap" learn "$config" "${overrides[@]}" --workers 2 2>err ||
  fail "a disk without links: ended with $?"
grep -q 'runs/latest' err || fail "a disk without links: nothing tells that runs/latest is missing"
(($(find runs -mindepth 1 -maxdepth 1 | wc -l) == 1)) || fail "a disk without links: something else is left in runs/"
mv runs/* without-links
expect_reference "a disk without links" without-links
echo "a run without a reader, a read-only one, and one on a disk without links: the same bits"

# Workers with more and more memory beside a healthy one: the fewest kilobytes do not let a worker start, and the most
# are enough. Whatever one lacks, it leaves, it is not killed by a signal, and the healthy one does the work.
(umask 077 && head -c 32 /dev/urandom >key)
port=$((20000 + $$ % 11900))
url="udpm://239.255.76.67:$port?ttl=0"
start_worker() { # NAME [KILOBYTES]
  (
    ulimit -v "${2:-unlimited}"
    exec "$knap_worker" --lcm-url "$url" --key key --name "$1" 2>>workers.log
  ) &
  workers+=($!)
}
for kilobytes in $(seq 40000 $((1000 * step)) 200000); do
  code=0
  start_worker healthy
  start_worker starved "$kilobytes"
  "$knap" learn "$config" "${overrides[@]}" --external --lcm-url "$url" --key key --wait 600 --quiet \
    --out "starved-$kilobytes" 2>err || code=$?
  ((code == 0)) || fail "a worker with $kilobytes kB: the run ended with $code"
  expect_reference "a worker with $kilobytes kB" "starved-$kilobytes"
  for worker in "${workers[@]}"; do
    code=0
    kill "$worker" 2>/dev/null || true  # it may have come when the run was over
    wait "$worker" || code=$?
    ((code < 128 || code == 143)) || fail "a worker with $kilobytes kB: one worker ended with $code"
  done
  workers=()
done
echo "a starved worker beside a healthy one: the same bits"
