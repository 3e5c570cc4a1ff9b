#!/usr/bin/env bash
# The documentation site in build/site: pages of plans first, then mkdocs with scripts/site_pages.py, then a look at every page. What is unchanged since the last time is kept.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${DOCS_PYTHON:-.venv/bin/python}
"$python" scripts/gallery.py
# Of the packages themselves; the notice of the theme says nothing about this site.
NO_MKDOCS_2_WARNING=1 "$python" -m mkdocs build --quiet
"$python" scripts/check_site.py
echo "docs: file://$PWD/build/site/index.html"
