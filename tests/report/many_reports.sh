#!/usr/bin/env bash
# tests/report/many_reports.sh KNAP CHROMIUM CONFIG…
#
# Learns each CONFIG a little and uses its report as a reader would (check_report.py); then a study of the first one.
# What run_report.sh does in the suite for one scenario, for as many as one likes: minutes. Needs multicast.
set -euo pipefail

knap=$(realpath "$1") chromium=$2
shift 2
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
mapfile -t configs < <(realpath "$@")
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd -- "$work"
little=(learning.variations=4 learning.batch=2 learning.max_evaluations=3 evaluation.variations=12 --quiet)

for config in "${configs[@]}"; do
  run=$(basename -- "$config" .yaml)
  "$knap" learn "$config" --out "$run" "${little[@]}"
  "$knap" evaluate "$run" --quiet --csv "$run.csv" >/dev/null
  rm -f -- *-*.csv
  for design in initial learned; do
    "$knap" rollout "$run" --theta "$design" --variation 0 --trajectory "$design-0.csv" >/dev/null
    "$knap" rollout "$run" --theta "$design" --variation 5 --trajectory "$design-5.csv" >/dev/null
  done
  python3 -B "$here/compare_report.py" "$run/report.html" "$run.csv"
  python3 -B "$here/check_report.py" "$chromium" "$run/report.html" \
    --expect replay,map,shape,learning,certificates,timeline,repeat
  echo "$run: $(stat -c %s "$run/report.html") bytes, as a reader uses it and with the trajectories of knap rollout"
done
"$knap" study "${configs[0]}" --seeds 2 --out study "${little[@]}"
python3 -B "$here/check_report.py" "$chromium" study/report.html --expect comparison,repeat
echo "study: $(stat -c %s study/report.html) bytes"
