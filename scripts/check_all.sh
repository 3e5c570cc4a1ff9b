#!/usr/bin/env bash
# What is too slow for every change: formatting, the debug build with asserts, sanitizers. Unit tests without those labelled slow.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=$1

if command -v clang-format >/dev/null; then
  git ls-files -z '*.hpp' '*.cpp' | xargs -0 clang-format --dry-run -Werror
  echo "formatting: ok"
else
  echo "formatting: clang-format not found, skipped" >&2
fi
for preset in dev asan-ubsan tsan; do
  scripts/build.sh "$preset" "$jobs"
  ctest --preset "$preset" -j "$jobs"
done
