"""Files that come from the browser: looked at, never run, kept in one temporary folder, and nothing outside it is read for them."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from stiction.sdf import DEEPEST, LEFT_OUT, is_deep

MAX_BYTES = 20_000_000  # of one file
MAX_TOTAL = 200_000_000  # of all of them
ROBOTS = {".urdf": "URDF", ".xml": "MJCF", ".mjcf": "MJCF", ".sdf": "SDF"}
MESHES = (".stl", ".obj", ".dae")
EXPECTED = "a URDF (.urdf), an MJCF (.xml, .mjcf), an SDF (.sdf) or a mesh (.stl, .obj, .dae)"
ARCHIVES = ((b"PK\x03\x04", "zip"), (b"PK\x05\x06", "zip"), (b"\x1f\x8b", "gzip"), (b"BZh", "bzip2"), (b"\xfd7zXZ", "xz"), (b"7z\xbc\xaf", "7z"))


class Refused(ValueError):
    """A file that is not taken; the message says which, what was found and what is expected."""


def megabytes(count: int) -> str:
    return f"{count / 1e6:.3g} MB"


def check_size(name: str, size: int) -> None:
    """Raises Refused. Asked before a byte of the file is kept."""
    if size > MAX_BYTES:
        raise Refused(f"{name}: got {megabytes(size)}, expected at most {megabytes(MAX_BYTES)}")
    if size <= 0:
        raise Refused(f"{name}: got an empty file, expected {EXPECTED}")


def check_total(size: int) -> None:
    """Of all files together. Raises Refused."""
    if size > MAX_TOTAL:
        raise Refused(f"files: got {megabytes(size)} in all, expected at most {megabytes(MAX_TOTAL)}")


def check_name(name: str) -> str:
    """A plain file name with a suffix that is known. Raises Refused."""
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_. +-]{0,100}", name):
        raise Refused(f"{name[:60]!r}: got a name with a path or unusual letters, expected letters, digits, '.', '_', '-'")
    suffix = PurePosixPath(name).suffix.lower()
    if suffix not in ROBOTS and suffix not in MESHES:
        raise Refused(f"{name}: got a file of type {suffix or 'nothing'!r}, expected {EXPECTED}")
    return name


def check_content(name: str, content: bytes) -> None:
    """The content is what the name says, and no archive. Raises Refused."""
    for magic, kind in ARCHIVES:
        if content.startswith(magic):
            raise Refused(f"{name}: got a {kind} archive, expected {EXPECTED}; unpack it and drop its files")
    if PurePosixPath(name).suffix.lower() in (*ROBOTS, ".dae"):
        parse(name, content)


def parse(name: str, content: bytes) -> ET.Element:
    """Its root element. Raises Refused; also for what makes a parser read or blow up elsewhere."""
    if re.search(rb"<!(DOCTYPE|ENTITY)", content, flags=re.IGNORECASE):
        raise Refused(f"{name}: got a document type or entities, expected plain XML")
    try:
        return ET.fromstring(content)
    except ET.ParseError as error:
        raise Refused(f"{name}: no XML ({error})") from None


def is_sdf(name: str) -> bool:
    return PurePosixPath(name).suffix.lower() == ".sdf"


def references(root: ET.Element) -> Iterator[tuple[str, str]]:
    """Element and path of every file that a robot file names."""
    folders = {"mesh": "", "texture": ""}
    for element in root.iter("compiler"):
        folders["mesh"] = element.get("meshdir") or element.get("assetdir") or folders["mesh"]
        folders["texture"] = element.get("texturedir") or element.get("assetdir") or folders["texture"]
    for element in root.iter():
        for key in ("filename", "file", "meshdir", "texturedir", "assetdir"):
            value = element.get(key)
            if not value:
                continue
            inside = folders.get(element.tag, "") if key == "file" and root.tag == "mujoco" else ""
            yield element.tag, f"{inside}/{value}" if inside and key == "file" else value


def inside(name: str, element: str, uri: str) -> PurePosixPath:
    """The path of a reference below the folder of the robot file. Raises Refused where it leads out of it."""
    rest = re.sub(r"^package:/*", "", uri)
    rest = rest.removeprefix("./")
    path = PurePosixPath(rest)
    if "://" in rest or rest.startswith(("file:", "/", "~")) or ".." in path.parts or "\\" in rest or not path.parts:
        raise Refused(f"{name}: {element}: got '{uri}', expected a path below the file, without '..'")
    return path


def inside_sdf(name: str, uri: ET.Element) -> PurePosixPath:
    """As inside(); each scheme is a folder beside the file. Raises Refused."""
    given = (uri.text or "").strip()
    path = inside(name, "uri", re.sub(r"^(model|package|file)://", "", given))
    if path.suffix.lower() not in MESHES:
        raise Refused(f"{name}: uri: got '{given}', expected a mesh ({', '.join(MESHES)})")
    return path


def used(root: ET.Element) -> Iterator[ET.Element]:
    """What an SDF has, without what is left out of its MJCF."""
    open_ = [root]
    while open_:
        yield (found := open_.pop())
        open_ += [child for child in reversed(found) if child.tag not in LEFT_OUT]


def meshes_of_sdf(name: str, root: ET.Element) -> list[tuple[ET.Element, PurePosixPath]]:
    """Each <uri> that is used, with its path below the folder of the file. Raises Refused: a part of it is in another file."""
    if root.tag != "sdf":
        raise Refused(f"{name}: root element: got '{root.tag}', expected 'sdf'")
    if is_deep(root):
        raise Refused(f"{name}: got more than {DEEPEST} elements in each other, expected fewer")
    elements = list(used(root))
    for include in (element for element in elements if element.tag == "include"):
        raise Refused(f"{name}: got the model '{(include.findtext('uri') or '').strip()}' inside it, expected one file that holds the whole robot; `stiction studio {name}` opens it with its models")
    return [(element, inside_sdf(name, element)) for element in elements if element.tag == "uri"]


def wanted(robot: str, content: bytes) -> list[PurePosixPath]:
    """Meshes that a robot names, below its folder. Raises Refused: one lies outside, or a part of the robot is in another file."""
    if is_sdf(robot):
        return [path for _, path in meshes_of_sdf(robot, parse(robot, content))]
    kinds = {"mesh", "texture", "include", "hfield", "model", "skin", "flexcomp"}
    found = [(element, inside(robot, element, uri)) for element, uri in references(parse(robot, content))]
    paths = [path for element, path in found if element in kinds and path.suffix]
    for path in paths:
        if path.suffix.lower() in ROBOTS:
            raise Refused(f"{robot}: got the file '{path}' inside it, expected one file that holds the whole robot")
    return [path for path in paths if path.suffix.lower() in MESHES]


def alone(name: str, content: bytes) -> bytes:
    """The content without what a reader would look for elsewhere: packages become folders beside it, materials of an OBJ are left out."""
    suffix = PurePosixPath(name).suffix.lower()
    if is_sdf(name):
        root = parse(name, content)
        for uri, path in meshes_of_sdf(name, root):
            uri.text = str(path)
        return ET.tostring(root, encoding="utf-8")
    if suffix in ROBOTS:
        return re.sub(rb"package:/*", b"", content)
    return re.sub(rb"(?m)^[ \t]*mtllib[^\n]*", b"", content) if suffix == ".obj" else content


@dataclass
class Uploads:
    """What was taken, in `folder`."""

    folder: Path
    contents: dict[str, bytes] = field(default_factory=dict)

    def add(self, name: str, content: bytes) -> str:
        """Keeps a file under its name. Raises Refused."""
        check_size(name, len(content))
        check_name(name)
        check_content(name, content)
        check_total(len(content) + sum(len(c) for n, c in self.contents.items() if n != name))
        if PurePosixPath(name).suffix.lower() in ROBOTS:
            wanted(name, content)
        self.contents[name] = content
        return name

    def robots(self) -> list[str]:
        return [n for n in self.contents if PurePosixPath(n).suffix.lower() in ROBOTS]

    def meshes(self) -> list[str]:
        return [n for n in self.contents if PurePosixPath(n).suffix.lower() in MESHES]

    def missing(self, robot: str) -> list[str]:
        """Files that a robot names and that were not dropped."""
        return sorted({path.name for path in wanted(robot, self.contents[robot]) if path.name not in self.contents})

    def write_robot(self, robot: str) -> Path:
        """Writes a robot with its meshes where it looks for them, and nothing else. Raises Refused: files are missing."""
        if missing := self.missing(robot):
            raise Refused(f"{robot}: names {', '.join(missing)}, which {'was' if len(missing) == 1 else 'were'} not dropped; drop {'it' if len(missing) == 1 else 'them'} as well")
        for path in wanted(robot, self.contents[robot]):
            self._write(self.folder / path, alone(path.name, self.contents[path.name]))
        return self._write(self.folder / robot, alone(robot, self.contents[robot]))

    def write_mesh(self, mesh: str) -> Path:
        return self._write(self.folder / mesh, alone(mesh, self.contents[mesh]))

    def _write(self, file: Path, content: bytes) -> Path:
        home = self.folder.resolve()
        if not file.resolve().is_relative_to(home):  # whatever the checks before let through
            raise Refused(f"{file.name}: leads out of the folder of uploads")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
        return file
