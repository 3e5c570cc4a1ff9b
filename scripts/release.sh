#!/usr/bin/env bash
# scripts/release.sh [FOLDER]: the wheels in dist, or those that FOLDER has, each tried in an empty environment and beside other packages.
# Python 3.13 is that of a Debian 13 without compilers, for which one has to be root; 3.11 and 3.12 are those that are installed. The last line says whether all of it held.
set -euo pipefail
cd "$(dirname "$0")/.."
wheels=${1:-dist}
if [ $# = 0 ]; then
  rm -rf dist
  scripts/wheel.sh dist
fi

said=()
try() { "$@" | tee build/release.log; said+=("$(tail -n 1 build/release.log)"); }
for python in "$PWD/.venv/bin/python" python3.12 ~/.pyenv/versions/3.12.*/bin/python; do
  if "$python" -c '' 2>/dev/null; then try scripts/try_wheel.sh "$(command -v "$python")" "$wheels"; fi
done
if [ "$(id -u)" = 0 ]; then
  root=build/debian13
  packages=python3,python3-venv,ca-certificates
  scripts/debian_root.sh $root $packages
  rm -rf $root/wheels
  cp -r "$wheels" $root/wheels
  cp scripts/try_wheel.sh $root/
  try scripts/debian_root.sh $root $packages sh /try_wheel.sh python3 /wheels
  try scripts/try_dockerfile.sh
else
  said+=("release: only root can make a Debian 13: not tried with Python 3.13, nor the Dockerfile")
fi

.venv/bin/python -m pytest -c tests/python/pytest.ini tests/packaging -m release --wheels "$wheels"
printf '%s\n' "${said[@]}" "release: $(cat VERSION) in $wheels holds"
