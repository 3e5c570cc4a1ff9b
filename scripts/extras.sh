#!/usr/bin/env bash
# scripts/extras.sh experiments|docs: optional packages into .venv. Cheap when they are there; `make setup` takes them away when it makes .venv again.
set -euo pipefail
cd "$(dirname "$0")/.."

lock=requirements-$1.lock
stamp=.venv/${lock%.lock}.sha256
wanted=$(sha256sum "$lock" | cut -d ' ' -f 1)
if [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; then
  exit 0
fi
if [ -L .venv ]; then
  echo "$1: .venv is a link to an environment made by hand; left as it is. What is missing in it is in $lock" >&2
  exit 1
fi
mkdir -p build
if ! .venv/bin/python -m pip install --disable-pip-version-check --no-input --require-hashes --no-deps --only-binary :all: \
     -r "$lock" </dev/null >"build/pip-$1.log" 2>&1; then
  tail -n 20 "build/pip-$1.log" >&2
  echo "$1: pip failed; the whole output is in build/pip-$1.log" >&2
  exit 1
fi
printf '%s\n' "$wanted" > "$stamp"
