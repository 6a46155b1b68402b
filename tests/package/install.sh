#!/usr/bin/env bash
# tests/package/install.sh BUILD
#
# Installs what BUILD has built, into a folder with a space; the programs run from there, another project finds the
# package and gets the bits of `knap rollout`, and nothing installed names the tree it came from.
set -euo pipefail

build=$(realpath "$1") here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
prefix="$work/a prefix"
cmake --install "$build" --prefix "$prefix" >/dev/null

knap="$prefix/bin/knap" config="$prefix/share/knap/configs/pushing.yaml"
cd -- "$work"
"$knap" --version
"$knap" learn "$config" --out run --workers 2 --quiet learning.variations=4 learning.batch=2 \
  learning.max_evaluations=2 evaluation.variations=4
test -s run/tool/learned.stl

cmake -S "$here/consumer" -B consumer -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release >configure.log ||
  { cat configure.log; exit 1; }
cmake --build consumer >build.log || { cat build.log; exit 1; }
consumer/consumer "$config" >theirs
"$knap" rollout "$config" --variation-values 0,0.09 --json |
  python3 -c 'import json, sys
rollout = json.load(sys.stdin)
for number in (rollout["loss"], *rollout["gradient"].values()): print("%.17g" % number)' >ours
diff theirs ours

# shellcheck source=/dev/null  # installed just now
source "$prefix/share/bash-completion/completions/knap"
complete_line() {
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  _knap
  echo "${COMPREPLY[*]}"
}
[[ $(complete_line "$knap" lea) == learn ]]
[[ $(complete_line "$knap" learn --resu) == --resume ]]

for page in "$prefix"/share/man/man1/*.1; do
  if command -v man >/dev/null; then MANWIDTH=80 man --warnings -E UTF-8 -l "$page" 2>&1 >/dev/null | tee warnings; fi
  [[ ! -s warnings ]]
done
if grep -rlF -- "$(realpath "$here/../..")" "$prefix/lib" "$prefix/share" "$prefix/include"; then
  echo "the files above name the tree that they were built from"
  exit 1
fi
