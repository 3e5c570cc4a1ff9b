#!/usr/bin/env bash
# requirements*.in → requirements*.lock: exact versions and hashes, nothing about where they came from.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=build/lock-tools
[ -x $tools/bin/pip-compile ] || { python3 -m venv $tools && $tools/bin/pip install --quiet pip-tools; }

compile() {
  $tools/bin/pip-compile --quiet --generate-hashes --strip-extras --allow-unsafe --no-header --no-annotate --no-emit-index-url \
    --no-emit-find-links --no-emit-trusted-host --no-emit-options -o "build/$1.lock" "$1.in"
}

compile requirements
{ echo "# Made by \`make lock\` from requirements.in; installed by \`make setup\` with --require-hashes."
  cat build/requirements.lock; } > requirements.lock

# Only what the file names itself, without dependencies: Drake asks for Mosek, which nothing here calls.
compile requirements-experiments
{ echo "# Made by \`make lock\` from requirements-experiments.in; installed by \`make experiments\` with --require-hashes."
  awk 'NR == FNR { sub(/#.*/, ""); sub(/==.*/, ""); if (NF) wanted[$1]; next }
       /^[A-Za-z]/ { name = $1; sub(/==.*/, "", name); keep = name in wanted }
       keep' requirements-experiments.in build/requirements-experiments.lock; } > requirements-experiments.lock
