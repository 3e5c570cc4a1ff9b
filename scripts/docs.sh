#!/usr/bin/env bash
# The documentation site in build/site: pages of plans first, then mkdocs with scripts/site_pages.py. What is unchanged since the last time is kept.
set -euo pipefail
cd "$(dirname "$0")/.."
plans=build/docs/plans
mkdir -p $plans
for task in allegro_cube planar_hand; do
  made_of=$(sha256sum build/release/stiction tasks/$task.yaml python/stiction_view/*.* | sha256sum)
  [ "$(cat build/docs/$task.made_of 2>/dev/null)" != "$made_of" ] || continue
  build/release/stiction plan $task --seed 0 --timeout 60 -o build/docs/$task --html >build/docs/$task.log || { echo "docs: no plan of $task in a minute; see build/docs/$task.log" >&2; exit 1; }
  cp build/docs/$task/*.html $plans/$task.html
  [ $task != allegro_cube ] || .venv/bin/python $plans/$task.html $plans/$task.png
  printf '%s\n' "$made_of" >build/docs/$task.made_of
done
# Of the packages themselves; the notice of the theme says nothing about this site.
NO_MKDOCS_2_WARNING=1 .venv/bin/python -m mkdocs build --quiet
echo "docs: file://$PWD/build/site/index.html"
