"""What mkdocs does not do by itself for the site: pages for what docs/ links to outside of it, the output of the tutorials' commands, and notebooks."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))

import gallery  # noqa: E402
import notebooks  # noqa: E402

DOCS = ROOT / "docs"
# How much a page counts in the search: answers before records of what was decided and measured.
BOOST = {"answers.md": 4, "commands.md": 3, "theory": 2, "tutorials": 2, "scenes.md": 2, "decisions": 0.3, "lab": 0.3, "reproduction": 0.3, "code": 0.3}
GALLERY = "<!-- gallery -->"
LINK = re.compile(r"\]\(([^)\s]+)\)")
LANGUAGES = {".hpp": "cpp", ".cpp": "cpp", ".py": "python", ".pyi": "python", ".yaml": "yaml", ".json": "json", ".urdf": "xml", ".xml": "xml"}
# Sections of the site in order: title, and the pages (with another title than their own where they need it), or the folder whose README says the order.
SECTIONS = [
    ("Start", ["index.md", {"Install, figures, limits": "code/README.md"}, "which_tool.md", "answers.md", "roadmap.md", "code/CHANGELOG.md", "code/CONTRIBUTING.md"]),
    # As a newcomer wants them.
    ("Tutorials", ["tutorials/own_robot_and_object.md", "tutorials/studio.md", "studio_scenes.md", "scenes.md", "tutorials/ros2_control.md", "tutorials/where_was_my_robot_touched.md", "guarded_moves.md", "several_objects.md", "learning.md", "demonstrations.md"]),
    ("Notebooks", ["notebooks/README.md", *(f"notebooks/{file.stem}.md" for file in sorted((DOCS / "notebooks").glob("*.ipynb")))]),
    ("Reference", ["commands.md", "options.md", {"Python by command": "code/python/README.md"}, "python.md", "headers.md", "notation.md", "plan_file.md", "exports.md", "streams.md", "sweeps.md", "code/scenarios/README.md"]),
    ("Theory", "theory"),
    ("Figures of the thesis", "reproduction"),
    ("How well it works", ["benchmarks.md", "benchmark.md", "benchmark_failures.md"]),
    ("Decisions", "decisions"),
    ("Lab", "lab"),
]


def page_of(target: Path) -> str:
    """The page of a file of the repository, or of a folder's README."""
    if target.is_dir():
        target = target / "README.md"
    if target.is_relative_to(DOCS):
        return (target.with_suffix(".md") if target.suffix == ".ipynb" else target).relative_to(DOCS).as_posix()
    name = target.relative_to(ROOT).as_posix()
    return f"code/{name}" if name.endswith(".md") else f"code/{name}.md"


