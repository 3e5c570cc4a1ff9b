#!/usr/bin/env bash
# Every test on the release build: C++ (CTest), then Python and documentation (pytest). Runs all of them even if some fail.
set -uo pipefail
cd "$(dirname "$0")/.."
jobs=$1
failed=0

ctest --preset release -j "$jobs" </dev/null 2>&1 | tee build/release/ctest.log
[ "${PIPESTATUS[0]}" -eq 0 ] || failed=1
.venv/bin/python -m pytest -n "$jobs" --dist loadfile -c tests/python/pytest.ini tests/python tests/packaging -m "not release" </dev/null 2>&1 | tee build/release/pytest.log
[ "${PIPESTATUS[0]}" -eq 0 ] || failed=1

echo
echo "C++:    $(grep -E 'tests passed|No tests were found' build/release/ctest.log | tail -n 1)"
echo "Python: $(grep -vE '^[[:space:]]*$' build/release/pytest.log | tail -n 1 | sed -E 's/^=+ //; s/ =+$//')"
exit $failed
