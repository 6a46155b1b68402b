#!/usr/bin/env bash
# tests/report/many_reports.sh KNAP CHROMIUM CONFIG…
#
# Learns each CONFIG a little and uses its report as a reader would (check_report.py); then a study of the first one,
# in which something must vary.
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
alone=(--quiet)  # where nothing varies: as it is, which takes seconds

for config in "${configs[@]}"; do
  run=$(basename -- "$config" .yaml)
  varies=1
  grep -q '^variation:' "$config" || varies=0
  if ((varies)); then "$knap" learn "$config" --out "$run" "${little[@]}"; else
    "$knap" learn "$config" --out "$run" "${alone[@]}"
  fi
  "$knap" evaluate "$run" --quiet --csv "$run.csv" >/dev/null
  rm -f -- *-*.csv
  for design in initial learned; do
    "$knap" rollout "$run" --theta "$design" --variation 0 --trajectory "$design-0.csv" >/dev/null
    ((!varies)) || "$knap" rollout "$run" --theta "$design" --variation 5 --trajectory "$design-5.csv" >/dev/null
  done
  python3 -B "$here/compare_report.py" "$run/report.html" "$run.csv"
  python3 -B "$here/check_report.py" "$chromium" "$run/report.html" \
    --expect replay,shape,learning,certificates,timeline,repeat"$( ((!varies)) || echo ,map)"
  echo "$run: $(stat -c %s "$run/report.html") bytes, as a reader uses it and with the trajectories of knap rollout"
done
"$knap" study "${configs[0]}" --seeds 2 --out study "${little[@]}"
python3 -B "$here/check_report.py" "$chromium" study/report.html --expect comparison,repeat
echo "study: $(stat -c %s study/report.html) bytes"
