"""What the documents promise: commands run, links lead somewhere, files that must agree do."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import children
import prose as prose_text
import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted(
    path
    for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("src/**/*.md"), *ROOT.glob("tasks/**/*.md"), *ROOT.glob("python/*.md"), *ROOT.glob("experiments/*.md")]
    if "build" not in path.parts
)


def commands(document: Path) -> list[str]:
    """Lines of the blocks marked ```sh."""
    blocks = re.findall(r"^```sh\n(.*?)^```", document.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return [line for block in blocks for line in block.splitlines() if line.strip() and not line.startswith("#")]


def relative(path: Path) -> str:
    return str(path.relative_to(ROOT))


def files(document: Path) -> dict[str, str]:
    """Blocks that a reader saves as files, marked ```LANGUAGE title="NAME"."""
    text = document.read_text(encoding="utf-8")
    return dict(re.findall(r'^```[a-z]+ title="([^"]+)"\n(.*?)^```', text, flags=re.DOTALL | re.MULTILINE))


@pytest.mark.parametrize("document", [d for d in DOCUMENTS if commands(d)], ids=relative)
def test_commands_of_a_document_run(document: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """`make` targets must exist; commands of the program are run in order, in a folder that has the files of the page, and looks like the repository if the page has none."""
    for name, text in files(document).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for entry in ROOT.iterdir() if not files(document) else []:
        if entry.name not in ("out", "demo-out", ".git"):
            (tmp_path / entry.name).symlink_to(entry)
    for line in commands(document):
        words = shlex.split(line)
        if words[0] == "make":
            done = children.run(["make", "-n", *words[1:]], cwd=ROOT, limit=60)
        elif words[0] in ("stiction", "build/release/stiction"):
            program = request.getfixturevalue("program")
            done = children.run([program, *words[1:]], cwd=tmp_path, limit=300)
        else:
            pytest.fail(f"{relative(document)}: do not know how to test {line!r}")
        assert done.returncode == 0, f"{relative(document)}: {line}\n{done.stdout}{done.stderr}"


@pytest.mark.parametrize("document", [d for d in DOCUMENTS if files(d)], ids=relative)
def test_files_in_a_page_are_those_beside_it(document: Path) -> None:
    for name, text in files(document).items():
        assert (document.parent / name).read_text(encoding="utf-8") == text, f"{relative(document)}: {name}"


def test_page_of_commands_names_those_that_the_program_has(program: Path) -> None:
    text = children.run([program, "--help"], limit=60).stdout
    known = set(re.findall(r"^  ([a-z]+) ", text.split("Subcommands:")[1], flags=re.MULTILINE))
    table = (ROOT / "docs/commands.md").read_text(encoding="utf-8").split("```")[0]
    named = {name for line in table.splitlines() if line.startswith("| `") for name in re.findall(r"`([a-z]+)", line.split("|")[1])}
    assert known and named == known


@pytest.mark.parametrize("document", DOCUMENTS, ids=relative)
def test_relative_links_lead_somewhere(document: Path) -> None:
    text = re.sub(r"^```.*?^```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not re.match(r"[a-z]+:", target) and not target.startswith("#"):
            assert (document.parent / target.split("#")[0]).exists(), f"{relative(document)}: link to {target}"


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "theory").glob("*.md")), ids=lambda page: page.name)
def test_theory_pages_are_in_the_index(page: Path) -> None:
    assert page.name == "README.md" or f"]({page.name})" in (page.parent / "README.md").read_text(encoding="utf-8"), "not in the index"


# Pages that are written in sentences of ordinary length (prose.py): theory, notation, layers, tasks.
SENTENCES_OF_THEORY: list[str] = [
    "docs/notation.md",
    "docs/benchmarks.md",
    "docs/theory/*.md",
    "experiments/*.md",
    "scenarios/*.md",
    "src/**/*.md",
    "tasks/**/*.md",
]

# The same: README, tutorials, decisions, lab, reference.
SENTENCES_OF_GUIDES: list[str] = [
    "*.md",
    "python/*.md",
    "docs/tutorials/*.md",
    "docs/decisions/*.md",
    "docs/lab/*.md",
    "docs/benchmark.md",
    "docs/benchmark_failures.md",
    "docs/commands.md",
    "docs/exports.md",
    "docs/index.md",
    "docs/options.md",
    "docs/plan_file.md",
    "docs/roadmap.md",
    "docs/streams.md",
    "docs/sweeps.md",
]


def prose_pages() -> list[Path]:
    return sorted({page for pattern in [*SENTENCES_OF_THEORY, *SENTENCES_OF_GUIDES] for page in ROOT.glob(pattern)})


def test_theory_decisions_lab_and_tutorials_can_be_read() -> None:
    pages = [page for folder in ("theory", "decisions", "lab", "tutorials") for page in (ROOT / "docs" / folder).glob("*.md")]
    assert sum(prose_text.count_words(page) for page in pages) <= 27_000


@pytest.mark.parametrize("page", prose_pages(), ids=relative)
def test_sentences_are_of_ordinary_length(page: Path) -> None:
    faults = prose_text.faults(page, relative(page))
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("page", sorted({page for pattern in SENTENCES_OF_THEORY for page in ROOT.glob(pattern)}), ids=relative)
def test_sentences_of_theory_name_their_subject(page: Path) -> None:
    """A clause in the place of a noun ("What moves …", "Where it is …") leaves the reader to guess the noun."""
    riddles = [s for s in prose_text.sentences(page.read_text(encoding="utf-8")) if s.text.startswith(("What ", "Where ", "Whatever ")) and not s.text.endswith("?")]
    assert not riddles, "\n".join(f"{relative(page)}:{s.line}: {s.text}" for s in riddles)


def test_check_of_sentences_counts_a_formula_as_one_word_and_leaves_out_code_tables_and_links() -> None:
    text = (
        "# A heading is no sentence\n\n"
        "The [increment](a_page.md) solves\n\n    minimise ½ δqᵀ Q δq + bᵀ δq   (S.1)\n\nwith h = 0.1 s. The `next sentence` is short.\n\n"
        "| a table | is not | counted |\n\n```sh\nnor is code. It never is.\n```\n\n"
        "- An item of a list is\n  a sentence; by T. Pang, e.g. this one.\n- Another."
    )
    assert [(sentence.line, sentence.words) for sentence in prose_text.sentences(text)] == [(3, 7), (7, 4), (15, 14), (17, 1)]


def test_check_of_sentences_finds_the_long_one(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Short.\n\n" + "long " * 36 + "end. " + "Short. " * 9 + "\n", encoding="utf-8")
    (fault,) = prose_text.faults(page, "page.md")
    assert fault.startswith("page.md:3: 37 words")


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "decisions").glob("0*.md")), ids=lambda page: page.name)
def test_decisions_say_when_to_think_again(page: Path) -> None:
    assert "**When to think again.**" in page.read_text(encoding="utf-8")
    assert f"]({page.name})" in (page.parent / "README.md").read_text(encoding="utf-8"), "not in the index"


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "lab").glob("[!R]*.md")), ids=lambda page: page.name)
def test_lab_pages_say_how_to_run_and_when_to_look_again(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "**Run.**" in text and re.search(r"`(stiction|bench/)", text)
    assert re.search(r"\*\*(Again if|What came of it|What it taught)", text)
    assert f"]({page.name})" in (page.parent / "README.md").read_text(encoding="utf-8"), "not in the index"


def test_front_page_is_read_in_minutes_and_begins_with_a_picture() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.split()) <= 900
    picture = re.match(r"# stiction\n\n!\[[^\]]+\]\(([^)]+)\)\n", text)
    assert picture and (ROOT / picture.group(1)).stat().st_size <= 3_000_000


SOURCES = sorted(
    path
    for folder in ("src", "apps", "tests", "bench", "python", "experiments", "tasks")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in (".hpp", ".cpp", ".py", ".pyi", ".yaml", ".json") and "__pycache__" not in path.parts
)


def test_pages_and_equations_that_the_code_cites_are_there() -> None:
    pages = "".join(path.read_text(encoding="utf-8") for folder in ("theory", "lab") for path in (ROOT / "docs" / folder).glob("*.md"))
    labels = set(re.findall(r"[A-Z]\.\d+", pages))
    cited = 0
    for source in SOURCES:
        text = source.read_text(encoding="utf-8")
        for page in re.findall(r"docs/(?:theory|decisions|lab)/[A-Za-z0-9_-]+\.md", text):
            assert (ROOT / page).exists(), f"{relative(source)}: {page}"
        for label in re.findall(r"\(([STPENMDFL]\.\d+)\)", text) if source.suffix in (".hpp", ".cpp") else []:
            assert label in labels, f"{relative(source)}: equation ({label})"
            cited += 1
    assert cited > 20


def test_cpp_tests_write_into_folders_of_their_own() -> None:
    """They run side by side: a place with a fixed name is removed by one test while another reads from it."""
    for source in (ROOT / "tests").rglob("*.?pp"):
        if source.name != "temporary_folder.hpp":
            assert not re.search(r"TempDir\(|temp_directory_path", source.read_text(encoding="utf-8")), relative(source)


@pytest.mark.parametrize("script", sorted(path for folder in ("bench", "scripts") for path in (ROOT / folder).glob("*.py")), ids=relative)
def test_scripts_start_by_their_name(script: Path) -> None:
    """The pages call them `bench/NAME.py`."""
    text = script.read_text(encoding="utf-8")
    if "__main__" in text:
        assert text.startswith("#!/usr/bin/env python3\n")
        assert os.access(script, os.X_OK), "chmod +x, and commit the mode"


LAYERS = sorted(path.parent for path in (ROOT / "src" / "stiction").glob("*/CMakeLists.txt"))


@pytest.mark.parametrize("layer", LAYERS, ids=lambda layer: layer.name)
def test_every_layer_says_what_it_is_for_and_what_it_may_use(layer: Path) -> None:
    readme = (layer / "README.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([A-Za-z0-9_/]+\.[hc]pp)`", readme))
    assert not [name for name in named if not any((folder / name).exists() for folder in (layer, layer.parent, ROOT))], "names a file that is not there"
    assert not {str(path.relative_to(layer)) for path in layer.rglob("*.hpp")} - named, "leaves out a header"
    uses = re.search(r"\bUSES\s+((?:[a-z]+\s*)+)", (layer / "CMakeLists.txt").read_text())
    for name in uses.group(1).split() if uses else []:
        assert f"`{name}`" in readme, f"does not say that it may use {name}"


def test_changelog_starts_with_unreleased_changes_and_knows_the_version() -> None:
    versions = re.findall(r"^## \[([^\]]+)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert versions[0] == "Unreleased"
    assert re.fullmatch(r"\d+\.\d+\.\d+", (ROOT / "VERSION").read_text().strip())


@pytest.mark.parametrize("name", ["requirements", "requirements-experiments", "requirements-docs"])
def test_lock_holds_every_requirement_with_hashes_and_no_source(name: str) -> None:
    def normal(name: str) -> str:
        return re.sub(r"[-_.]+", "-", name).lower()

    lock = (ROOT / f"{name}.lock").read_text()
    assert not re.search(r"https?:|--index|--extra-index|--find-links|--trusted", lock)
    entries = re.findall(r"^([A-Za-z0-9._-]+)==([^ ;]+) .*\\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n?)+)", lock, flags=re.MULTILINE)
    assert len(entries) == len(re.findall(r"^[A-Za-z]", lock, flags=re.MULTILINE))
    locked = {normal(name): version for name, version, _ in entries}
    for line in (ROOT / f"{name}.in").read_text().splitlines():
        wanted = line.split("#")[0].strip()
        if wanted:
            package, _, version = wanted.partition("==")
            assert normal(package) in locked, f"{package} is not in {name}.lock: run `make lock`"
            assert version in ("", locked[normal(package)])


def test_ci_runs_make_test_and_nothing_else() -> None:
    lines = [line for line in (ROOT / ".ci" / "run").read_text().splitlines() if line and not line.startswith("#")]
    assert lines == ["set -euo pipefail", 'cd "$(dirname "$0")/.."', "make test"]
