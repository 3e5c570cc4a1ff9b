#!/usr/bin/env bash
# scripts/wheel.sh FOLDER [own]: the wheels and the source archive of this clone (docs/decisions/0022-wheel.md). One wheel is for Python 3.11, where
# .venv has that, and one for 3.12 and all later ones; "own" makes the wheel of .venv alone. Fetches what requirements-wheel.lock names, and a Python.h where there is none.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$1
only=${2:-}
log=build/wheel.log
mkdir -p build "$out"
site=$(.venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')

tools=build/wheel-tools
wanted=$(sha256sum requirements-wheel.lock | cut -d ' ' -f 1)
if [ "$(cat $tools/requirements.sha256 2>/dev/null)" != "$wanted" ]; then
  rm -rf $tools
  .venv/bin/python -m venv $tools
  $tools/bin/python -m pip install --quiet --disable-pip-version-check --no-input --require-hashes --no-deps --only-binary :all: -r requirements-wheel.lock
  printf '%s\n' "$wanted" > $tools/requirements.sha256
fi
export PATH=$PWD/$tools/bin:$PATH
own=$(.venv/bin/python -c 'import sys; print(*sys.version_info[:2], sep=".")')
headers=
if [ "$own" != 3.11 ] || [ "$only" != own ]; then headers=$(scripts/stable_headers.sh); fi

fail() {
  grep -anE -m 20 '(error:|FAILED:|CMake Error|undefined reference)' "$log" >&2 || true
  tail -n 30 "$log" >&2
  echo "wheel: failed; the whole output is in $log" >&2
  exit 1
}

# Compiler and folders as `make build` has them, so that ccache knows most of it.
raw=build/wheel-raw
rm -rf $raw
CXX=${CXX:-c++} nice -n 3 .venv/bin/python -m pip wheel . -v --disable-pip-version-check --no-build-isolation --no-deps --no-index -w $raw \
  -C cmake.define.STICTION_SITE_PACKAGES="$PWD/.venv/${site#*/.venv/}" -C cmake.define.STICTION_WERROR=ON \
  -C cmake.define.STICTION_STABLE_ABI_INCLUDE="$headers" </dev/null >"$log" 2>&1 || fail
wheels=()
[ "$own" != 3.11 ] || wheels+=("$raw"/*.whl)

# The wheel for 3.12 and later differs in its module alone.
if [ -n "$headers" ]; then
  nice -n 3 cmake --build build/wheel --target stiction_module_stable </dev/null >>"$log" 2>&1 || fail
  wheel unpack --dest $raw $raw/*.whl >>"$log"
  package=$(echo $raw/*/stiction)
  rm "$package"/_core.*.so
  cmake --install build/wheel --component python_stable --strip --prefix "$(dirname "$package")" >>"$log"
  mkdir $raw/stable
  wheel pack --dest-dir $raw/stable "$(dirname "$package")" >>"$log"
  wheel tags --remove --python-tag cp312 --abi-tag abi3 $raw/stable/*.whl >>"$log"
  wheels+=("$raw"/stable/*.whl)
fi
# Nothing is left to copy: auditwheel looks whether other systems have the rest, and names the oldest.
for wheel in "${wheels[@]}"; do
  auditwheel repair --wheel-dir "$out" "$wheel" >>"$log" 2>&1 || fail
done
.venv/bin/python -c 'import sys; from scikit_build_core.build import build_sdist; build_sdist(sys.argv[1])' "$out" </dev/null >>"$log" 2>&1
ls -1 "$out" | sed "s|^|wheel: $out/|"
