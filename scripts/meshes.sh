#!/usr/bin/env bash
# Package iiwa_description, meshes of arms, beside example-robot-data in .venv: unpacked from a wheel that is not installed. Cheap when it is there.
set -euo pipefail
cd "$(dirname "$0")/.."

lock=requirements-meshes.lock
share=$(echo .venv/lib/python3*/site-packages/cmeel.prefix/share)
stamp=$share/iiwa_description/$lock.sha256
wanted=$(sha256sum "$lock" | cut -d ' ' -f 1)
if [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; then
  exit 0
fi
if [ -L .venv ]; then
  echo "meshes: .venv is a link to an environment made by hand; left as it is. What is missing in it is in $lock" >&2
  exit 1
fi
folder=build/meshes
rm -rf "$folder"
mkdir -p "$folder"
trap 'rm -rf "$folder"' EXIT
if ! .venv/bin/python -m pip download --disable-pip-version-check --no-input --require-hashes --no-deps --only-binary :all: --python-version 3.10 \
     --implementation cp --abi cp310 --platform manylinux_2_31_x86_64 -d "$folder" -r "$lock" </dev/null >build/pip-meshes.log 2>&1; then
  tail -n 20 build/pip-meshes.log >&2
  echo "meshes: pip failed; the whole output is in build/pip-meshes.log" >&2
  exit 1
fi
.venv/bin/python - "$folder" <<'PYTHON'
import sys, zipfile
from pathlib import Path

folder = Path(sys.argv[1])
(wheel,) = folder.glob("*.whl")
with zipfile.ZipFile(wheel) as files:
    files.extractall(folder, [name for name in files.namelist() if "/iiwa_description/" in name])
PYTHON
rm -rf "$share/iiwa_description"
cp -r "$folder"/pydrake/share/drake/manipulation/models/iiwa_description "$share/"
printf '%s\n' "$wanted" > "$stamp"
