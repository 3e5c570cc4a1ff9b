"""SDF files in the studio, without a browser: opened and dropped as an MJCF is. Without Drake the parser is stood in for; the last tests want it."""

from __future__ import annotations

import importlib.util
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import children
import numpy as np
import pytest

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402
from stiction import sdf  # noqa: E402
from studio_driven import Driven  # noqa: E402

from stiction_view.studio import catalog, uploads  # noqa: E402
from stiction_view.studio.app import Studio  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402

needs_drake = pytest.mark.skipif(importlib.util.find_spec("pydrake") is None, reason="Drake is not installed: `pip install 'stiction[sdf]'`")

# A finger on two slides, a drawer that it opens from behind, and a puck on a table.
MJCF = """<mujoco><worldbody>
  <geom name="table" type="plane" size="1 1 1"/>
  <body name="finger" pos="0 0 0.2"><joint name="x" type="slide" axis="1 0 0" range="-0.5 0.5"/><joint name="y" type="slide" axis="0 1 0" range="-0.5 0.5"/>
    <geom size="0.03" mass="0.2"/></body>
  <body name="drawer" pos="0.3 0 0.2"><joint name="rail" type="slide" axis="1 0 0" range="0 0.25"/><geom type="box" size="0.05 0.1 0.1" mass="0.5"/></body>
  <body name="puck" pos="0 0.2 0.02"><freejoint/><geom type="cylinder" size="0.04 0.02" mass="0.1"/></body>
</worldbody><actuator><position joint="x" kp="400"/><position joint="y" kp="400"/></actuator></mujoco>"""
INERTIAL = "<inertial><mass>{0}</mass><inertia><ixx>.001</ixx><iyy>.001</iyy><izz>.001</izz></inertia></inertial>"
BOX = "<collision name='c'><geometry><box><size>{0}</size></box></geometry></collision>"
SLIDE = (
    "<joint name='{0}' type='prismatic'><parent>{1}</parent><child>{2}</child><axis><xyz>{3}</xyz><limit><lower>{4}</lower><upper>{5}</upper><effort>{6}</effort></limit></axis></joint>"
)
FINGER = f"""<model name="hand"><pose>0 0 .2 0 0 0</pose>
  <link name="cart">{INERTIAL.format(0.2)}</link>{SLIDE.format("x", "world", "cart", "1 0 0", -0.5, 0.5, 40)}
  <link name="finger">{INERTIAL.format(0.2)}<visual name="v"><geometry><mesh><uri>model://shop/looks.glb</uri></mesh></geometry></visual>
    <collision name="c"><geometry>%s</geometry></collision></link>{SLIDE.format("y", "cart", "finger", "0 1 0", -0.5, 0.5, 40)}</model>"""
