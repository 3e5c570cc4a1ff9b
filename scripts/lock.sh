#!/usr/bin/env bash
# requirements.in → requirements.lock: exact versions and hashes, nothing about where they came from.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=build/lock-tools
[ -x $tools/bin/pip-compile ] || { python3 -m venv $tools && $tools/bin/pip install --quiet pip-tools; }
$tools/bin/pip-compile --quiet --generate-hashes --strip-extras --allow-unsafe --no-header --no-annotate --no-emit-index-url \
  --no-emit-find-links --no-emit-trusted-host --no-emit-options -o build/requirements.lock requirements.in
{ echo "# Made by \`make lock\` from requirements.in; installed by \`make setup\` with --require-hashes."
  cat build/requirements.lock; } > requirements.lock
