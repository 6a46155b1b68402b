#!/usr/bin/env bash
# tests/report/report_page_test.sh CHROMIUM PAGE_DIR
#
# Assembles reports from made-up runs and uses each as a reader would, in headless Chromium, with and without WebGL.
# Then opens one without each part that a run may lack. Prints a line a check that fails; exits with 1 if there is one,
# with 77 where there is no Chromium or no Python.
set -euo pipefail

chromium=$1 pages=$2
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)

for program in "$chromium" python3; do
  if ! command -v -- "$program" >/dev/null; then
    echo "report_page_test.sh: skipped: there is no $program"
    exit 77
  fi
done

work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT

# The sections that the sample has data for must be there.
all='replay,map,shape,learning,certificates,timeline,repeat'
declare -A expected=([pushing]=$all [rope]=$all [bare]='' [study]='comparison,repeat')
failed=0
for sample in pushing rope bare study; do
  # A name with a space, as folders of runs may have.
  report="$work/$sample report.html"
  python3 -B "$here/make_sample.py" "$sample" >"$work/$sample.json"
  python3 -B "$here/assemble_page.py" "$pages" "$work/$sample.json" >"$report"
  python3 -B "$here/check_report.py" "$chromium" "$report" --expect "${expected[$sample]}" || failed=1
done
python3 -B "$here/check_gaps.py" "$chromium" "$pages" "$work/pushing.json" || failed=1
exit "$failed"
