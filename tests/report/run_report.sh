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
# Beside itself.
"$knap" report "$run" "$run" --out both.html | grep -q 'both.html'
if command -v -- "$chromium" >/dev/null; then
  python3 -B "$here/check_report.py" "$chromium" both.html --expect comparison,repeat
fi
# Its timeline: a slice a rollout, those of one worker one after the other, and the batches.
"$knap" trace "$run" >/dev/null
python3 - "$run" <<'EOF'
import csv, json, sys
events = json.load(open(f"{sys.argv[1]}/trace.json"))["traceEvents"]
rows = {e["tid"]: e["args"]["name"] for e in events if e["ph"] == "M"}
assert list(rows.values())[0] == "coordinator" and len(rows) == 3, rows
slices = [e for e in events if e["ph"] == "X"]
rollouts = list(csv.DictReader(open(f"{sys.argv[1]}/rollouts.csv")))
told = [e for e in slices if "id" in e["args"]]
assert [(e["args"]["id"], rows[e["tid"]]) for e in told] == [(r["id"], r["worker"]) for r in rollouts]
assert [e["name"] for e in slices if "id" not in e["args"]] == ["batch 1", "batch 2"], slices
assert all(e["dur"] > 0 and e["ts"] >= 0 for e in slices)
EOF
# What has not ended has no report, and says how it goes on.
rm -- "$run/result.json"
if "$knap" report "$run" 2>message; then exit 1; fi
grep -q 'knap learn --resume' message
