#!/usr/bin/env bash
# ./test.sh [ctest args…]
#
# Installs what is missing, builds, and runs every test; the arguments choose: -L unit, -R name, --verbose, …
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/cmake/setup.sh"

if [[ ${1-} == -h || ${1-} == --help ]]; then
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  exit 0
fi

install_missing_packages "${knap_packages[@]}"
# In a shell of its own: the tests that want these are skipped without them.
(install_missing_packages "${knap_test_packages[@]}") || say "going on without them: some tests will be skipped"
build_release all

cd -- "$knap_root"
tests=(ctest --preset release --no-tests=error --parallel "$(nproc)" "$@")
if has_private_network; then
  say "the tests run in a network namespace of their own: loopback with a multicast route, nothing else"
  in_private_network "${tests[@]}"
elif has_multicast_route; then
  say "no private network namespace may be made here: the tests use this machine's network, with TTL 0"
  "${tests[@]}"
else
  say "LCM needs a route for multicast and there is none; run this line, then start again:"
  echo "sudo ip link set lo up && sudo ip route add 224.0.0.0/4 dev lo" >&2
  exit 2
fi
