"""SDF files as MJCF, against the poses that Drake's parser gives and those that the scene has. Drake is optional (`stiction[sdf]`): without it the
tests that need it are skipped."""

from __future__ import annotations

import importlib.util
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
PROGRAM = BUILD / "stiction"
if not (BUILD / "python" / "stiction").is_dir():
    pytest.skip(f"{BUILD} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(BUILD / "python"))

import stiction as st  # noqa: E402
from stiction import sdf  # noqa: E402
from stiction.sdf import convert_sdf  # noqa: E402

HAS_DRAKE = importlib.util.find_spec("pydrake") is not None
needs_drake = pytest.mark.skipif(not HAS_DRAKE, reason="Drake is not installed: `pip install 'stiction[sdf]'`")

PEG = """<sdf version="1.9"><model name="peg"><link name="body">
  <inertial><pose>0 0 .01 0 0 0</pose><mass>0.2</mass><inertia><ixx>.001</ixx><iyy>.002</iyy><izz>.0015</izz><ixy>.0001</ixy></inertia></inertial>
  <collision name="c"><pose>0 0 .05 0 0 .3</pose><geometry><capsule><radius>.02</radius><length>.1</length></capsule></geometry>
    <surface><friction><ode><mu>.4</mu><mu2>.4</mu2></ode></friction></surface></collision></link></model></sdf>"""
INERTIAL = "<inertial><mass>1.5</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.005</izz></inertia></inertial>"
SCENE = f"""<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 -3.7</gravity>
<frame name="corner"><pose>1 2 0 0 0 .5</pose></frame>
<include><uri>model://peg</uri><name>peg_a</name><pose relative_to="corner">.1 .2 .3 .4 .5 .6</pose></include>
<model name="ground"><static>true</static><link name="l"><collision name="p"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="arm"><pose>0 0 .1 0 0 1</pose>
  <link name="base">{INERTIAL}<collision name="b"><geometry><box><size>.2 .3 .1</size></box></geometry></collision></link>
  <joint name="fix" type="fixed"><parent>world</parent><child>base</child></joint>
  <frame name="mount" attached_to="base"><pose>0 0 .2 .3 0 0</pose></frame>
  <link name="upper"><pose relative_to="mount">0 0 .1 0 .2 0</pose>{INERTIAL}
    <collision name="c"><pose>.1 0 0 0 1 0</pose><geometry><cylinder><radius>.03</radius><length>.2</length></cylinder></geometry></collision></link>
  <joint name="shoulder" type="revolute"><pose>.01 .02 -.1 0 .1 0</pose><parent>base</parent><child>upper</child>
    <axis><xyz expressed_in="__model__">0 .6 .8</xyz><limit><lower>-1</lower><upper>2</upper><effort>20</effort></limit><dynamics><damping>.3</damping></dynamics></axis></joint>
  <link name="tool"><pose relative_to="upper">.3 0 0 0 0 .2</pose>{INERTIAL}
    <collision name="m"><geometry><mesh><uri>wedge.obj</uri><scale>2 1 1</scale></mesh></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent>upper</parent><child>tool</child><axis><xyz>1 0 0</xyz><limit><lower>0</lower><upper>.2</upper><effort>5</effort></limit></axis></joint>
</model>
<model name="cabinet"><pose>2 0 0 0 0 0</pose>
  <link name="case">{INERTIAL}<collision name="b"><geometry><box><size>.4 .4 .4</size></box></geometry></collision></link>
  <joint name="stand" type="fixed"><parent>world</parent><child>case</child></joint>
  <link name="door"><pose>-.22 .2 0 0 0 0</pose><collision name="b"><pose>0 -.2 0 0 0 0</pose><geometry><box><size>.02 .4 .4</size></box></geometry></collision></link>
  <joint name="hinge" type="revolute"><parent>door</parent><child>case</child><axis><xyz>0 0 1</xyz><limit><lower>0</lower><upper>1.5</upper></limit></axis></joint>
</model>
</world></sdf>"""
WEDGE = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "peg").mkdir()
    (tmp_path / "peg" / "model.config").write_text("<model><name>peg</name><version>1.0</version><sdf version='1.9'>model.sdf</sdf></model>")
    (tmp_path / "peg" / "model.sdf").write_text(PEG)
    (tmp_path / "wedge.obj").write_text(WEDGE)
    (tmp_path / "scene.sdf").write_text(SCENE)
    return tmp_path