BALL = "<sphere><radius>.03</radius></sphere>"
SCENE = f"""<sdf version="1.9"><world name="w">{FINGER % BALL}
<model name="table"><static>true</static><link name="top"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="drawer"><pose>.3 0 .2 0 0 0</pose><link name="box">{BOX.format(".1 .2 .2")}</link>{SLIDE.format("rail", "world", "box", "1 0 0", 0, 0.25, 0)}</model>
<model name="puck"><pose>0 .2 .02 0 0 0</pose><link name="disc">{INERTIAL.format(0.1)}{BOX.format(".08 .08 .04")}</link></model></world></sdf>"""
ROBOT = f'<sdf version="1.9">{FINGER}</sdf>'
NOTE = "links without <inertial> weigh 1 kg: drawer"
WEDGE = b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@pytest.fixture
def no_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every SDF is the same scene, so that what comes after the parser is tested without it."""
    monkeypatch.setattr(sdf, "make_mjcf", lambda source, target=None, package_dirs=(): (sdf.MADE + b"a test -->\n" + MJCF.encode(), [NOTE]))
    monkeypatch.setitem(sys.modules, "pydrake", ModuleType("pydrake"))


@pytest.fixture
def without_drake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pydrake", None)


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Callable[[Path | None], Driven]]:
    """Opens a studio on a file; its folder is `studio`."""
    (folder := tmp_path / "studio").mkdir()
    servers = []

    def open_(shown: Path | None) -> Driven:
        entries, first = catalog.find(None if shown is None else str(shown))
        servers.append(serving("127.0.0.1", 0))
        driven = Driven(Studio(servers[-1].__enter__(), entries, None, folder))
        if shown is not None:
            driven.studio.desk.guarded(lambda: driven.studio.open(first))
        return driven

    yield open_
    for server in servers:
        server.__exit__(None, None, None)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "kitchen.sdf").write_text(SCENE)
    return tmp_path / "kitchen.sdf"


def check_scene(driven: Driven, scene: Path) -> None:
    """What was found is said, the goal goes to another object, and a shell makes it again from the SDF."""
    studio = driven.studio
    assert driven.said == []
    for words in ("Found in kitchen.sdf", "Robot: 2 joints (x, y)", "drawer (slider [0, 0.25])", "puck (free)"):
        assert words in driven.panel.head.about.content
    assert any("weigh 1 kg" in note for note in studio.posing.problem.notes) and driven.panel.head.notes_folder.visible
    assert not driven.panel.pose.keyframe.visible
    assert [file.name for file in scene.parent.iterdir() if file.is_file()] == ["kitchen.sdf"], "the MJCF is in the folder of the studio"
    driven.panel.pose.goal_of.value = "puck"
    driven.until(lambda: studio.posing.problem.goal_object == studio.posing.problem.model.object_names.index("puck"))
    assert f"stiction import {scene} --object puck -o kitchen_puck.yaml" in driven.panel.export.command.content
    assert driven.said == []


@pytest.mark.usefixtures("no_parser")
def test_sdf_opens_as_its_mjcf(opened: Callable[[Path | None], Driven], scene: Path) -> None:
    assert catalog.entry_of(scene).kind == catalog.SCENE
    check_scene(opened(scene), scene)


@pytest.mark.usefixtures("without_drake")
def test_without_drake_what_to_install_is_said_once(opened: Callable[[Path | None], Driven], scene: Path) -> None:
    driven = opened(scene)
    assert driven.said == ["SDF files: no Python module 'pydrake'; `pip install 'stiction[sdf]'` brings it"]
    assert driven.studio.posing.problem is None
    driven.press("upload", "arm.sdf", (ROBOT % BALL).encode())
    assert driven.said[1:] == ["arm.sdf: no Python module 'pydrake'; `pip install 'stiction[sdf]'` brings it"]
    assert driven.panel.own.uploaded.content == "No files yet."


def test_sdf_that_is_wrong_is_one_message(opened: Callable[[Path | None], Driven], scene: Path) -> None:
    scene.write_text("<sdf><world>")
    (said,) = opened(scene).said
    assert said.startswith(f"{scene}: sdf: got malformed XML (")
    assert list((scene.parent / "studio").iterdir()) == []


def test_robot_alone_is_named_by_its_sdf_and_sent_to_where_it_gets_an_object(opened: Callable[[Path | None], Driven], scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = MJCF[: MJCF.index('  <body name="drawer"')] + MJCF[MJCF.index("</worldbody>") :]
    monkeypatch.setattr(sdf, "make_mjcf", lambda source, target=None, package_dirs=(): (text.encode(), []))
    (said,) = opened(scene).said
    assert said.startswith(f"{scene}: import: got a file without an object") and said.endswith("A robot without objects is opened under 'Own', where it gets one")


@pytest.mark.usefixtures("no_parser")
def test_dropped_sdf_waits_for_its_meshes_and_gets_an_object(opened: Callable[[Path | None], Driven]) -> None:
    driven = opened(None)
    mesh = "<mesh><uri>model://shop/meshes/tip.obj</uri></mesh>"
    driven.press("upload", "arm.sdf", (ROBOT % mesh).encode())
    assert driven.panel.own.uploaded.content == "- arm.sdf, waits for tip.obj", "and not for what is only seen"
    driven.press("make")
    assert driven.said == ["arm.sdf: names tip.obj, which was not dropped; drop it as well"]
    driven.press("upload", "tip.obj", WEDGE)
    driven.press("make")
    assert len(driven.said) == 1, driven.said
    problem = driven.studio.posing.problem
    assert problem.model.joint_names[:2] == ["robot/x", "robot/y"] and "object" in problem.model.object_names
    assert NOTE in problem.notes
    folder = driven.studio.folder
    assert (folder / "shop/meshes/tip.obj").is_file() and (folder / "arm.xml").is_file()
    assert "<uri>shop/meshes/tip.obj</uri>" in (folder / "arm.sdf").read_text(), "no installed model is looked for"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROBOT % "<mesh><uri>../tip.stl</uri></mesh>", "uri: got '../tip.stl', expected a path below the file"),
        (ROBOT % "<mesh><uri>file:///etc/tip.stl</uri></mesh>", "expected a path below the file"),
        (ROBOT % "<mesh><uri>model://../tip.stl</uri></mesh>", "expected a path below the file"),
        (ROBOT % "<mesh><uri>https://host/tip.stl</uri></mesh>", "expected a path below the file"),
        (ROBOT % "<mesh><uri>&#109;odel:&#47;/../tip.stl</uri></mesh>", "expected a path below the file"),
        (ROBOT % "<mesh><uri>tip.glb</uri></mesh>", "uri: got 'tip.glb', expected a mesh (.stl, .obj, .dae)"),
        (ROBOT % "<mesh/><heightmap><uri/></heightmap>", "uri: got '', expected"),
        ("<sdf><include><uri>model://peg</uri></include></sdf>", "got the model 'model://peg' inside it, expected one file that holds the whole robot; `stiction studio arm.sdf` opens it"),
        ("<robot name='r'/>", "root element: got 'robot', expected 'sdf'"),
        ("<sdf><model>", "no XML"),
        ("<sdf>" + "<model>" * 3000 + "</model>" * 3000 + "</sdf>", "got more than 100 elements in each other"),
        ("<!DOCTYPE sdf SYSTEM 'x'><sdf/>", "got a document type or entities"),
    ],
)
def test_dropped_sdf_that_reads_elsewhere_is_refused_and_leaves_nothing(tmp_path: Path, text: str, message: str) -> None:
    kept = uploads.Uploads(tmp_path)
    with pytest.raises(uploads.Refused) as error:
        kept.add("arm.sdf", text.encode())
    assert message in str(error.value) and str(error.value).startswith("arm.sdf: ")
    assert kept.contents == {} and list(tmp_path.iterdir()) == []


@needs_drake
def test_real_sdf_is_opened_and_planned_again_in_a_shell(opened: Callable[[Path | None], Driven], scene: Path, tmp_path: Path, program: Path) -> None:
    driven = opened(scene)
    driven.panel.search.budget.value = 200.0
    name = driven.studio.posing.problem.model.object_names[0]
    assert name == "drawer" and driven.said == []
    driven.plan()
    assert driven.said == []
    result = driven.studio.showing.result
    (away := tmp_path / "away").mkdir()
    done = children.run(["bash", "-ec", result.command.replace("stiction ", f"STICTION_PYTHON={shlex.quote(sys.executable)} {shlex.quote(str(program))} ")], cwd=away, limit=300)
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(st.read_plan(away / "out" / "plan.json").q, result.plan.q)
    check_scene(driven, scene)


@needs_drake
def test_real_sdf_is_dropped_with_its_mesh(opened: Callable[[Path | None], Driven], tmp_path: Path) -> None:
    driven = opened(None)
    driven.press("upload", "tip.obj", WEDGE)
    driven.press("upload", "arm.sdf", (ROBOT % "<mesh><uri>model://shop/meshes/tip.obj</uri></mesh>").encode())
    driven.press("make")
    assert driven.said == []
    problem = driven.studio.posing.problem
    assert problem.model.joint_names == ["robot/x", "robot/y"] and problem.model.object_names == ["object"]
    digest = problem.task().scene_sha256
    (away := tmp_path / "away").mkdir()
    for file, content in {**problem.files(), "task.yaml": problem.task_file().encode()}.items():
        (away / file).parent.mkdir(parents=True, exist_ok=True)
        (away / file).write_bytes(content)
    for file in sorted(driven.studio.folder.rglob("*.obj")):
        file.unlink()
    assert st.load_task(away / "task.yaml").scene_sha256 == digest, "the mesh is found beside the task"
