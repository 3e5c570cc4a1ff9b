#!/usr/bin/env bash
# The documentation site in build/site: pages and pictures of plans first, then mkdocs with scripts/site_pages.py.
set -euo pipefail
cd "$(dirname "$0")/.."
plans=build/docs/plans
mkdir -p $plans
for task in allegro_cube planar_hand; do
  build/release/stiction plan $task --seed 0 --timeout 60 -o build/docs/$task --html >build/docs/$task.log || { echo "docs: no plan of $task in a minute; see build/docs/$task.log" >&2; exit 1; }
  cp build/docs/$task/*.html $plans/$task.html
done
.venv/bin/python scripts/picture.py $plans/allegro_cube.html $plans/allegro_cube.png
# Of the packages themselves; the notice of the theme says nothing about this site.
NO_MKDOCS_2_WARNING=1 .venv/bin/python -m mkdocs build --quiet
echo "docs: file://$PWD/build/site/index.html"
