#!/usr/bin/env bash
# requirements*.in → requirements*.lock: exact versions and hashes, nothing about where they came from.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=build/lock-tools
[ -x $tools/bin/pip-compile ] || { python3 -m venv $tools && $tools/bin/pip install --quiet pip-tools; }

compile() {  # NAME [OPTION…]
  local name=$1
  shift
  $tools/bin/pip-compile --quiet --generate-hashes --strip-extras --allow-unsafe --no-header --no-annotate --no-emit-index-url \
    --no-emit-find-links --no-emit-trusted-host --no-emit-options -o "build/$name.lock" "$@" "$name.in"
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

compile requirements-wheel
{ echo "# Made by \`make lock\` from requirements-wheel.in; installed by \`make wheel\` with --require-hashes."
  cat build/requirements-wheel.lock; } > requirements-wheel.lock

# What the documentation site needs beside requirements.lock, with dependencies.
compile requirements-docs -c requirements.lock
{ echo "# Made by \`make lock\` from requirements-docs.in; installed by \`make docs\` with --require-hashes."
  awk 'NR == FNR { if (/^[A-Za-z]/) { sub(/==.*/, ""); have[$1] } next }
       /^[A-Za-z]/ { name = $1; sub(/==.*/, "", name); keep = !(name in have) }
       keep' requirements.lock build/requirements-docs.lock; } > requirements-docs.lock
