#!/usr/bin/env bash
# scripts/release.sh: the wheels in dist, each tried in an empty environment and beside other packages. The last line says whether all of it held.
# Python 3.13 is that of a Debian 13 without compilers, for which one has to be root; 3.11 and 3.12 are those that are installed.
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(cat VERSION)
rm -rf dist
scripts/wheel.sh dist

tried=()
try() { "$@" | tee build/try_wheel.log; tried+=("$(tail -n 1 build/try_wheel.log)"); }
for python in "$PWD/.venv/bin/python" python3.12 ~/.pyenv/versions/3.12.*/bin/python; do
  if "$python" -c '' 2>/dev/null; then try scripts/try_wheel.sh "$(command -v "$python")" dist; fi
done
if [ "$(id -u)" = 0 ]; then
  scripts/debian_root.sh build/debian13
  rm -rf build/debian13/wheels
  cp -r dist build/debian13/wheels
  cp scripts/try_wheel.sh build/debian13/
  try scripts/debian_root.sh build/debian13 sh /try_wheel.sh python3 /wheels
else
  tried+=("release: no Debian 13 with Python 3.13, which only root can make: not tried there")
fi

.venv/bin/python -m pytest -c tests/python/pytest.ini tests/packaging -m release --wheels dist
printf '%s\n' "${tried[@]}" "release: $version in dist holds"
