#!/usr/bin/env bash
# Plans the in-hand reorientation of a cube, checks the plan and writes a page to look at.
set -euo pipefail
cd "$(dirname "$0")/.."
build/release/stiction plan allegro_cube --seed 0 -o demo-out --html
build/release/stiction check demo-out/plan.json
page=$(ls demo-out/*.html | head -n 1)
echo "plan  demo-out/plan.json"
echo "page  file://$PWD/$page   (open it in a browser: play, scrub, turn the view)"
