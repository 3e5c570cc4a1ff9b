#!/usr/bin/env bash
# An arm goes to its goal past a pillar that it does not know: plan, touch, plan around it. Writes a page to look at.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p demo-out
build/release/stiction touch reach_past_pillar --seed 0 --html demo-out/touch.html
echo "page  file://$PWD/demo-out/touch.html   (open it in a browser: play, scrub, turn the view)"
