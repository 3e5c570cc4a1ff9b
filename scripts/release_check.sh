#!/usr/bin/env bash
# scripts/release_check.sh JOBS: what must hold before a version is given out. Takes an hour or two. The last line says whether it does.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=$1
version=$(cat VERSION)

fail() { echo "release-check: $*" >&2; exit 1; }

[ -z "$(git status --porcelain)" ] || fail "uncommitted changes"
grep -q "^## \[$version\]" CHANGELOG.md || fail "CHANGELOG.md has no section [$version], which VERSION names"
grep -q "^version: $version$" CITATION.cff || fail "CITATION.cff names another version than VERSION, $version"

# As a new user: a clone with nothing beside it, and the README's commands there.
clone=$(mktemp -d)/stiction
trap 'rm -rf "$(dirname "$clone")"' EXIT
git clone -q . "$clone"
make -C "$clone" demo test JOBS="$jobs"
make -C "$clone" release docs JOBS="$jobs"
ls "$clone"/dist/stiction-"$version"-*.whl "$clone"/dist/stiction-"$version".tar.gz >/dev/null || fail "no wheel or source archive of $version"

# With the optional packages, which `make test` does without: Ray whose workers, machines and head die, Foxglove, rerun, Parquet, Gymnasium, and a reader of MCAP that is not the writer's.
python3 -m venv "$clone/extras"
"$clone/extras/bin/python" -m pip install --quiet --disable-pip-version-check --find-links "$clone/dist" 'stiction[ray,parquet,mcap,gym,foxglove,rerun]' pytest pyyaml rosbags
(cd "$clone" && extras/bin/python -m pytest -c tests/python/pytest.ini tests/python/test_sweep.py tests/python/test_ray.py tests/python/test_streams.py tests/python/test_export.py tests/python/test_lerobot.py tests/python/test_grasps.py)

# The source archive holds all that a wheel is made from.
mkdir "$clone/from-source"
tar -xzf "$clone/dist/stiction-$version.tar.gz" -C "$clone/from-source" --strip-components=1
ln -s "$clone/.venv" "$clone/from-source/.venv"
(cd "$clone/from-source" && scripts/wheel.sh dist own)

scripts/check_all.sh "$jobs"
echo "release-check: $version holds"
