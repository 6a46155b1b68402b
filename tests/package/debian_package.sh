#!/usr/bin/env bash
# tests/package/debian_package.sh BUILD [MIRROR]
#
# Makes the Debian package of BUILD, installs it into a bare Debian 12, learns there as an ordinary user, and takes it
# away again: nothing of it may stay. Needs root, debootstrap, cpack and a MIRROR of Debian (default: apt's own).
set -euo pipefail

build=$(realpath "$1")
# shellcheck disable=SC2016  # apt expands it
mirror=${2:-$(apt-get indextargets --format '$(SITE)' | head -n 1)}
work=$(mktemp -d)
finish() {
  for mounted in proc dev; do umount "$work/root/$mounted" 2>/dev/null || true; done
  rm -rf -- "$work"
}
trap finish EXIT
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work" >"$work/cpack.log" || { cat "$work/cpack.log"; exit 1; }
package=$(ls "$work"/*.deb)
dpkg-deb --info "$package" | sed -n '/Package:/,$p'

debootstrap --variant=minbase bookworm "$work/root" "$mirror" >"$work/debootstrap.log" ||
  { tail "$work/debootstrap.log"; exit 1; }
# Whatever apt needs here to reach its mirror, it needs there.
cp -r /etc/apt/apt.conf.d/. "$work/root/etc/apt/apt.conf.d/"
mount -t proc proc "$work/root/proc"
mount --bind /dev "$work/root/dev"
inside() { chroot "$work/root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C DEBIAN_FRONTEND=noninteractive "$@"; }
list() { (cd -- "$work/root" && find bin etc lib sbin usr -xdev | grep -v '^etc/ld.so.cache' | sort); }

cp -- "$package" "$work/root/knap.deb"
inside apt-get -q update >"$work/apt.log" || { cat "$work/apt.log"; exit 1; }
# Its libraries first, so that what the package itself leaves can be told from what they do.
mapfile -t needs < <(dpkg-deb --field "$package" Depends | tr ',' '\n' | sed 's/ *(.*//; s/^ *//')
inside apt-get -qy --no-install-recommends install "${needs[@]}" >>"$work/apt.log" || { tail "$work/apt.log"; exit 1; }
list >"$work/before"
inside apt-get -qy --no-install-recommends install /knap.deb >>"$work/apt.log" || { tail "$work/apt.log"; exit 1; }
inside useradd --create-home somebody
inside su somebody -c 'knap --version && cd && knap learn /usr/share/knap/configs/pushing.yaml --out run --quiet \
  learning.variations=10 evaluation.variations=20 && ls run/tool/learned.stl'
# As docs/container.md has it: workers elsewhere speak through a relay, and the bits are the same.
cat >"$work/root/external.sh" <<'EOF'
set -eu
cd
(umask 077 && head -c 32 /dev/urandom >run.key)
knap-relay --port 7711 &
relay=$!
for name in one two; do knap-worker --lcm-url tcpq://127.0.0.1:7711 --key run.key --name "$name" & done
knap learn /usr/share/knap/configs/pushing.yaml --external --lcm-url tcpq://127.0.0.1:7711 --key run.key \
  --out external --quiet learning.variations=10 evaluation.variations=20
kill "$relay"
cmp run/tool/learned.stl external/tool/learned.stl
EOF
inside su somebody -c 'sh /external.sh'
inside userdel --remove somebody 2>/dev/null
inside apt-get -qy purge knap >>"$work/apt.log"
list >"$work/after"
diff <(grep -v '^etc/.*-$' "$work/before") <(grep -v '^etc/.*-$' "$work/after")
echo "installed, used and removed without traces: $(basename -- "$package")"
