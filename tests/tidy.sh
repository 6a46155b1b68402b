#!/usr/bin/env bash
# tests/tidy.sh [ROOT]
#
# The style that a machine can check, over the files that git would commit. Prints a line a violation and then how
# many there are; exits with 1 if there is one, with 77 outside a git work tree.
set -euo pipefail
export LC_ALL=C.UTF-8

cd -- "${1:-$(dirname -- "${BASH_SOURCE[0]}")/..}"
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
  echo "tidy.sh: skipped: git says which files are ours, and it knows no work tree here"
  exit 77
fi
# Tracked and new files, without those that are deleted but not yet committed.
mapfile -t files < <(git ls-files --cached --others --exclude-standard --deduplicate | while IFS= read -r file; do
  if [[ -f $file ]]; then echo "$file"; fi
done)

violations=$(mktemp)
trap 'rm -f -- "$violations"' EXIT

# select_files REGEX [EXCEPT]: the files whose path matches REGEX but not EXCEPT, one a line.
select_files() { printf '%s\n' "${files[@]}" | grep -E -- "$1" | grep -vE -- "${2:-^$}" || true; }

# forbid RULE REGEX FILES…: a violation for each matching line. --with-filename keeps the format for a single file.
forbid() {
  local rule=$1 regex=$2
  shift 2
  (($#)) || return 0
  grep --with-filename -nIP -- "$regex" "$@" | cut -c -160 | sed "s|\$|  <- $rule|" >>"$violations" || true
}

report() { printf '%s  <- %s\n' "$1" "$2" >>"$violations"; }

mapfile -t cpp < <(select_files '\.(h|cc)$')
mapfile -t cmake < <(select_files '(^|/)CMakeLists\.txt$|\.cmake$')
mapfile -t scripts < <(select_files '\.sh$|^\.ci/run$')
mapfile -t python < <(select_files '\.py$')
mapfile -t messages < <(select_files '\.lcm$')
mapfile -t markdown < <(select_files '\.md$')
mapfile -t yaml < <(select_files '\.ya?ml$|^\.clang-|^CMakePresets\.json$')
mapfile -t page < <(select_files '\.(js|css|html)$')
code=("${cpp[@]}" "${cmake[@]}" "${scripts[@]}" "${python[@]}" "${messages[@]}" "${page[@]}")
text=("${code[@]}" "${markdown[@]}" "${yaml[@]}")

# --- Lines ---------------------------------------------------------------------------------------------------------
forbid 'no tabs' '\t' "${text[@]}"
forbid 'no trailing white space' '[ \t\r]+$' "${text[@]}"
forbid 'a merge is finished before it is committed' '^(<{7}|>{7})( |$)' "${text[@]}"
forbid 'at most 120 characters a line' '^.{121}' "${code[@]}"
# The pattern is split so that it does not match itself.
forbid 'open work belongs into an issue' '\b(TO''DO|FIX''ME|XX''X)\b' "${code[@]}" "${markdown[@]}" "${yaml[@]}"
forbid 'list the sources one by one' '\bGLOB(_RECURSE)?\b|aux_source_directory' "${cmake[@]}"
vague='\w*(Manager|Helper|Util|Utils|Utility)\b'
forbid 'a name says what the thing does' "\\b(class|struct|enum class|enum|namespace|using)\\s+$vague" "${cpp[@]}"

# --- Files ---------------------------------------------------------------------------------------------------------
for file in "${files[@]}"; do
  name=${file##*/}
  case $file in
    *.h | *.cc | *.cmake | *.sh | *.py | *.lcm | *.yaml | *.yml)
      # CMake modules are named after what they hold, as CMake's own are.
      if [[ $name != *.cmake && ! $name =~ ^[a-z0-9_]+\.[a-z]+$ ]]; then report "$file" 'snake_case file names'; fi
      ;;
  esac
  case ${name,,} in
    *manager*.* | *helper*.* | util*.* | *_util*.*) report "$file" 'a name says what the thing does' ;;
  esac
done

# One pass over all code: length, and in headers #pragma once and a comment before the first declaration.
awk '
  FNR == 1 { if (file != "") Close(); file = FILENAME; lines = pragma = comment = declared = 0 }
  { lines = FNR }
  /^#pragma once$/ { pragma = 1; next }
  !declared && /^(\/\/|\/\*)/ { comment = 1 }
  !/^(#|namespace|\/\/|$)/ { declared = 1 }
  END { if (file != "") Close() }
  function Close() {
    if (lines >= 600) print file ": " lines " lines  <- fewer than 600 lines a file"
    if (file ~ /\.h$/ && !comment) print file "  <- a header starts with a comment that says what it is"
    if (file ~ /\.h$/ && !pragma) print file "  <- #pragma once"
  }' "${code[@]}" >>"$violations"

# --- Layers (sim/ computes; the schedule and the optimizer see bounded vectors) ------------------------------------
mapfile -t sim < <(select_files '^sim/.*\.(h|cc)$')
mapfile -t schedule < <(select_files '^coordinator/(learning|optimizer)/.*\.(h|cc)$')
mapfile -t programs < <(select_files '^(coordinator|worker|lcmtypes)/.*\.(h|cc)$')
mapfile -t beneath_cli < <(select_files '\.(h|cc)$' '^(coordinator/cli|tests)/')
mapfile -t beyond_optimizer < <(select_files '\.(h|cc)$' '^(coordinator/optimizer|tests)/')
mapfile -t beyond_geometry < <(select_files '\.(h|cc)$' '^(sim/geometry|tests)/')
outer='^#include ([<"]lcm|<(chrono|thread|mutex|ctime)>|"(coordinator|worker)/)'
forbid 'sim/ has no LCM, clock or threads' "$outer" "${sim[@]}"
forbid 'the schedule never includes sim/' '^#include "(sim|worker)/' "${schedule[@]}"
forbid 'only coordinator/cli and its tests include coordinator/cli' '^#include "coordinator/cli/' "${beneath_cli[@]}"
forbid 'only coordinator/optimizer uses NLopt' '^#include <nlopt' "${beyond_optimizer[@]}"
forbid 'programs write with lcmtypes/program/standard_streams.h' \
  '\bfmt::print\(|\bf?printf\(|\bf?puts\(|std::c(out|err)\b' "${programs[@]}"
mapfile -t beyond_bullet < <(select_files '\.(h|cc)$' '^(sim/(geometry|transfer)|tests)/')
forbid 'only sim/geometry and sim/transfer use Bullet' '^#include <(Bullet|LinearMath)' "${beyond_bullet[@]}"
forbid 'only sim/geometry uses assimp' '^#include <assimp' "${beyond_geometry[@]}"

# --- The top level --------------------------------------------------------------------------------------------------
agreed=' CMakeLists.txt CMakePresets.json lcmtypes coordinator worker sim tests configs docs cmake README.md
 CONTRIBUTING.md LICENSE THIRD_PARTY.md .clang-format .clang-tidy .gitignore .gitattributes .ci run.sh test.sh '
printf '%s\n' "${files[@]}" | cut -d/ -f1 | sort -u | while IFS= read -r entry; do
  [[ ${agreed//$'\n'/ } == *" $entry "* ]] || report "$entry" 'not among the agreed entries of the top level'
done

# --- Links in Markdown: relative ones name a file that exists -------------------------------------------------------
for file in "${markdown[@]}"; do
  folder=$(dirname -- "$file")
  # Code blocks hold commands and output, not links.
  # shellcheck disable=SC2016  # the backquotes are Markdown's
  sed '/^ *```/,/^ *```/d' "$file" | grep -oP '\]\(\K[^)\s]+' | while IFS= read -r link; do
    target=${link%%#*}
    case $target in '' | http://* | https://* | mailto:*) continue ;; esac
    [[ -e $folder/$target ]] || report "$file: $link" 'the link leads nowhere'
  done || true
done

sort -u "$violations"
count=$(sort -u "$violations" | wc -l)
echo "tidy: ${#files[@]} files, $count violations"
((count == 0))
