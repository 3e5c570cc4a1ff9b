#!/usr/bin/env bash
# scripts/build.sh PRESET JOBS [TARGET…]: configures and builds quietly; prints the end of the log when it fails.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1 jobs=$2
shift 2
log=build/$preset/build.log
mkdir -p "build/$preset"

fail() {
  # The first compiler error is worth more than the last lines.
  grep -nE -m 20 '(error:|FAILED:|CMake Error|undefined reference)' "$log" >&2 || true
  echo "---- end of $log ----" >&2
  tail -n 40 "$log" >&2
  exit 1
}

started=$SECONDS
if [ ! -f "build/$preset/build.ninja" ]; then
  echo "build: configuring $preset" >&2
  cmake --preset "$preset" >"$log" 2>&1 </dev/null || fail
else
  : >"$log"
fi
targets=()
[ $# -eq 0 ] || targets=(--target "$@")
work=$(cmake --build "build/$preset" "${targets[@]}" -- -n 2>/dev/null | tail -n 1 | sed -nE 's/^\[[0-9]+\/([0-9]+)\].*/\1/p' || true)
if [ -n "$work" ] && [ "$work" -gt 5 ]; then echo "build: $preset, about $work steps, $jobs at a time" >&2; fi
cmake --build "build/$preset" "${targets[@]}" -j "$jobs" >>"$log" 2>&1 </dev/null || fail
took=$((SECONDS - started))
if [ "$took" -gt 3 ]; then echo "build: $preset done in $took s" >&2; fi