def refused(source: Path, text: str) -> str:
    source.write_text(text)
    with pytest.raises(st.InvalidInput) as error:
        convert_sdf(source, source.with_suffix(".xml"))
    return str(error.value).replace(f"{source.parent}/", "")


def test_files_that_are_no_sdf_are_named(tmp_path: Path) -> None:
    assert refused(tmp_path / "a.sdf", "<sdf><model>").startswith("a.sdf: sdf: got malformed XML (")
    assert refused(tmp_path / "a.sdf", "<robot name='r'/>") == "a.sdf: root element: got 'robot', expected 'sdf'"
    with pytest.raises(st.InvalidInput, match="b.sdf: sdf: got a file that does not exist, expected an SDF"):
        convert_sdf(tmp_path / "b.sdf", tmp_path / "b.xml")


def test_what_drake_would_not_name_is_named_before(folder: Path) -> None:
    assert refused(folder / "a.sdf", SCENE.replace(' version="1.9"', "", 1)) == 'a.sdf: sdf: got no version, expected one, as in <sdf version="1.9">'
    for mass in ("0", "-1", "nan", "heavy"):  # Drake would take 1 kg for the first
        text = SCENE.replace("<mass>1.5</mass>", f"<mass>{mass}</mass>")
        assert refused(folder / "a.sdf", text) == f"a.sdf: link 'base': got a mass of {mass}, expected a number > 0"
    text = SCENE.replace("<ixx>.01</ixx>", "<ixx>1</ixx>")
    assert "a.sdf: link 'base': got an <inertia> that no body can have, expected" in refused(folder / "a.sdf", text)


def test_without_drake_the_extra_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pydrake", None)
    with pytest.raises(st.MissingExtra, match=r"SDF files: no Python module 'pydrake'; `pip install 'stiction\[sdf\]'` brings it"):
        convert_sdf(folder / "scene.sdf", folder / "scene.xml")


def test_a_task_that_names_an_sdf_says_how_it_is_converted(folder: Path) -> None:
    (folder / "task.yaml").write_text("scene: {file: scene.sdf}\n")
    with pytest.raises(st.InvalidInput) as error:
        st.load_task(str(folder / "task.yaml"))
    assert (
        "task.yaml:1: scene.file: scene.sdf:2: root element: got 'sdf', so an SDF, expected 'mujoco', the root of an MJCF; "
        "`stiction import scene.sdf -o NEW.yaml` makes an MJCF of it, NEW.xml"
    ) in str(error.value).replace(f"{folder}/", "").splitlines()
    with pytest.raises(st.InvalidInput, match="`stiction import FILE -o NEW.yaml` makes an MJCF of it"):
        st.Task({"scene": {"file": SCENE}})
    for read in (st.load_task, st.load_scene):
        with pytest.raises(st.InvalidInput, match="got XML, expected YAML: `stiction import` makes a task of a whole scene in MJCF, URDF or SDF"):
            read(folder / "scene.sdf")


