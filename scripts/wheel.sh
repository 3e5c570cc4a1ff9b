#!/usr/bin/env bash
# scripts/wheel.sh FOLDER: the wheel and the source archive of this clone, made with what .venv holds and nothing fetched.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$1
log=build/wheel.log
mkdir -p build "$out"
site=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')

# Compiler and folders as `make build` has them, so that ccache knows most of it.
if ! CXX=${CXX:-c++} nice -n 3 .venv/bin/python -m pip wheel . -v --disable-pip-version-check --no-build-isolation --no-deps --no-index -w "$out" \
     -C cmake.define.STICTION_SITE_PACKAGES="$PWD/.venv/${site#*/.venv/}" -C cmake.define.STICTION_WERROR=ON </dev/null >"$log" 2>&1; then
  grep -nE -m 20 '(error:|FAILED:|CMake Error|undefined reference)' "$log" >&2 || true
  tail -n 30 "$log" >&2
  echo "wheel: failed; the whole output is in $log" >&2
  exit 1
fi
.venv/bin/python -c 'import sys; from scikit_build_core.build import build_sdist; build_sdist(sys.argv[1])' "$out" </dev/null >>"$log" 2>&1
ls -1 "$out" | sed "s|^|wheel: $out/|"
