"""Batches of source files (cmake/unity.cmake): the same text in every clone, and every file of theirs exactly once."""

import collections
import os
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("STICTION_BUILD", ROOT / "build/release"))
FOLDERS = {"apps": ROOT / "apps/cli", "python": ROOT / "python/module", "src": ROOT / "src", "tests": ROOT / "tests"}  # in the build folder: where their sources lie
BATCHES = sorted(batch for folder in FOLDERS for batch in BUILD.glob(f"{folder}/**/batch_*.cpp"))

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
            file = FOLDERS[batch.relative_to(BUILD).parts[0]] / source
            assert file.is_file(), f"{batch}: {source}"
            assert str(file) not in alone, f"{source} is compiled alone as well"
            counts[file] += 1
    assert counts and set(counts.values()) == {1}
