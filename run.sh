#!/usr/bin/env bash
# ./run.sh [CONFIG] [args…]
#
# Installs what is missing, builds, and learns: knap learn CONFIG args…
# CONFIG is configs/pushing.yaml unless given; the run directory appears under runs/ of the current directory.
# `build/release/bin/knap learn --help` lists the arguments.
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/cmake/setup.sh"

config=$knap_root/configs/pushing.yaml
case ${1-} in
  -h | --help)
    sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  '' | -*) ;;
  *=*) if [[ -f $1 ]]; then config=$1 && shift; fi ;;
  *) config=$1 && shift ;;
esac

install_missing_packages "${knap_packages[@]}"
build_release bin/knap bin/knap-worker bin/knap-relay knap_types_jar

learn=("$knap_root/build/release/bin/knap" learn "$config" "$@")
if [[ -z ${LCM_DEFAULT_URL-} && " $* " != *' --lcm-url'* ]] && ! has_multicast_route && has_private_network; then
  say "no multicast route here: knap runs in a network namespace of its own, which lcm-spy outside does not see"
  in_private_network "${learn[@]}"
else
  exec "${learn[@]}"
fi
