"""Batches of source files (cmake/unity.cmake): the same text in every clone, and every file of theirs exactly once."""

import collections
import os
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("STICTION_BUILD", ROOT / "build/release"))
BATCHES = sorted(BUILD.glob("apps/**/batch_*.cpp")) + sorted(BUILD.glob("src/**/batch_*.cpp"))

pytestmark = pytest.mark.skipif(not BATCHES, reason=f"{BUILD} has no batches: run `make build`")


def sources(batch):
    return [re.fullmatch(r'#include "([^"]+\.cpp)"', line).group(1) for line in batch.read_text().splitlines()]


def test_batches_name_no_folder_of_this_machine():
    """Another clone of the repository finds their objects in the cache of the compiler."""
    for batch in BATCHES:
        assert sources(batch), batch
        for source in sources(batch):
            assert not source.startswith(("/", "..")), f"{batch}: {source}"


def test_files_of_batches_exist_and_are_compiled_once():
    ninja = (BUILD / "build.ninja").read_text()
    alone = set(re.findall(r": CXX_COMPILER\S* (\S+)", ninja))
    assert alone
    counts = collections.Counter()
    for batch in BATCHES:
        if str(batch.relative_to(BUILD)) not in ninja:
            continue  # of an earlier configuration
        for source in sources(batch):
            folder = ROOT / "src" if source.startswith("stiction/") else ROOT / "apps/cli"
            assert (folder / source).is_file(), f"{batch}: {source}"
            assert str(folder / source) not in alone, f"{source} is compiled alone as well"
            counts[source] += 1
    assert counts and set(counts.values()) == {1}
