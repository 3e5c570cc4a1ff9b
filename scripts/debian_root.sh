#!/usr/bin/env bash
# scripts/debian_root.sh FOLDER [COMMAND…]: a small Debian 13 with its Python 3.13 in FOLDER, made when it is missing, and COMMAND in it. For root.
# It has the settings of pip of this machine; nothing stays mounted.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$1
shift

[ "$(id -u)" = 0 ] || { echo "debian_root: only root can make $root" >&2; exit 1; }
if [ ! -e "$root/complete" ]; then
  if ! command -v debootstrap >/dev/null; then
    DEBIAN_FRONTEND=noninteractive apt-get -y -q install --no-install-recommends debootstrap </dev/null >build/apt.log 2>&1 ||
      { echo "debian_root: no debootstrap, and apt-get brings none; see build/apt.log" >&2; exit 1; }
  fi
  rm -rf "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase --include=python3,python3-venv,libpython3.13-dev,ca-certificates trixie "$root" </dev/null >build/debian_root.log 2>&1 ||
    { tail -n 5 build/debian_root.log >&2; echo "debian_root: debootstrap failed; the whole output is in build/debian_root.log" >&2; exit 1; }
  touch "$root/complete"
fi
[ $# -gt 0 ] || exit 0

cp /etc/resolv.conf "$root/etc/"
[ ! -e /etc/pip.conf ] || cp /etc/pip.conf "$root/etc/"
[ ! -e /etc/ssl/certs/ca-certificates.crt ] || cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
exec unshare --mount --pid --fork sh -c 'mount -t proc proc "$0/proc" && mount --bind /dev "$0/dev" && exec chroot "$0" "$@"' "$root" "$@"
