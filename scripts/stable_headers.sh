#!/usr/bin/env bash
# scripts/stable_headers.sh: prints the folder of the Python.h of a Python 3.12 or later: of one that is installed (also by pyenv), else of Debian 13.
set -euo pipefail
cd "$(dirname "$0")/.."

for python in .venv/bin/python python3 python3.12 python3.13 python3.14 python3.15 ~/.pyenv/versions/3.1[2-9].*/bin/python; do
  if "$python" - 2>/dev/null <<'PY'
import os, sys, sysconfig
folder = sysconfig.get_path("include")
if sys.version_info < (3, 12) or sysconfig.get_config_var("Py_GIL_DISABLED") or not os.path.exists(os.path.join(folder, "Python.h")):
    sys.exit(1)
print(folder)
PY
  then exit 0; fi
done

headers=$PWD/build/python-headers
if [ ! -e "$headers/Python.h" ]; then
  scripts/debian_root.sh build/debian13-headers libpython3.13-dev || { echo "wheel: no Python.h of a Python 3.12 or later: install python3.12-dev or later" >&2; exit 1; }
  mkdir -p "$headers/x86_64-linux-gnu"
  cp -r build/debian13-headers/usr/include/x86_64-linux-gnu/python3.13 "$headers/x86_64-linux-gnu/"  # Debian's pyconfig.h names it
  cp -r build/debian13-headers/usr/include/python3.13/. "$headers/"
fi
echo "$headers"