def without_blocks(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def linked_files(document: Path) -> set[Path]:
    """What a page links to outside of docs/."""
    found = set()
    for target in LINK.findall(without_blocks(document.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", target) or target.startswith("#"):
            continue
        file = (document.parent / target.split("#")[0]).resolve()
        if file.is_dir():
            file = file / "README.md"
        if file.is_file() and file.is_relative_to(ROOT) and not file.is_relative_to(DOCS):
            found.add(file)
    return found


def rewrite_links(text: str, document: Path, page: str) -> str:
    """Links between files of the repository become links between pages."""

    def replace(match: re.Match[str]) -> str:
        target, _, anchor = match.group(1).partition("#")
        if not target or re.match(r"[a-z]+:", target):
            return match.group(0)
        file = (document.parent / target).resolve()
        if file.is_relative_to(DOCS) and file.suffix not in (".md", ".ipynb", "") and document.is_relative_to(DOCS):
            return match.group(0)  # a picture, a file beside the page
        relative = os.path.relpath(page_of(file), os.path.dirname(page) or ".")
        return f"]({relative}{'#' + anchor if anchor else ''})"

    # Code between backticks and blocks keeps what it has.
    parts = re.split(r"(^```.*?^```)", text, flags=re.DOTALL | re.MULTILINE)
    return "".join(part if part.startswith("```") else LINK.sub(replace, part) for part in parts)


def code_page(file: Path) -> str:
    name = file.relative_to(ROOT).as_posix()
    language = LANGUAGES.get(file.suffix, "text")
    return f"---\nsearch: {{exclude: true}}\n---\n# {file.name}\n\n`{name}`\n\n~~~~{language}\n{file.read_text(encoding='utf-8')}\n~~~~\n"


def summary_of(header: Path) -> str:
    """The first sentence of the first comment of a header that says what something is."""
    comment = re.search(r"((?:^/// .*\n)+)", header.read_text(encoding="utf-8"), flags=re.MULTILINE)
    text = " ".join(re.findall(r"^/// (.*)$", comment.group(1), flags=re.MULTILINE)) if comment else ""
    text = re.split(r"@param|@throws|@returns|Tests:|Limits:", text)[0]
    return re.split(r"(?<=[.:]) ", text.strip())[0].rstrip(":").replace("<", "&lt;").replace("|", "\\|")


def headers_page() -> str:
    """Every public header with what it declares first."""
    lines = ["# C++ reference", "", "Link to `stiction::LAYER` after `find_package(stiction)`, and include `stiction/LAYER/FILE.hpp`. A layer uses only those above it in this list."]
    layers = re.search(r"set\(STICTION_LAYERS ([^)]*)\)", (ROOT / "cmake/layers.cmake").read_text(encoding="utf-8"))
    assert layers
    for layer in layers.group(1).split():
        folder = ROOT / "src/stiction" / layer
        lines += ["", f"## {layer}", "", f"[What it does](code/src/stiction/{layer}/README.md)", ""]
        lines += ["| header | its first declaration |", "|---|---|"]
        lines += [f"| [{file.relative_to(folder).as_posix()}]({page_of(file)}) | {summary_of(file)} |" for file in sorted(folder.rglob("*.hpp"))]
    return "\n".join(lines) + "\n"


# ---- mkdocs calls these ----


def on_files(files: Files, config: object) -> Files:
    documents = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "python/README.md")]
    wanted = set(documents) | set((ROOT / "src/stiction").rglob("*.hpp")) | set((ROOT / "src/stiction").glob("*/README.md"))
    wanted.add(ROOT / "scenarios/README.md")
    todo = [*wanted, *DOCS.rglob("*.md")]
    while todo:
        document = todo.pop()
        if document.suffix == ".md":
            new = linked_files(document) - wanted
            wanted |= new
            todo += new
    for file in sorted(wanted):
        page = page_of(file)
        text = rewrite_links(file.read_text(encoding="utf-8"), file, page) if file.suffix == ".md" else code_page(file)
        files.append(File.generated(config, page, content=text))
    files.append(File.generated(config, "headers.md", content=headers_page()))
    files.append(File.generated(config, "python.md", content="# Python\n\n::: stiction._core\n"))
    for notebook in sorted((DOCS / "notebooks").glob("*.ipynb")):
        files_of_notebook(notebook, files, config)
    # Pages of plans, made by scripts/docs.sh.
    for plan in sorted((ROOT / "build/docs/plans").glob("*.*")):
        files.append(File.generated(config, f"plans/{plan.name}", abs_src_path=str(plan)))
    return files


def on_config(config: dict) -> dict:
    nav: list[dict] = []
    for title, pages in SECTIONS:
        if isinstance(pages, str):
            folder = DOCS / pages
            index = folder / "README.md"
            order = [t for t in LINK.findall(index.read_text(encoding="utf-8")) if re.fullmatch(r"[\w.-]+\.md", t)] if index.exists() else []
            names = [*dict.fromkeys(order), *sorted(f.name for f in folder.glob("*.md") if f.name not in order and f.name != "README.md")]
            pages = ([f"{pages}/README.md"] if index.exists() else []) + [f"{pages}/{name}" for name in names]
        nav.append({title: pages})
    config["nav"] = nav
    return config


def on_page_markdown(markdown: str, page: object, config: object, files: Files) -> str:
    uri = page.file.src_uri
    document = DOCS / uri
    page.meta.setdefault("search", {}).setdefault("boost", BOOST.get(uri.split("/")[0], 1))
    if not document.exists():
        return markdown
    if uri.startswith("tutorials/"):
        markdown = with_outputs(markdown, uri)
    markdown = markdown.replace(GALLERY, gallery.markup())
    return rewrite_links(markdown, document, uri)


# ---- notebooks ----


def files_of_notebook(notebook: Path, files: Files, config: object) -> None:
    """Its page, with what its cells show, and the pages of plans in it."""
    page = page_of(notebook)
    text, pages = notebooks.to_markdown(notebook, outputs_of_notebook(notebook))
    download = f"\n[This page as a notebook]({notebook.name})\n"
    files.append(File.generated(config, page, content=rewrite_links(text, notebook, page) + download))
    for name, content in pages.items():
        files.append(File.generated(config, f"notebooks/{name}", content=content))


def outputs_of_notebook(notebook: Path) -> list[dict[str, str]]:
    """Of every code cell; those of the last build where nothing has changed."""
    file = ROOT / "build/docs/outputs/notebooks" / f"{notebook.stem}.json"
    key = fingerprint(notebook.read_text(encoding="utf-8"))
    if not file.exists() or json.loads(file.read_text(encoding="utf-8"))["key"] != key:
        with tempfile.TemporaryDirectory() as name:
            shown = Path(name) / "outputs.json"
            execute([sys.executable, str(ROOT / "scripts/notebooks.py"), str(notebook), "--json", str(shown)], Path(name), f"notebooks/{notebook.name}")
            outputs = json.loads(shown.read_text(encoding="utf-8"))
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({"key": key, "outputs": outputs}), encoding="utf-8")
    return list(json.loads(file.read_text(encoding="utf-8"))["outputs"])


