"""Files of an SDF: what it includes, the meshes that it names, and the packages where both are."""

from __future__ import annotations

import copy
import io
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ._core import InvalidInput
from ._extras import require

LEFT_OUT = ("state", "visual", "sensor", "plugin", "light", "gui", "scene", "physics", "gravity", "magnetic_field", "atmosphere", "spherical_coordinates", "wind", "audio")
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
DEEPEST = 100  # elements in each other; nested models have four each
UNREAD = {"world": ("state",), "link": ("gravity",), "collision": ("submesh", "torsional", "collide_bitmask", "collide_without_contact", "mu2")}  # that act in Gazebo


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
        self.unread: dict[str, list[str]] = {}  # names of what has an element of UNREAD

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
        self._note_unread(root)
        for friction in root.iter("ode"):  # Drake takes the second direction for sliding, and no more friction of it than at rest
            for second in friction.findall("mu2"):
                friction.remove(second)
            if (first := friction.find("mu")) is not None:
                ET.SubElement(friction, "mu2").text = first.text
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

    def _note_unread(self, root: ET.Element) -> None:
        for owner, tags in UNREAD.items():
            for element in root.iter(owner):
                for tag in tags:
                    found = [child for child in element.iter(tag) if owner != "world" or child in element]
                    if tag == "gravity":  # on unless it says otherwise
                        found = [child for child in found if (child.text or "").strip() in ("0", "false")]
                    if tag == "mu2":
                        found = [child for ode in element.iter("ode") for child in ode.findall(tag) if (child.text or "").strip() != (ode.findtext("mu") or "1").strip()]
                    if found:
                        self.unread.setdefault(f"<{tag}> of {owner}s", []).append(element.get("name", ""))

    def notes(self) -> list[str]:
        parts = [f"{what} {', '.join(dict.fromkeys(names))}" for what, names in self.unread.items()]
        return [f"not read: {'; '.join(parts)}"] if parts else []

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
        if root.get("version") is None:
            raise InvalidInput(f'{file}: sdf: got no version, expected one, as in <sdf version="1.9">')
        _check_inertials(root, file)
        return root

    def _find(self, uri: str, file: Path) -> Path:
        """As the URI is written, or with %20 and the like decoded, or with the '\\' of another system."""
        decoded = unquote(uri)
        places = [self._place(text, file) for text in dict.fromkeys((uri, decoded, decoded.replace("\\", "/")))]
        found = next((place for place in places if place.exists()), None)
        if found is None:
            raise InvalidInput(f"{file}: uri: got '{uri}', so {places[0]}, which does not exist, expected a file")
        return found

    def _place(self, uri: str, file: Path) -> Path:
        scheme, mark, rest = uri.strip().partition("://")
        if not mark:
            return file.resolve().parent / scheme
        if scheme == "file":
            return file.resolve().parent / rest
        if scheme in ("model", "package"):
            name, _, below = rest.partition("/")
            if name not in self.folders:
                known = ", ".join(sorted(self.folders)) or "none"
                raise InvalidInput(f"{file}: uri: got '{uri}', expected a folder with a model.config or package.xml near the file, or package_dirs; there are: {known}")
            return self.folders[name] / below
        raise InvalidInput(f"{file}: uri: got '{uri}', expected model://, package://, file:// or a path: nothing is fetched from elsewhere")


def _check_inertials(root: ET.Element, file: Path) -> None:
    """Drake names neither the link nor the number, and gives a link of no mass 1 kg."""
    for link in root.iter("link"):
        for inertial in link.findall("inertial"):
            name, mass = link.get("name", ""), _number(inertial.findtext("mass"), 1.0)
            if not (math.isfinite(mass) and mass > 0):
                raise InvalidInput(f"{file}: link '{name}': got a mass of {inertial.findtext('mass')}, expected a number > 0")
            terms = inertial.find("inertia")
            if terms is None:
                continue
            xx, yy, zz, xy, xz, yz = (_number(terms.findtext(tag), 1.0 if tag[1] == tag[2] else 0.0) for tag in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
            matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            moments = np.linalg.eigvalsh(matrix) if np.isfinite(matrix).all() else np.full(3, np.nan)
            if not (moments[0] >= -1e-9 * abs(moments[2]) and moments[2] <= 1.01 * (moments[0] + moments[1])):
                raise InvalidInput(f"{file}: link '{name}': got an <inertia> that no body can have, expected moments > 0, none larger than the other two together")


def _number(text: str | None, default: float) -> float:
    try:
        return default if text is None else float(text)
    except ValueError:
        return math.nan


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
    with path.open("rb") as start:
        if start.read(40).startswith(b"version https://git-lfs.github.com"):
            raise InvalidInput(f"{path}: got a pointer of Git LFS, expected a mesh; `git lfs pull` fetches the file itself")
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