def test_import_of_an_sdf_wants_a_place_for_the_mjcf(folder: Path) -> None:
    done = subprocess.run([PROGRAM, "import", "scene.sdf"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "-o: got none, expected a task file, beside which the MJCF of scene.sdf is written" in done.stderr


MJCF = """<mujoco><worldbody><body name="lid" pos="0 .3 0"><joint name="lid" type="slide" axis="1 0 0" range="0 .2"/><geom size=".05" mass="1"/></body>
  <body name="arm"><joint name="arm" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0 .2 0" size=".02" mass="1"/></body></worldbody>
  <actuator><position joint="arm" kp="50"/></actuator></mujoco>"""
NOTE = "links without <inertial> weigh 1 kg: lid"


@pytest.fixture
def no_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every SDF is the same scene, so that what comes after the parser is tested without it."""
    text = sdf.MADE + b"a test -->\n" + MJCF.encode()
    monkeypatch.setattr(sdf, "make_mjcf", lambda source, target=None, package_dirs=(): (text, [NOTE]))


def test_what_is_an_sdf_is_told_by_its_root(tmp_path: Path) -> None:
    for name, content, told in (
        ("a.xml", b"<?xml version='1.0'?>\n<!-- <mujoco> --><sdf version='1.9'/>", True),
        ("a.sdf", b"<mujoco/>", False),
        ("b.sdf", b"no XML", True),
        ("b.xml", b"", False),
        ("c.sdf", b"<sdf><model>", True),
        ("d.sdf", b"<?xml version='1.0' encoding='klingon'?><sdf/>", True),
        ("d.yaml", "scène: é".encode("latin-1"), False),
    ):
        (tmp_path / name).write_bytes(content)
        assert sdf.is_sdf(tmp_path / name) == told, name
    assert sdf.is_sdf(tmp_path / "none.sdf") and not sdf.is_sdf(tmp_path / "none.xml")
    assert "got malformed XML (unknown encoding" in refused(tmp_path / "d.sdf", "<?xml version='1.0' encoding='klingon'?><sdf/>")


@pytest.mark.usefixtures("no_parser")
def test_imported_sdf_is_a_task_in_memory_that_needs_no_file(folder: Path) -> None:
    with pytest.warns(UserWarning, match="scene.sdf: links without <inertial> weigh 1 kg: lid") as said:
        task = st.import_scene(folder / "scene.sdf")
    assert said[0].filename == __file__, "where the caller is"
    assert task.model.joint_names == ["robot/arm"] and task.model.object_names == ["lid"]
    assert sorted(file.name for file in folder.iterdir()) == ["peg", "scene.sdf", "wedge.obj"], "nothing is written"
    again = pickle.loads(pickle.dumps(task))
    assert again.scene_sha256 == task.scene_sha256
    (folder / "task.yaml").write_text(task.text)
    assert st.load_task(folder / "task.yaml").scene_sha256 == task.scene_sha256
    with pytest.raises(st.InvalidInput, match="object: got 'nothing', expected one of lid"):
        st.import_scene(folder / "scene.sdf", object="nothing")


def test_what_the_mjcf_lacks_is_said_of_the_sdf(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = MJCF[: MJCF.index("<actuator>")].encode() + b"</mujoco>"
    monkeypatch.setattr(sdf, "make_mjcf", lambda source, target=None, package_dirs=(): (text, []))
    with pytest.raises(st.InvalidInput) as error:
        st.import_scene(folder / "scene.sdf")
    assert str(error.value).startswith(f"{folder}/scene.sdf: import: got a file without a robot")


@pytest.mark.usefixtures("no_parser")
@pytest.mark.filterwarnings("ignore:.*links without <inertial>")
def test_imported_sdf_with_a_task_file_has_its_mjcf_beside_it(folder: Path) -> None:
    out = folder / "tasks" / "kitchen.yaml"
    out.parent.mkdir()
    task = st.import_scene(folder / "scene.sdf", out=out, object="lid")
    assert "file: \"kitchen.xml\"" in out.read_text() and (out.parent / "kitchen.xml").read_bytes().startswith(b"<!-- Made by stiction of ")
    assert st.load_task(out).scene_sha256 == task.scene_sha256
    assert st.import_scene(folder / "scene.sdf", out=out).scene_sha256 == task.scene_sha256, "what was made of it may be made anew"
    (out.parent / "kitchen.xml").write_text("<mujoco/>")
    with pytest.raises(st.InvalidInput, match="expected a task file with another name: the MJCF of scene.sdf is to be kitchen.xml beside it, which is there already"):
        st.import_scene(folder / "scene.sdf", out=out)
    assert (out.parent / "kitchen.xml").read_text() == "<mujoco/>"
    with pytest.raises(st.InvalidInput, match="is to be new.xml beside it, which is that file"):
        st.import_scene(folder / "scene.sdf", out=folder / "new.xml")
    assert not (folder / "new.xml").exists()


def test_import_of_a_file_that_is_no_scene_is_one_message(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pydrake", None)  # as if it were not installed
    with pytest.raises(st.MissingExtra, match=r"SDF files: no Python module 'pydrake'; `pip install"):
        st.import_scene(folder / "scene.sdf")
    (folder / "a.sdf").write_text("<sdf><model>")
    with pytest.raises(st.InvalidInput, match=r"a.sdf: sdf: got malformed XML \("):
        st.import_scene(folder / "a.sdf", out=folder / "a.yaml")
    assert not (folder / "a.yaml").exists() and not (folder / "a.xml").exists()
    assert "a.sdf: sdf: got more than 100 elements in each other" in refused(folder / "a.sdf", "<sdf>" + "<model>" * 3000 + "</model>" * 3000 + "</sdf>")
    assert "a.sdf: uri: got '.', which is a folder, expected a mesh" in refused(folder / "a.sdf", SCENE.replace("wedge.obj", "."))


def test_models_that_include_themselves_and_configs_that_are_no_xml_are_named(folder: Path) -> None:
    (folder / "peg" / "model.sdf").write_text(PEG.replace("<link", "<include><uri>model://peg</uri></include><link"))
    assert "include: got a file that includes itself, by scene.sdf, model.sdf, expected one that ends" in refused(folder / "scene.sdf", SCENE)
    (folder / "peg" / "model.config").write_text("<model>")
    assert refused(folder / "scene.sdf", SCENE).startswith("peg/model.config: got what cannot be read (")


def rotation(rng: np.random.Generator) -> np.ndarray:
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    return np.array([w, x, y, z]) * np.sign(w)


def same(ours: st.Pose, theirs) -> None:
    assert np.allclose(ours.p, theirs.translation(), atol=1e-12)
    assert np.allclose(ours.R, theirs.rotation().matrix(), atol=1e-12)


@needs_drake
def test_links_stand_where_drake_has_them(folder: Path) -> None:
    """At random values of all joints, also of one whose child carries its parent; with masses, frictions and sites."""
    from pydrake.geometry import SceneGraph
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant, graph = MultibodyPlant(0.001), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(graph)
    (folder / "drake.sdf").write_text(SCENE.replace("model://peg", "model://peg/model.sdf"))  # the paths that Drake finds by itself
    parser = Parser(plant)
    parser.package_map().Add("peg", str(folder / "peg"))
    parser.AddModels(str(folder / "drake.sdf"))
    plant.Finalize()
    context = plant.CreateDefaultContext()

    notes = convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    assert any(note.startswith("links without <inertial> weigh 1 kg") and "door" in note for note in notes)
    task = st.import_scene(folder / "scene.xml")
    model = task.model
    assert model.joint_names == ["robot/shoulder", "robot/slide"] and sorted(model.object_names) == ["door", "peg_a"]
    assert np.allclose(model.scene.gravity, [0, 0, -3.7])
    assert model.lower.tolist() == [-1, 0] and model.upper.tolist() == [2, 0.2] and model.effort.tolist() == [20, 5]
    door, peg = (model.objects[model.object_index(name)] for name in ("door", "peg_a"))
    rng = np.random.default_rng(3)
    for _ in range(10):
        q = model.neutral()
        q[-2:] = rng.uniform(model.lower, model.upper)
        q[door.q_begin] = rng.uniform(0, 1.5)
        p, wxyz = rng.normal(size=3), rotation(rng)
        q[peg.q_begin : peg.q_begin + 7] = [*p, *wxyz[1:], wxyz[0]]
        for joint, value in (("shoulder", q[-2]), ("slide", q[-1]), ("hinge", q[door.q_begin])):
            moved = plant.GetJointByName(joint)
            plant.SetPositions(context, np.concatenate([plant.GetPositions(context)[: moved.position_start()], [value], plant.GetPositions(context)[moved.position_start() + 1 :]]))
        free = plant.GetBodyByName("body")
        plant.SetFreeBodyPose(context, free, RigidTransform(RotationMatrix(Quaternion(wxyz)), p))
        poses = model.body_poses(q)
        for name in ("upper", "tool"):
            same(poses[f"robot/{name}"], plant.GetBodyByName(name).EvalPoseInWorld(context))
        for theirs, ours in (("upper", "robot/upper"), ("door", "door"), ("body", "peg_a")):  # the frame of an object on a joint is at the joint
            (geometry,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName(theirs))
            (shape,) = [g for g in model.geometries if model.bodies[g.body].name == ours]
            X_WB = plant.GetBodyByName(theirs).EvalPoseInWorld(context)
            same(poses[ours] @ shape.X_BG, X_WB.multiply(graph.model_inspector().GetPoseInFrame(geometry)))
    assert peg.mass == pytest.approx(0.2)
    (capsule,) = [g for g in model.geometries if model.bodies[g.body].name == "peg_a"]
    assert capsule.friction == pytest.approx(0.4)
    (folder / "task.yaml").write_text("scene: {file: scene.xml}\ngoal: {object: peg_a, at: corner}\ntolerance: {position: 0.01, angle: 0.1}\n")
    assert np.allclose(st.load_task(str(folder / "task.yaml")).q_goal[peg.q_begin : peg.q_begin + 3], [1, 2, 0])


@needs_drake
def test_joints_without_an_effort_are_motors_where_a_plugin_names_them(folder: Path) -> None:
    plugin = "<plugin name='c' filename='gz-sim-joint-position-controller-system'><joint_name>hinge</joint_name></plugin></model>\n</world>"
    (folder / "scene.sdf").write_text(SCENE.replace("</model>\n</world>", plugin))
    convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    assert st.import_scene(folder / "scene.xml").model.joint_names == ["robot/shoulder", "robot/slide", "robot/hinge"]


@needs_drake
def test_friction_of_contacts_and_joints(folder: Path) -> None:
    """One direction alone is enough, where the other one is 1 by the format, and more than Drake takes."""
    (folder / "peg" / "model.sdf").write_text(PEG.replace("<mu2>.4</mu2>", ""))
    (folder / "scene.sdf").write_text(SCENE.replace("<damping>.3</damping>", "<damping>.3</damping><friction>.25</friction>"))
    assert not [note for note in convert_sdf(folder / "scene.sdf", folder / "scene.xml") if "mu2" in note]
    model = st.import_scene(folder / "scene.xml").model
    assert [g.friction for g in model.geometries if model.bodies[g.body].name == "peg_a"] == pytest.approx([0.4])
    assert [dof.friction for dof in model.dofs if dof.name == "robot/shoulder"] == [0.25]


@needs_drake
def test_what_acts_in_gazebo_alone_is_said_once(folder: Path) -> None:
    peg = PEG.replace("<mu2>.4</mu2>", "<mu2>.9</mu2>").replace("</link>", "<gravity>false</gravity></link>")
    (folder / "peg" / "model.sdf").write_text(peg)
    saved = '<state world_name="w"><model name="arm"><pose>5 5 5 0 0 0</pose></model></state></world>'
    (folder / "scene.sdf").write_text(SCENE.replace("</world>", saved))
    notes = convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    assert [note for note in notes if note.startswith("not read")] == ["not read: <state> of worlds w; <gravity> of links body; <mu2> of collisions c"]
    (folder / "scene.sdf").write_text(SCENE.replace("<radius>.03</radius>", "<radius>0</radius>"))
    assert "Using default value" in refused(folder / "a.sdf", (folder / "scene.sdf").read_text()), "a cylinder of 1 m"


@needs_drake
def test_uris_of_other_systems_are_found(folder: Path) -> None:
    (folder / "my meshes").mkdir()
    (folder / "my meshes" / "wedge.obj").write_text(WEDGE)
    for uri in ("my meshes/wedge.obj", "my%20meshes/wedge.obj", "my meshes\\wedge.obj", f"file://{folder}/my%20meshes/wedge.obj"):
        (folder / "scene.sdf").write_text(SCENE.replace("wedge.obj", uri))
        convert_sdf(folder / "scene.sdf", folder / "scene.xml")
        assert st.import_scene(folder / "scene.xml").model.joint_names == ["robot/shoulder", "robot/slide"]
    (folder / "lfs.dae").write_text("version https://git-lfs.github.com/spec/v1\n")
    assert refused(folder / "a.sdf", SCENE.replace("wedge.obj", "lfs.dae")) == "lfs.dae: got a pointer of Git LFS, expected a mesh; `git lfs pull` fetches the file itself"


@needs_drake
def test_joint_that_follows_another_one(folder: Path) -> None:
    mimic = "<axis><mimic joint='shoulder' axis='axis'><multiplier>0.05</multiplier><offset>.06</offset><reference>.2</reference></mimic><xyz>1 0 0</xyz>"
    (folder / "scene.sdf").write_text(SCENE.replace('version="1.9"><world', 'version="1.11"><world').replace("<axis><xyz>1 0 0</xyz>", mimic))
    convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    model = st.import_scene(folder / "scene.xml").model
    assert model.joint_names == ["robot/shoulder"]
    upper, tool = (model.body_poses(model.neutral())[f"robot/{name}"] for name in ("upper", "tool"))
    assert np.allclose(upper.R.T @ (tool.p - upper.p), [0.3 + 0.05 * np.cos(0.2), 0.05 * np.sin(0.2), 0], atol=1e-12), "0.05·(0 − 0.2) + 0.06 along x of the tool"


def write_scene_with_dae(folder: Path) -> None:
    """The scene with a box of (10, 20, 30) cm from a DAE in centimetres, which MuJoCo does not read."""
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    text = trimesh.exchange.dae.export_collada(trimesh.creation.box((10, 20, 30))).decode()
    (folder / "block.dae").write_text(text.replace("<asset>", '<asset><unit name="cm" meter="0.01"/>', 1))
    (folder / "scene.sdf").write_text(SCENE.replace("wedge.obj", "block.dae"))


@needs_drake
def test_meshes_of_gazebo_are_written_beside_the_mjcf_in_metres(folder: Path) -> None:
    """A DAE in centimetres, which MuJoCo does not read, scaled by (2, 1, 1)."""
    write_scene_with_dae(folder)
    convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    model = st.import_scene(folder / "scene.xml").model
    (mesh,) = [g for g in model.geometries if model.bodies[g.body].name == "robot/tool"]
    corners = np.asarray(mesh.shape["vertices"])
    assert np.allclose(sorted(np.ptp(corners, axis=0)), [0.2, 0.2, 0.3])


@needs_drake
def test_an_imported_sdf_in_memory_holds_the_meshes_that_mujoco_does_not_read(folder: Path) -> None:
    write_scene_with_dae(folder)
    before = sorted(folder.iterdir())
    with pytest.warns(UserWarning, match="links without <inertial>"):
        task = st.import_scene(folder / "scene.sdf")
        in_file = st.import_scene(folder / "scene.sdf", out=folder / "task.yaml")
    assert [file.name for file in sorted(folder.iterdir()) if file not in before] == ["task.xml", "task.yaml", "task_block.obj"]
    assert 'file="task_block.obj"' in (folder / "task.xml").read_text(), "it may be moved with the folder"
    for model in (task.model, in_file.model):
        (mesh,) = [g for g in model.geometries if model.bodies[g.body].name == "robot/tool"]
        assert np.allclose(sorted(np.ptp(np.asarray(mesh.shape["vertices"]), axis=0)), [0.2, 0.2, 0.3])
    (folder / "block.dae").write_text("<COLLADA>")
    assert "block.dae: got a mesh that cannot be read (" in refused(folder / "a.sdf", SCENE.replace("wedge.obj", "block.dae"))


@needs_drake
def test_inertia_of_a_point_is_made_one_that_mujoco_takes(folder: Path) -> None:
    (folder / "scene.sdf").write_text(SCENE.replace("<ixx>.01</ixx><iyy>.01</iyy><izz>.005</izz>", "<ixx>0</ixx><iyy>0</iyy><izz>0</izz>"))
    notes = convert_sdf(folder / "scene.sdf", folder / "scene.xml")
    assert "link 'upper' has moments of inertia of 1.35e-09 kg·m² where its file has less" in notes
    assert st.import_scene(folder / "scene.xml").model.joint_names == ["robot/shoulder", "robot/slide"]


@needs_drake
def test_what_cannot_be_a_scene_is_named(folder: Path) -> None:
    assert refused(folder / "a.sdf", SCENE.replace("model://peg", "model://pegs")) == (
        "a.sdf: uri: got 'model://pegs', expected a folder with a model.config or package.xml near the file, or package_dirs; there are: peg"
    )
    assert "a.sdf: uri: got 'https://x/y', expected model://" in refused(folder / "a.sdf", SCENE.replace("model://peg", "https://x/y"))
    assert "a.sdf: uri: got 'wedge.stl', so " in refused(folder / "a.sdf", SCENE.replace("wedge.obj", "wedge.stl"))
    assert refused(folder / "a.sdf", SCENE.replace('<parent>upper', '<parent>up')).startswith("a.sdf: sdf: got 'error: parent frame with name[up]")
    screw = SCENE.replace('name="slide" type="prismatic"', 'name="slide" type="screw"')
    assert "a.sdf: joint 'slide': got a joint of type 'screw', expected revolute, continuous" in refused(folder / "a.sdf", screw)
    loop = SCENE.replace("</model>\n<model name=\"cabinet\">", "<joint name='extra' type='revolute'><parent>base</parent><child>tool</child><axis><xyz>1 0 0</xyz></axis></joint></model>\n<model name=\"cabinet\">")
    assert "form one or more loops" in refused(folder / "a.sdf", loop)


@needs_drake
def test_import_writes_a_task_and_the_mjcf_beside_it(folder: Path) -> None:
    done = subprocess.run([PROGRAM, "import", "scene.sdf", "-o", "task.yaml"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    task = st.load_task(str(folder / "task.yaml"))
    assert (folder / "task.xml").is_file()
    assert sorted(task.model.object_names) == ["door", "peg_a"]
    assert "robot/shoulder" in task.model.joint_names
    again = subprocess.run([PROGRAM, "import", "scene.sdf", "-o", "task.yaml"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert again.returncode == 2 and "which is there already" in again.stderr
