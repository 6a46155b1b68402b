#!/usr/bin/env bash
# tests/report/run_report.sh KNAP CONFIG CHROMIUM
#
# What one sees of a real run: a short learning writes its report; every replay has the bits of the run's own answer and
# is, to the precision it is drawn with, the trajectory that `knap rollout` writes; tables of single rollouts agree with
# the summary. Where there is a CHROMIUM the report is used as by a reader. Exits with 77 where there is no Python.
set -euo pipefail

knap=$(realpath "$1") config=$(realpath "$2") chromium=$3
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
if ! command -v python3 >/dev/null; then
  echo "run_report.sh: skipped: there is no python3"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd -- "$work"

run="a run"  # folders have spaces
"$knap" learn "$config" --out "$run" --workers 2 --quiet learning.variations=6 learning.batch=3 \
  learning.max_evaluations=4 evaluation.variations=12
"$knap" evaluate "$run" --workers 2 --quiet --csv learned.csv >/dev/null
for variation in 0 5; do
  for design in initial learned; do
    "$knap" rollout "$run" --theta "$design" --variation "$variation" --trajectory "$design-$variation.csv" >/dev/null
  done
done
python3 -B "$here/compare_report.py" "$run/report.html" learned.csv
rm -- "$run/report.html"
"$knap" report "$run" --quiet | grep -q 'open it in a browser'
python3 -B "$here/compare_report.py" "$run/report.html" learned.csv
if command -v -- "$chromium" >/dev/null; then
  python3 -B "$here/check_report.py" "$chromium" "$run/report.html" \
    --expect replay,map,shape,learning,certificates,timeline,repeat
fi
# What has not ended has no report, and says how it goes on.
rm -- "$run/result.json"
if "$knap" report "$run" 2>message; then exit 1; fi
grep -q 'knap learn --resume' message
