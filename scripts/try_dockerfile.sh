#!/usr/bin/env bash
# scripts/try_dockerfile.sh: the steps of the Dockerfile in a Debian 13 with nothing else, without Docker, and its program. For root.
set -euo pipefail
cd "$(dirname "$0")/.."
root=build/debian13-image
rm -rf $root
inside() { scripts/debian_root.sh $root "" env -i PATH="$path" XDG_CACHE_HOME=/var/tmp DEBIAN_FRONTEND=noninteractive "$@"; }
path=/usr/sbin:/usr/bin:/sbin:/bin
scripts/debian_root.sh $root ""

while read -r step words; do
  case $step in
    FROM) [ "$words" = debian:trixie-slim ] || { echo "try_dockerfile: FROM $words, expected debian:trixie-slim" >&2; exit 1; } ;;
    RUN) inside sh -ec "$words" </dev/null >>build/dockerfile.log 2>&1 || { tail -n 5 build/dockerfile.log >&2; echo "try_dockerfile: failed: $words" >&2; exit 1; } ;;
    COPY) mkdir -p "$root${words#* }"; cp ${words% *} "$root${words#* }" ;;
    ENV) path=${words%%:*}:$path; path=${path#PATH=} ;;
    WORKDIR) mkdir -p "$root$words" ;;
    ENTRYPOINT | '' | \#) ;;
    *) echo "try_dockerfile: step $step is not known" >&2; exit 1 ;;
  esac
done <Dockerfile
inside sh -ec 'cd /data; stiction plan planar_hand --seed 3 -o out --html >/dev/null; stiction check out/plan.json >/dev/null; ls out/*.html >/dev/null'
echo "release: the steps of the Dockerfile give a program that plans ($(du -sm $root | cut -f 1) MB)"
rm -rf $root
