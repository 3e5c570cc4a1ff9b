#!/usr/bin/env bash
# scripts/debian_root.sh FOLDER PACKAGES [COMMAND…]: a small Debian 13 with these packages (a,b,…) in FOLDER, made when it is missing, and COMMAND in it.
# It has the settings of pip of this machine; nothing stays mounted. For root.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$1
packages=$2
shift 2

[ "$(id -u)" = 0 ] || { echo "debian_root: only root can make $root" >&2; exit 1; }
if [ ! -e "$root/complete" ]; then
  mkdir -p build
  if ! command -v debootstrap >/dev/null; then
    DEBIAN_FRONTEND=noninteractive apt-get -y -q install --no-install-recommends debootstrap </dev/null >build/apt.log 2>&1 ||
      { echo "debian_root: no debootstrap, and apt-get brings none; see build/apt.log" >&2; exit 1; }
  fi
  rm -rf "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase ${packages:+--include="$packages"} trixie "$root" </dev/null >build/debian_root.log 2>&1 ||
    { tail -n 5 build/debian_root.log >&2; echo "debian_root: debootstrap failed; the whole output is in build/debian_root.log" >&2; exit 1; }
  touch "$root/complete"
fi
[ $# -gt 0 ] || exit 0

cp /etc/resolv.conf "$root/etc/"
[ ! -e /etc/pip.conf ] || cp /etc/pip.conf "$root/etc/"
mkdir -p "$root/etc/ssl/certs"
[ ! -e /etc/ssl/certs/ca-certificates.crt ] || cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
exec unshare --mount --pid --fork sh -c 'mount -t proc proc "$0/proc" && mount --bind /dev "$0/dev" && exec chroot "$0" "$@"' "$root" "$@"
