# Sourced by run.sh and test.sh: installs missing packages, builds the release preset, finds a network with multicast.
# Everything it prints goes to stderr: stdout belongs to the program that is started afterwards.
# shellcheck shell=bash

knap_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)

# The same names on Debian 12, Ubuntu 22.04 and Ubuntu 24.04; CONTRIBUTING.md says what each is for. The first list is
# what building needs, its tests included; the second what some tests start, which are skipped without it.
# shellcheck disable=SC2034  # run.sh and test.sh use them
knap_packages=(
  g++ cmake ninja-build pkg-config iproute2
  liblcm-dev liblcm-bin liblcm-java libglib2.0-dev default-jdk-headless
  libeigen3-dev libnlopt-dev libnlopt-cxx-dev libassimp-dev libbullet-dev libbullet-extras-dev libqhull-dev
  liburdfdom-dev
  libyaml-cpp-dev libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libsodium-dev libcpp-httplib-dev
  libgtest-dev libgmock-dev librapidcheck-dev libbenchmark-dev
)
# Independent programs that tests compare with: an engine, of which Ubuntu has no package, and a reader of robots.
if (. /etc/os-release 2>/dev/null && [[ ${ID:-} == debian && ${VERSION_ID:-} == 12 ]]); then
  knap_packages+=(libmujoco-dev liborocos-kdl-dev libkdl-parser-dev)
fi
# shellcheck disable=SC2034
knap_test_packages=(munge slurmctld slurmd slurm-client python3 python3-scipy prusa-slicer admesh)
# A browser that opens reports; Ubuntu's package of it is a snap, which does not run in containers.
if (. /etc/os-release 2>/dev/null && [[ ${ID:-} == debian ]]); then
  knap_test_packages+=(chromium)
fi

say() { printf 'knap: %s\n' "$*" >&2; }

# Those of the given packages that are not installed, one a line.
missing_packages() {
  local installed package
  installed=$(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' "$@" 2>/dev/null || true)
  for package in "$@"; do
    grep -qxF -- "ii $package" <<<"$installed" || echo "$package"
  done
}

# Installs what is missing of the given packages, as root or with a sudo that asks nothing; else prints the one line to
# run and exits with 2.
install_missing_packages() {
  local missing as_root=()
  if ! command -v dpkg-query >/dev/null; then
    say "no dpkg on this system: install the counterparts of these yourself: $*"
    return
  fi
  mapfile -t missing < <(missing_packages "$@")
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    if sudo -n true 2>/dev/null; then
      as_root=(sudo -n)
    else
      say "packages are missing; run this line, then start again:"
      echo "sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}" >&2
      exit 2
    fi
  fi
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
  local install=("${apt[@]}" install -y --no-install-recommends "${missing[@]}")
  say "installing ${missing[*]}"
  if ! "${install[@]}" </dev/null >&2; then
    say "refreshing the package lists, which are empty or old"
    if ! { "${apt[@]}" update </dev/null >&2 && "${install[@]}" </dev/null >&2; }; then
      say "apt-get could not install the packages named above"
      exit 2
    fi
  fi
}

# Parallel compilations: one a core, and no more than one for every 2 GB of memory that is free.
build_jobs() {
  local cores memory_kb limit
  cores=$(nproc)
  memory_kb=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)
  limit=$(cat /sys/fs/cgroup/memory.max 2>/dev/null || true)
  if [[ $limit =~ ^[0-9]+$ ]] && ((limit / 1024 < memory_kb)); then
    memory_kb=$((limit / 1024))
  fi
  local jobs=$((memory_kb / 2000000))
  if ((jobs > cores)); then jobs=$cores; fi
  if ((jobs < 1)); then jobs=1; fi
  echo "$jobs"
}

# build_release TARGET…: configures when that was not done since the presets changed, and builds the targets.
build_release() (
  cd -- "$knap_root" || exit
  if [[ ! -f build/release/build.ninja || CMakePresets.json -nt build/release/build.ninja ]]; then
    cmake --preset release >&2
  fi
  cmake --build --preset release --parallel "$(build_jobs)" --target "$@" >&2
)

# Runs COMMAND… in a network namespace that has nothing but a loopback with a multicast route.
in_private_network() {
  local unshare=(unshare --net)
  if ((EUID != 0)); then unshare=(unshare --user --map-root-user --net); fi
  # shellcheck disable=SC2016  # the inner shell expands "$@"
  "${unshare[@]}" -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"' sh "$@"
}

# Whether this user may make such a namespace (containers and Ubuntu 24.04's AppArmor can forbid it).
has_private_network() { in_private_network true 2>/dev/null; }

# Whether a packet to LCM's default group finds a route; the routes themselves are the user's and stay as they are.
has_multicast_route() { ip route get 239.255.76.67 >/dev/null 2>&1; }
