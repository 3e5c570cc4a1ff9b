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
  # The thread sanitizer of older compilers stops where the kernel randomises addresses too widely (test discovery runs programs, too).
  fixed_addresses=()
  if [ "$preset" = tsan ] && setarch "$(uname -m)" -R true 2>/dev/null; then fixed_addresses=(setarch "$(uname -m)" -R); fi
  "${fixed_addresses[@]}" scripts/build.sh "$preset" "$jobs"
  "${fixed_addresses[@]}" ctest --preset "$preset" -j "$jobs" </dev/null
done