# ---- tutorials ----


BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
SAVED = re.compile(r'^```[a-z]+ title="([^"]+)"\n(.*?)^```', flags=re.DOTALL | re.MULTILINE)  # what a reader saves as a file


def with_outputs(markdown: str, uri: str) -> str:
    """Puts beneath the commands and the Python of a tutorial what they print."""
    outputs = iter(outputs_of(markdown, uri))

    def add(match: re.Match[str]) -> str:
        output = next(outputs)
        return match.group(0) + (f"\n\n??? example \"What it prints\"\n\n    ```text\n{indent(output)}    ```\n" if output.strip() else "")

    return BLOCK.sub(add, markdown)


def outputs_of(markdown: str, uri: str) -> list[str]:
    """Of every block. Those of the last build are taken where neither the page nor anything that its commands read has changed."""
    file = ROOT / "build/docs/outputs" / f"{uri}.json"
    key = fingerprint(markdown)
    if file.exists():
        kept = json.loads(file.read_text(encoding="utf-8"))
        if kept["key"] == key:
            return list(kept["outputs"])
    outputs = run_blocks(markdown, uri)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps({"key": key, "outputs": outputs}), encoding="utf-8")
    return outputs


@functools.cache
def digest_of_inputs() -> str:
    """The program, the module, and the data that tutorials name."""
    built = [ROOT / "build/release/stiction", *(ROOT / "build/release/python/stiction").glob("*.*")]
    data = [f for folder in ("docs/tutorials", "tasks", "models", "scenarios") for f in (ROOT / folder).rglob("*")]
    digest = hashlib.sha256()
    for path in sorted(f for f in built + data if f.is_file()):
        digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def fingerprint(markdown: str) -> str:
    return hashlib.sha256((digest_of_inputs() + markdown).encode()).hexdigest()


def run_blocks(markdown: str, uri: str) -> list[str]:
    """Runs a page's blocks in order, in a folder that has the files of the page, those beside it, and looks like the repository besides."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for saved, text in SAVED.findall(markdown):
            (folder / saved).write_text(text, encoding="utf-8")
        beside = [file for file in (DOCS / uri).parent.iterdir() if file.is_file() and file.suffix != ".md"]
        for entry in [*beside, *ROOT.iterdir()]:
            if entry.name not in ("out", "demo-out", ".git") and not (folder / entry.name).exists():
                (folder / entry.name).symlink_to(entry)

        def run(language: str, code: str) -> str:
            if language == "sh":
                lines = [line for line in code.splitlines() if line.startswith("stiction ")]
                return "".join(f"$ {line}\n{execute([str(ROOT / 'build/release/stiction'), *shlex.split(line)[1:]], folder, uri)}" for line in lines)
            return execute([sys.executable, "-c", code], folder, uri)

        return [run(match.group(1), match.group(2)) for match in BLOCK.finditer(markdown)]


def execute(words: list[str], folder: Path, uri: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "build/release/python")}
    done = subprocess.run(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)
    if done.returncode:
        raise PluginError(f"docs/{uri}: {shlex.join(words)} ended with {done.returncode}: {done.stderr}")
    lines = [line if len(line) <= 200 else line[:200] + " …" for line in done.stdout.splitlines()]
    return "\n".join(lines[:40] + (["…"] if len(lines) > 40 else [])) + "\n"


def indent(text: str) -> str:
    return "".join(f"    {line}\n" for line in text.splitlines())
