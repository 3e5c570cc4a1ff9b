#!/bin/sh
# scripts/try_wheel.sh PYTHON WHEELS: a new environment with the wheel and nothing else, and what the README does there. The last line says how long the first plan took.
set -eu
python=$1
wheels=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$python" -m venv venv
PATH=$folder/venv/bin:$PATH
export XDG_CACHE_HOME="$folder/cache"

now() { python -c 'import time; print(time.monotonic())'; }
begin=$(now)
pip install --quiet --disable-pip-version-check --find-links "$wheels" stiction
installed=$(now)
stiction plan planar_hand --seed 3 -o out --html >plan.txt
stiction check out/plan.json >check.txt
checked=$(now)

python - <<'PY'
import stiction as st

plan = st.plan(st.load_task("allegro_cube"), seed=0).plan
report = st.check_plan(plan)
print(report)
assert report.pass_
PY
stiction export out --format csv
stiction run planar_hand --seed 3 -o run >/dev/null
stiction sense ur5_forearm >/dev/null
stiction control box_in_the_way -o control >/dev/null
stiction view planar_hand --html page.html
[ -s page.html ] && [ -n "$(ls out/*.html)" ]
python -c "
import platform
print(f'release: Python {platform.python_version()}, {\"-\".join(platform.libc_ver())}: {$installed - $begin:.1f} s to install, {$checked - $begin:.1f} s to a checked plan')"
