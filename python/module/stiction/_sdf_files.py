"""Files of an SDF: what it includes, the meshes that it names, and the packages where both are."""

from __future__ import annotations

import copy
import io
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ._core import InvalidInput
from ._extras import require

LEFT_OUT = ("visual", "sensor", "plugin", "light", "gui", "scene", "physics", "gravity", "magnetic_field", "atmosphere", "spherical_coordinates", "wind", "audio")
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
DEEPEST = 100  # elements in each other; nested models have four each


def is_deep(root: ET.Element) -> bool:
    """More elements are in each other than a scene has, and than copying and writing them bears."""
    level = [root]
    for _ in range(DEEPEST):
        level = [child for element in level for child in element]
    return bool(level)


def folders_of_models(source: Path, package_dirs: Sequence[Path]) -> dict[str, Path]:
    """Folders that an URI may name; those of package_dirs go first, then the nearest."""
    out: dict[str, Path] = {}
    above = source.resolve().parent
    for place in [*package_dirs, above, *list(above.parents)[:2]]:
        for config in [*sorted(place.glob("*/model.config")), *sorted(place.glob("*/package.xml")), place / "model.config"]:
            if config.is_file():
                out.setdefault(config.parent.resolve().name, config.parent.resolve())
    return out


class Files:
    """Copies of an SDF and of what it includes, with absolute paths, and without what only a simulator uses."""

    def __init__(self, folders: dict[str, Path], temporary: Path) -> None:
        self.folders, self.temporary = folders, temporary
        self.copies: dict[Path, Path] = {}
        self.texts: dict[Path, ET.Element] = {}  # as they are written
        self.meshes: dict[str, Path] = {}  # by what stands in for them
        self.open: list[Path] = []  # each includes the next one

    def add(self, file: Path) -> Path:
        """The copy of a file."""
        path = file.resolve()
        if path in self.open:  # Drake would never come back
            raise InvalidInput(f"{file}: include: got a file that includes itself, by {', '.join(other.name for other in self.open)}, expected one that ends")
        if path in self.copies:
            return self.copies[path]
        root = self._read(file)
        self.open.append(path)
        self.texts[path] = copy.deepcopy(root)
        self.copies[path] = self.temporary / f"{len(self.copies)}.sdf"
        for element in list(root.iter()):
            for child in [child for child in element if child.tag in LEFT_OUT]:
                element.remove(child)
        included = {uri for include in root.iter("include") for uri in include.findall("uri")}
        for uri in root.iter("uri"):
            found = self._find(uri.text or "", file)
            if uri not in included and not found.is_file():
                raise InvalidInput(f"{file}: uri: got '{uri.text}', which is a folder, expected a mesh")
            uri.text = str(self.add(model_in(found)) if uri in included else self._stand_in(found))
        self.copies[path].write_bytes(ET.tostring(root, encoding="utf-8"))
        self.open.pop()
        return self.copies[path]

    def _stand_in(self, mesh: Path) -> Path:
        """A mesh for Drake, which needs no more than that there is one, and does not read all formats."""
        made = self.temporary / f"mesh_{len(self.meshes)}.obj"
        made.write_text(TETRAHEDRON)
        self.meshes[str(made)] = mesh
        return made

    def name(self, message: str) -> str:
        """What Drake says, with the names of the files themselves."""
        for path, made in self.copies.items():
            message = message.replace(f"/{made}", str(path)).replace(str(made), str(path))
        return message

    @staticmethod
    def _read(file: Path) -> ET.Element:
        if not file.is_file():
            raise InvalidInput(f"{file}: sdf: got a file that does not exist, expected an SDF")
        try:
            root = ET.parse(file, ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))).getroot()  # lines keep their numbers
        except (ET.ParseError, ValueError, LookupError) as error:  # or an encoding that is not known
            raise InvalidInput(f"{file}: sdf: got malformed XML ({error}), expected an SDF") from None
        if root.tag != "sdf":
            raise InvalidInput(f"{file}: root element: got '{root.tag}', expected 'sdf'")
        if is_deep(root):
            raise InvalidInput(f"{file}: sdf: got more than {DEEPEST} elements in each other, expected fewer")
        return root

    def _find(self, uri: str, file: Path) -> Path:
        scheme, mark, rest = uri.strip().partition("://")
        if not mark:
            found = file.resolve().parent / scheme
        elif scheme == "file":
            found = file.resolve().parent / rest
        elif scheme in ("model", "package"):
            name, _, below = rest.partition("/")
            if name not in self.folders:
                known = ", ".join(sorted(self.folders)) or "none"
                raise InvalidInput(f"{file}: uri: got '{uri}', expected a folder with a model.config or package.xml near the file, or package_dirs; there are: {known}")
            found = self.folders[name] / below
        else:
            raise InvalidInput(f"{file}: uri: got '{uri}', expected model://, package://, file:// or a path: nothing is fetched from elsewhere")
        if not found.exists():
            raise InvalidInput(f"{file}: uri: got '{uri}', so {found}, which does not exist, expected a file")
        return found


def model_in(place: Path) -> Path:
    """The SDF of a model: the file, or the newest that the model.config of the folder names."""
    if place.is_file():
        return place
    config = place / "model.config"
    try:
        versions = ET.parse(config).getroot().findall("sdf") if config.is_file() else []
        newest = max(versions, key=lambda sdf: [int(part) for part in (sdf.get("version") or "0").split(".")], default=None)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise InvalidInput(f"{config}: got what cannot be read ({error}), expected XML with <sdf version=\"1.9\">") from None
    return place / (newest.text or "" if newest is not None else "model.sdf").strip()


def load_mesh(path: Path) -> Any:
    """A mesh of a format that MuJoCo does not read, in metres."""
    trimesh = require("sdf", f"{path}", "trimesh")
    if path.suffix.lower() == ".dae":
        require("sdf", f"{path}", "collada")
    try:
        if path.suffix.lower() == ".gltf":
            mesh = trimesh.load_mesh(path)
        else:  # alone: pictures that it names are not looked for
            mesh = trimesh.load_mesh(io.BytesIO(path.read_bytes()), file_type=path.suffix[1:].lower())
        if mesh.units is not None:  # of a DAE, as "0.01 * meters"
            mesh.convert_units("meters")
        bare = trimesh.Trimesh(mesh.vertices, mesh.faces)
    except Exception as error:  # the readers of others raise whatever they meet
        raise InvalidInput(f"{path}: got a mesh that cannot be read ({error or type(error).__name__}), expected OBJ, STL, DAE or GLB") from None
    if len(bare.faces) == 0:
        raise InvalidInput(f"{path}: got a mesh without triangles, expected some")
    return bare
