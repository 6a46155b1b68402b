#!/usr/bin/env bash
# tests/cluster/spy_screenshot.sh [--jar JAR] [--wait SECONDS] OUT.png COMMAND…
#
# Runs COMMAND… (which must publish to $LCM_DEFAULT_URL) under lcm-spy on a virtual screen, opens every channel by a
# double click on its row, saves a screenshot, and prints a line a channel. Fails if lcm-spy shows no channel.
# Example: tests/cluster/spy_screenshot.sh spy.png build/release/bin/knap learn configs/pushing.yaml --quiet
# Needs the packages xvfb openbox xdotool imagemagick, beside those of lcm-spy; nothing else of knap does.
set -euo pipefail

usage() {
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
}
root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
jars=()
settle_s=8
while [[ ${1-} == -* ]]; do
  case $1 in
    --jar) jars=("$2") && shift 2 ;;
    --wait) settle_s=$2 && shift 2 ;;
    -h | --help) usage && exit 0 ;;
    *) usage >&2 && exit 2 ;;
  esac
done
(($# >= 2)) || { usage >&2 && exit 2; }
picture=$1
shift

for program in Xvfb openbox xdotool import; do
  if ! command -v "$program" >/dev/null; then
    echo "spy_screenshot.sh: $program is missing: sudo apt-get install -y xvfb openbox xdotool imagemagick" >&2
    exit 2
  fi
done

# A group and a port of its own keep other LCM programs of this machine out of the picture.
export LCM_DEFAULT_URL="udpm://239.255.$((RANDOM % 256)).$((RANDOM % 256)):$((20000 + RANDOM % 12000))?ttl=0"
log=$(mktemp -d)
started=()
stop_started() {
  ((${#started[@]} == 0)) || kill "${started[@]}" 2>/dev/null || true
  wait || true
  rm -rf -- "$log"
}
trap stop_started EXIT

# Xvfb picks a free display itself and writes its number.
Xvfb -displayfd 3 -screen 0 1600x1300x24 -nolisten tcp 3>"$log/display" 2>"$log/xvfb" &
started+=($!)
for _ in {1..100}; do
  [[ -s $log/display ]] && break
  sleep 0.1
done
DISPLAY=:$(<"$log/display")
export DISPLAY
openbox >"$log/openbox" 2>&1 &
started+=($!)

"$root/lcmtypes/spy.sh" "$LCM_DEFAULT_URL" "${jars[@]}" >"$log/spy" 2>&1 &
started+=($!)
if ! spy=$(timeout 30 xdotool search --sync --onlyvisible --name '^LCM Spy$' | head -1) || [[ -z $spy ]]; then
  echo "spy_screenshot.sh: lcm-spy opened no window:" >&2
  cat "$log/spy" >&2
  exit 1
fi
"$@" >"$log/command" 2>&1 &
started+=($!)
xdotool windowsize --sync "$spy" 795 295
xdotool windowmove "$spy" 0 0
sleep "$settle_s"  # channels appear as their first messages come

# The rows lie below a header of 18 pixels and are 16 pixels high. A double click opens the channel's window, whose
# title is the channel's name. The screen is a grid of two columns and four lines: the table is its first cell, the
# windows fill the others, and those beyond the eighth pile up on the last.
channel_windows() {
  xdotool search --onlyvisible --class 'lcm-spy' 2>/dev/null | while read -r window; do
    name=$(xdotool getwindowname "$window" 2>/dev/null || true)
    case $name in '' | 'LCM Spy' | 'Content window' | FocusProxy | lcm-spy-Spy) ;; *) echo "$window $name" ;; esac
  done | sort -u
}
seen=
opened=0
for row in {0..13}; do
  xdotool windowactivate --sync "$spy" mousemove --window "$spy" 60 $((18 + 16 * row + 8)) click --repeat 2 --delay 80 1
  fresh=
  for _ in {1..15}; do
    sleep 0.1
    fresh=$(comm -13 <(echo "$seen") <(channel_windows) | head -1)
    [[ -z $fresh ]] || break
  done
  [[ -n $fresh ]] || break
  window=${fresh%% *}
  # Probes of the network: their row tells all, and the room is for the others.
  case ${fresh#* } in
    KNAP_PREFLIGHT | LCM_SELF_TEST)
      xdotool windowclose "$window"
      seen=$(channel_windows)
      continue
      ;;
  esac
  opened=$((opened + 1))
  cell=$((opened < 7 ? opened : 7))
  column=$((cell % 2)) line=$((cell / 2))
  xdotool windowsize --sync "$window" 795 295 windowmove "$window" $((800 * column)) $((325 * line))
  echo "${fresh#* }"
  seen=$(channel_windows)
done
if ((opened == 0)); then
  echo "spy_screenshot.sh: lcm-spy shows no channel; the command printed:" >&2
  cat "$log/command" >&2
  exit 1
fi
sleep 3  # the sparklines need some messages
import -window root "png:$picture"
