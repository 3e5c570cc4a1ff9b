#!/usr/bin/env bash
# System packages (Debian and Ubuntu) and the locked Python environment .venv. Cheap when there is nothing to do.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '%s\n' "$*" >&2; }

# The first Python that is new enough and can make a virtual environment.
find_python() {
  local candidate
  for candidate in python3 /usr/bin/python3 python3.13 python3.12 python3.11; do
    if "$candidate" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then
      printf '%s' "$candidate"
      return 0
    fi
  done
  return 1
}

# The module is compiled against the headers of that Python.
has_headers() {
  local python
  python=$(find_python) || return 1
  "$python" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))'
}

# ---- system packages ----
is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

missing=()
if command -v dpkg-query >/dev/null; then
  while read -r package; do
    case "$package" in
      python3-dev) has_headers || missing+=("$package") ;;
      python3-venv) find_python >/dev/null || missing+=("$package") ;;
      # Any Chromium or Chrome will do: Ubuntu's package is a stub for a snap.
      chromium) is_installed chromium || command -v chromium chromium-browser google-chrome >/dev/null || missing+=("$package") ;;
      *) is_installed "$package" || missing+=("$package") ;;
    esac
  done < scripts/packages.txt
else
  for tool in cmake ninja git g++; do
    command -v "$tool" >/dev/null || { say "setup: '$tool' not found; install the equivalents of: $(xargs < scripts/packages.txt)"; exit 1; }
  done
fi

if [ ${#missing[@]} -gt 0 ]; then
  if [ "$(id -u)" = 0 ]; then
    as_root=(env)
  elif sudo -n true 2>/dev/null; then
    as_root=(sudo -n env)
  else
    say "setup: some system packages are missing; install them with this line, then run make again:"
    say "  sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}"
    exit 1
  fi
  say "setup: installing ${missing[*]}"
  mkdir -p build
  apt=("${as_root[@]}" DEBIAN_FRONTEND=noninteractive apt-get -y -q)
  if ! { "${apt[@]}" install --no-install-recommends "${missing[@]}" ||
         { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends "${missing[@]}"; }; } </dev/null >build/apt.log 2>&1; then
    tail -n 20 build/apt.log >&2
    say "setup: apt-get failed; the whole output is in build/apt.log"
    exit 1
  fi
fi

# ---- Python environment ----
stamp=.venv/requirements.sha256
wanted=$(sha256sum requirements.lock | cut -d ' ' -f 1)
if [ -x .venv/bin/python ] && [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; then
  exit 0
fi
if [ -L .venv ]; then
  say "setup: .venv is a link to an environment made by hand; left as it is"
  exit 0
fi
python=$(find_python) || { say "setup: no Python ≥ 3.11 with venv found"; exit 1; }
say "setup: making .venv with $("$python" --version)"
mkdir -p build
rm -rf .venv
"$python" -m venv .venv
if ! .venv/bin/python -m pip install --disable-pip-version-check --no-input --require-hashes --no-deps --only-binary :all: \
     -r requirements.lock </dev/null >build/pip.log 2>&1; then
  tail -n 20 build/pip.log >&2
  say "setup: pip failed; the whole output is in build/pip.log"
  rm -rf .venv
  exit 1
fi
printf '%s\n' "$wanted" > "$stamp"
