"""The tasks of `stiction benchmark`: scenes as the packages of others bring them, with the goals and success tests of their makers.

Where a maker draws starts and goals at random, the task has the one that the maker's class gives as its own. Coordinates of a success test are those
of the joint that moves; bounds lie inside the maker's by the tolerance, so that what is reached here passes there.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ._core import InvalidInput, load_task

SETS = ("joints", "push", "in hand", "pick and place", "tools", "insertion", "whole arm")
WHEELS = {"metaworld": "metaworld", "gymnasium_robotics": "gymnasium-robotics", "robosuite": "robosuite", "mujoco_playground": "playground"}


@dataclasses.dataclass(frozen=True)
class Entry:
    """A task, and where it is from."""

    name: str
    set: str
    test: str  # that its makers call success, in words
    task: dict[str, Any]  # keys of a task file; paths begin with the name of a package
    differs: str = ""  # from what the makers do

    @property
    def wheel(self) -> str | None:
        """The package that its scene is in; None: it is built in, or its scene is written here."""
        return next((text.split("/")[0] for text in _texts(self.task) if text.split("/")[0] in WHEELS), None)


def _texts(value: Any) -> Iterable[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from _texts(inner)


def _quarter(angle: float, axis: str = "z") -> list[float]:
    half = angle / 2
    return [math.cos(half), *(math.sin(half) if a == axis else 0.0 for a in "xyz")]


def _free(x: float, y: float, z: float, quaternion: list[float] | None = None) -> dict[str, Any]:
    return {"position": [x, y, z]} | ({"quaternion_wxyz": quaternion} if quaternion else {})


def _joint(*values: Any) -> dict[str, Any]:
    return {"coordinates": list(values)}


def _beyond(value: float) -> list[float | None]:
    return [value, None]


def _below(value: float) -> list[float | None]:
    return [None, value]


def _place(name: str, x: float, y: float, z: float) -> dict[str, Any]:
    """A goal for where an object is, however it is turned."""
    return {"objects": {name: {"position": [x, y, z], "rpy": None}}}


# ---- metaworld: the hand stands where the maker's class puts it

HIGH, LOW = (0.0, 0.6, 0.2), (0.0, 0.4, 0.2)


def _apart(file: str, *pairs: tuple[str, str]) -> dict[str, Any]:
    """A scene in which two things pass through each other."""
    return {"file": file, "filters": [{"exclude": list(pair)} for pair in pairs]}


METAWORLD = "metaworld/assets/sawyer_xyz"


def _sawyer(file: str, hand: tuple[float, float, float], goal: dict[str, Any], tolerance: float, objects: dict[str, Any] | None = None) -> dict[str, Any]:
    start: dict[str, Any] = {"poses": {"hand": {"position": list(hand), "quaternion_wxyz": [math.sqrt(0.5), 0, math.sqrt(0.5), 0]}}}
    return {
        "scene": {"file": f"{METAWORLD}/{file}.xml"},
        "start": start | ({"objects": objects} if objects else {}),
        "goal": goal,
        "tolerance": {"position": tolerance, "angle": tolerance if "coordinates" in str(goal) else 0.1},
    }


def _turned(
    name: str, test: str, file: str, hand: tuple[float, float, float], to: dict[str, Any], tolerance: float, start: dict[str, Any] | None = None, differs: str = "",
    apart: tuple[tuple[str, str], ...] = (),
) -> Entry:  # fmt: skip
    task = _sawyer(file, hand, {"objects": to}, tolerance, start)
    return Entry(f"metaworld_{name}", "joints", test, task | ({"scene": _apart(task["scene"]["file"], *apart)} if apart else {}), differs)


ON_TABLE = "the object starts on the table, at z = 0.07; lower, as the maker has it, it is inside the table"
POST = (("door_link/box_9", "robot_world/doorlockB.box_1"),)
JAMS = "beyond 1.33 rad the door overlaps a post of its frame by up to 1 mm, where rigid bodies jam; here it passes through this post"
PRESSED = "MuJoCo's soft limit lets a button go deeper than its range, and the maker's test asks for that; here it is pressed to the end of its range"

METAWORLD_JOINTS = [
    _turned("button_press", "button within 20 mm of its hole", "sawyer_button_press", LOW, {"button": _joint(-0.06)}, 0.005, differs=PRESSED),
    _turned("button_press_topdown", "button within 24 mm of its hole", "sawyer_button_press_topdown", LOW, {"button": _joint(-0.06)}, 0.005, differs=PRESSED),
    _turned("button_press_wall", "button within 30 mm of its hole", "sawyer_button_press_wall", LOW, {"button": _joint(-0.06)}, 0.005, differs=PRESSED),
    _turned("button_press_topdown_wall", "button within 24 mm of its hole", "sawyer_button_press_topdown_wall", LOW, {"button": _joint(-0.06)}, 0.005, differs=PRESSED),
    _turned("coffee_button", "button within 20 mm of 30 mm deep", "sawyer_coffee", LOW, {"cmbutton": _joint(_beyond(0.015))}, 0.005, {"obj": _free(0, 0.68, 0)}),
    _turned("dial_turn", "knob within 70 mm of the goal: turned by 1.37 rad", "sawyer_dial", HIGH, {"body_34": _joint(_beyond(1.39))}, 0.02),
    _turned("door_open", "handle within 80 mm of the goal along x: 1.39 to 1.81 rad", "sawyer_door_pull", HIGH, {"door_link": _joint([-1.795, -1.405])}, 0.02, differs=JAMS, apart=POST),
    _turned("door_close", "handle within 80 mm of the goal: below 0.17 rad", "sawyer_door_pull", HIGH, {"door_link": _joint(_beyond(-0.155))}, 0.02,
            {"door_link": _joint(-1.5708)}, f"{JAMS}; the hand starts at (0, 0.6, 0.2), not at (-0.5, 0.6, 0.2)", POST),
    _turned("door_lock", "lock within 20 mm of the goal height: turned by 1.2 rad", "sawyer_door_lock", HIGH, {"lock_link": _joint(_beyond(1.215))}, 0.02),
    _turned("door_unlock", "lock within 20 mm of the goal along x: below 0.37 rad", "sawyer_door_lock", HIGH, {"lock_link": _joint(_below(0.357))}, 0.02, {"lock_link": _joint(1.57)}),
    _turned("drawer_open", "handle within 30 mm of the goal: 160 mm out", "sawyer_drawer", HIGH, {"drawer_link": _joint(-0.16)}, 0.005),
    _turned("drawer_close", "handle within 65 mm of the goal: less than 31 mm out", "sawyer_drawer", HIGH, {"drawer_link": _joint(_beyond(-0.021))}, 0.01, {"drawer_link": _joint(-0.15)}),
    _turned("faucet_open", "handle within 70 mm of the goal: turned by 1.26 rad", "sawyer_faucet", LOW, {"faucet_link2": _joint(_beyond(1.28))}, 0.02),
    _turned("faucet_close", "handle within 70 mm of the goal: turned by 1.26 rad", "sawyer_faucet", LOW, {"faucet_link2": _joint(_below(-1.28))}, 0.02),
    _turned("handle_press", "handle within 20 mm of the goal height: 77 mm down", "sawyer_handle_press", LOW, {"handle_link": _joint(_below(-0.087))}, 0.01,
            {"handle_link": _joint(-0.001)}, "the hand starts at (0, 0.4, 0.2): at (0, 0.6, 0.2) it stands in the handle of the file"),
    _turned("handle_press_side", "handle within 20 mm of the goal height: 77 mm down", "sawyer_handle_press_sideways", HIGH, {"handle_link": _joint(_below(-0.087))}, 0.01, {"handle_link": _joint(-0.001)}),
    _turned("handle_pull", "handle within 50 mm of the goal height: less than 42 mm down", "sawyer_handle_press", LOW, {"handle_link": _joint(_beyond(-0.032))}, 0.01,
            {"handle_link": _joint(-0.1)}, "the hand starts at (0, 0.4, 0.2), not at (0, 0.6, 0.2)"),
    _turned("handle_pull_side", "handle within 80 mm of the goal height: less than 58 mm down", "sawyer_handle_press_sideways", HIGH, {"handle_link": _joint(_beyond(-0.048))}, 0.01, {"handle_link": _joint(-0.1)}),
    _turned("lever_pull", "lever within 7.5° of upright", "sawyer_lever_pull", LOW, {"lever_link1": _joint(_beyond(1.46))}, 0.02,
            differs="the joint of the file turns the lever down, and the test's sign up: 1.44 rad the way that the joint has"),
    _turned("plate_slide", "plate within 70 mm of the goal", "sawyer_plate_slide", HIGH, {"body_34.goal_slidex": _joint(0), "body_34": _joint(0.25)}, 0.07),
    _turned("plate_slide_back", "plate within 70 mm of the goal", "sawyer_plate_slide", HIGH, {"body_34.goal_slidex": _joint(0), "body_34": _joint(0)}, 0.07,
            {"body_34.goal_slidex": _joint(0), "body_34": _joint(0.15)}),
    _turned("plate_slide_side", "plate within 70 mm of the goal", "sawyer_plate_slide_sideway", HIGH, {"body_34.goal_slidex": _joint(-0.2), "body_34": _joint(0)}, 0.02,
            differs="the slide ends 50 mm before the goal, which leaves 20 mm of the tolerance"),
    _turned("plate_slide_back_side", "plate within 70 mm of the goal", "sawyer_plate_slide_sideway", HIGH, {"body_34.goal_slidex": _joint(0), "body_34": _joint(0)}, 0.07,
            {"body_34.goal_slidex": _joint(-0.15), "body_34": _joint(0)}),
    _turned("window_open", "handle within 50 mm of the goal: 190 mm open", "sawyer_window_horizontal", LOW, {"windowb_a": _joint(_beyond(0.195))}, 0.005),
    _turned("window_close", "handle within 50 mm of the goal: less than 40 mm open", "sawyer_window_horizontal", LOW, {"windowb_a": _joint(_below(0.03))}, 0.01, {"windowb_a": _joint(0.2)}),
]  # fmt: skip


THROUGH = "the robot passes through what the tool is for, which only the tool can move then"


def _with_tool(name: str, file: str, *rest: Any) -> dict[str, Any]:
    task = _sawyer(file, *rest)
    return task | {"scene": _apart(task["scene"]["file"], ("robot", name))}


def _moved(
    name: str, set_: str, test: str, file: str, object_: str, start: tuple[float, float, float] | None, goal: tuple[float, float, float], tolerance: float,
    hand: tuple[float, float, float] = HIGH, others: dict[str, Any] | None = None, differs: str = "",
) -> Entry:  # fmt: skip
    objects = ({object_: _free(*start)} if start else {}) | (others or {})
    return Entry(f"metaworld_{name}", set_, test, _sawyer(file, hand, _place(object_, *goal), tolerance, objects), differs)


METAWORLD_FREE = [
    _moved("push", "push", "object within 50 mm of the goal", "sawyer_push_v3", "obj", (0, 0.6, 0.02), (0.1, 0.8, 0.02), 0.05),
    _moved("push_back", "push", "object within 70 mm of the goal", "sawyer_push_back_v3", "obj", (0, 0.8, 0.02), (0, 0.6, 0.02), 0.07),
    _moved("push_wall", "push", "object within 70 mm of the goal", "sawyer_push_wall_v3", "obj", (0, 0.6, 0.02), (0.05, 0.85, 0.02), 0.07,
           differs="goal 50 mm farther: nearer is in the wall of the file"),
    _moved("sweep", "push", "object within 50 mm of the goal", "sawyer_sweep_v3", "obj", (0, 0.6, 0), (0.5, 0.65, 0.01), 0.05),
    _moved("sweep_into_goal", "push", "object within 50 mm of the goal", "sawyer_table_with_hole", "obj", (0, 0.6, 0.07), (0, 0.84, 0.02), 0.05, differs=ON_TABLE),
    _moved("soccer", "push", "ball within 70 mm of the goal", "sawyer_soccer", "soccer_ball", (0, 0.6, 0.03), (0, 0.9, 0.03), 0.07),
    _moved("coffee_push", "push", "mug within 70 mm of the goal", "sawyer_coffee", "obj", (0, 0.6, 0), (0, 0.75, 0), 0.07, LOW),
    _moved("coffee_pull", "push", "mug within 70 mm of the goal", "sawyer_coffee", "obj", (0, 0.75, 0), (0, 0.6, 0), 0.07, LOW,
           differs="the machine stands at y = 0.9, 150 mm behind the mug, not 220 mm"),
    _moved("pick_place", "pick and place", "object within 70 mm of the goal", "sawyer_pick_place_v3", "obj", (0, 0.6, 0.02), (0.1, 0.8, 0.2), 0.07),
    _moved("pick_place_wall", "pick and place", "object within 70 mm of the goal", "sawyer_pick_place_wall_v3", "obj", (0, 0.6, 0.02), (0.05, 0.8, 0.2), 0.07),
    _moved("shelf_place", "pick and place", "object within 70 mm of the goal", "sawyer_shelf_placing", "obj", (0, 0.6, 0.02), (0, 0.8, 0.3), 0.07,
           differs="the shelf stands where the file has it, at y = 0.8"),
    _moved("bin_picking", "pick and place", "object within 50 mm of the other bin's middle", "sawyer_bin_picking", "obj", (-0.12, 0.7, 0.02), (0.12, 0.7, 0.02), 0.045),
    _moved("basketball", "pick and place", "ball within 80 mm of the hoop", "sawyer_basketball", "bsktball", (0, 0.6, 0.03), (0, 0.817, 0.25), 0.08),
    _moved("box_close", "pick and place", "lid within 80 mm of the box", "sawyer_box", "boxbodytop", (0, 0.55, 0.02), (0, 0.8, 0.058), 0.08, (0, 0.6, 0.3),
           differs="the box stands where the file has it, at y = 0.8; the hand starts 100 mm higher, clear of the lid"),
    _moved("pick_out_of_hole", "pick and place", "object within 70 mm of the goal", "sawyer_pick_out_of_hole", "obj", (0, 0.75, -0.02), (0, 0.6, 0.2), 0.07),
    _moved("hand_insert", "insertion", "object within 50 mm of the goal in the hole", "sawyer_table_with_hole", "obj", (0, 0.6, 0.07), (0, 0.84, -0.02), 0.05, differs=ON_TABLE),
    _moved("assembly", "insertion", "nut within 20 mm of the peg's axis, and below its top", "sawyer_assembly_peg", "RoundNut", None, (0.1, 0.8, 0.075), 0.02),
    Entry("metaworld_disassemble", "insertion", "nut 150 mm above where it was on the peg",
          _sawyer("sawyer_assembly_peg", HIGH, {"objects": {"RoundNut": {"position": [None, None, _beyond(0.18)], "rpy": None}}}, 0.005,
                  {"RoundNut": _free(0.1, 0.8, 0.025)})),
    _moved("peg_insertion_side", "insertion", "head of the peg within 70 mm of the goal (sideways 35 mm)", "sawyer_peg_insertion_side", "peg", (0, 0.6, 0.03), (-0.17, 0.6, 0.13), 0.035),
    Entry("metaworld_peg_unplug_side", "insertion", "plug within 70 mm of 150 mm out",
          _sawyer("sawyer_peg_unplug_side", HIGH, _place("plug1", -0.102, 0.6, 0.131), 0.07)
          | {"scene": _apart(f"{METAWORLD}/sawyer_peg_unplug_side.xml", ("plug1/plug.sphere_4", "robot_world/plug_wall.*"))},
          "one sphere of the plug is 8 mm wider than its hole; here it passes through the wall"),
    Entry("metaworld_stick_push", "tools", "thermos within 120 mm of the goal, stick in the hand",
          _with_tool("body_36", "sawyer_stick_obj", HIGH, {"objects": {"body_36.obj_slidex": _joint(0.2), "body_36": _joint(0)}}, 0.1, {"stick": _free(-0.1, 0.6, 0.02)}),
          THROUGH),
    Entry("metaworld_stick_pull", "tools", "thermos within 120 mm of the goal, stick in its handle",
          _with_tool("body_36", "sawyer_stick_obj", HIGH, {"objects": {"body_36.obj_slidex": _joint(0.15), "body_36": _joint(-0.11)}}, 0.05,
                  {"stick": _free(0, 0.6, 0.02), "body_36.obj_slidex": _joint(0), "body_36": _joint(0.09)}),
          THROUGH),
    Entry("metaworld_hammer", "tools", "nail more than 90 mm deep",
          _with_tool("nail_link", "sawyer_hammer", LOW, {"objects": {"nail_link": _joint(_beyond(0.095))}}, 0.005, {"hammerbody": _free(0, 0.5, 0.02)}), THROUGH),
]  # fmt: skip


# ---- gymnasium-robotics

KITCHEN_JOINTS = [0.148388023, -1.7627, 1.84390296, -2.47685760, 0.260252026, 0.712533105, 1.59515394, 0.0399, 0.0371350919]


def _kitchen(name: str, test: str, goal: dict[str, Any], position: float, angle: float, differs: str = "") -> Entry:
    task = {
        "scene": {"file": "gymnasium_robotics/envs/assets/kitchen_franka/kitchen_assets/kitchen_env_model.xml"},
        "start": {"joints": KITCHEN_JOINTS},
        "goal": {"objects": goal},
        "tolerance": {"position": position, "angle": angle},
    }
    return Entry(f"kitchen_{name}", "joints" if name != "kettle" else "pick and place", test, task, "; ".join(filter(None, [differs, CLAMPED])))


CLAMPED = "joint 2 starts at its limit, 0.006 rad from the maker's start beyond it"
BURNER = "the burner that follows the knob moves nothing that collides, and is left out"

KITCHEN = [
    _kitchen("bottom_burner", "knob and burner within 0.3 of the goal", {"knob_2": _joint(-0.88)}, 0.05, 0.29, BURNER),
    _kitchen("top_burner", "knob and burner within 0.3 of the goal", {"knob_4": _joint(-0.92)}, 0.05, 0.29, BURNER),
    _kitchen("light_switch", "switch and light within 0.3 of the goal", {"lightswitchroot": _joint(-0.69)}, 0.05, 0.29, BURNER),
    _kitchen("slide_cabinet", "door within 0.3 m of the goal", {"slidelink": _joint(0.37)}, 0.29, 0.1),
    _kitchen("hinge_cabinet", "right door within 0.3 rad of the goal", {"hingerightdoor": _joint(1.45)}, 0.05, 0.29),
    _kitchen("microwave", "door within 0.3 rad of the goal", {"microdoorroot": _joint(-0.75)}, 0.05, 0.29),
    _kitchen("kettle", "position and quaternion within 0.3 of the goal", {"kettle": _free(-0.23, 0.75, 1.62)}, 0.2, 0.4),
]

HAND_JOINTS = {
    "block": [-0.1745, -0.1923, 0.0, 0.7716, 0.7854, 0.7558, 0.0, 0.7747, 0.7854, 0.7558, 0.0036, 0.7236, 0.7364, 0.6975,
              0.376, -0.0016, 0.8152, 0.802, 0.7757, 0.0036, 0.589, -0.0083, -0.002, -0.7865],
    "egg": [-0.1744, -0.2078, 0.0014, 0.7636, 0.7846, 0.7541, 0.0, 0.7744, 0.7853, 0.7556, 0.0036, 0.7257, 0.7351, 0.696,
            0.3762, -0.0018, 0.816, 0.8023, 0.7759, 0.001, 0.5828, -0.0099, -0.0006, -0.7865],
    "pen": [-0.1745, -0.1881, -0.0004, 0.7732, 0.7854, 0.7559, 0.0, 0.7748, 0.7854, 0.7559, 0.0038, 0.7257, 0.735, 0.6958,
            0.3732, -0.0019, 0.8166, 0.8026, 0.7765, 0.0036, 0.589, -0.0083, -0.002, -0.7865],
}  # fmt: skip
HAND_OBJECT = {
    "block": ([1.00971, 0.88034, 0.16557], [0.99743, 0.00049, 0.003, 0.07154]),
    "egg": ([0.99283, 0.86676, 0.16844], [0.91596, -0.00139, -0.36626, 0.16393]),
    "pen": ([0.99963, 0.87306, 0.14533], [0.74114, -0.46772, 0.42127, -0.23339]),
}
RESTING = "starts where the object rests after 5 s in MuJoCo with all motors in the middle of their ranges. The maker's reset takes 0.4 s"


def _multiply(a: list[float], b: list[float]) -> list[float]:
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]


def _unit(quaternion: list[float]) -> list[float]:
    norm = math.sqrt(sum(x * x for x in quaternion))
    return [round(x / norm, 6) for x in quaternion]


def _hand(name: str, object_: str, turn: list[float], offset: tuple[float, float, float], position: float, angle: float, test: str, differs: str = "") -> Entry:
    """The object of the Shadow hand, turned about axes of the world and moved from where it rests."""
    p, q = HAND_OBJECT[object_]
    goal = {"position": [round(a + b, 5) for a, b in zip(p, offset)], "quaternion_wxyz": _unit(_multiply(turn, q))}
    task = {
        "scene": {"file": f"gymnasium_robotics/envs/assets/hand/manipulate_{object_}.xml"},
        "start": {"objects": {"object": {"position": p, "quaternion_wxyz": _unit(q)}}, "joints": HAND_JOINTS[object_]},
        "goal": {"objects": {"object": goal}},
        "tolerance": {"position": position, "angle": angle},
    }
    return Entry(f"shadow_{name}", "in hand", test, task, "; ".join(filter(None, [RESTING, differs])))


FULL = "within 10 mm and 0.1 rad of the goal"
SHADOW = [
    _hand("block_rotate_z", "block", _quarter(math.pi / 2), (0, 0, 0), 0.02, 0.1, "within 0.1 rad of the goal", "must stay within 20 mm as well"),
    _hand("block_rotate_xyz", "block", _quarter(math.pi / 2, "x"), (0, 0, 0), 0.02, 0.1, "within 0.1 rad of the goal", "must stay within 20 mm as well"),
    _hand("block_full", "block", _quarter(math.pi / 2), (0, -0.02, 0), 0.01, 0.1, FULL),
    _hand("egg_rotate", "egg", _quarter(math.pi / 2), (0, 0, 0), 0.02, 0.1, "within 0.1 rad of the goal", "must stay within 20 mm as well"),
    _hand("egg_full", "egg", _quarter(math.pi / 2), (0, -0.01, 0.01), 0.01, 0.1, FULL),
    _hand("pen_rotate", "pen", _quarter(0.7), (0, 0, 0), 0.05, 0.1, "axis within 0.1 rad of the goal", "turned about the vertical; must stay within 50 mm, and not roll"),
    _hand("pen_full", "pen", _quarter(0.7), (0.02, -0.02, 0), 0.05, 0.1, "within 50 mm and 0.1 rad of the goal", "must not roll about its axis"),
]  # fmt: skip

ADROIT = "gymnasium_robotics/envs/assets/adroit_hand"
ADROIT_TASKS = [
    Entry("adroit_door", "joints", "door opened by 1.35 rad",
          {"scene": {"file": f"{ADROIT}/adroit_door.xml"}, "goal": {"objects": {"door": _joint(_beyond(1.37))}}, "tolerance": {"position": 0.02, "angle": 0.02}}),
    Entry("adroit_hammer", "tools", "nail within 10 mm of its board",
          {"scene": _apart(f"{ADROIT}/adroit_hammer.xml", ("robot", "nail")), "goal": {"objects": {"nail": _joint(_beyond(0.085))}}, "tolerance": {"position": 0.005, "angle": 0.1}}, THROUGH),
]  # fmt: skip

FETCH = "base and torso, which damping of 1e7 and more holds in the file, are joints like the others here and may move; the object weighs 2 kg"


def _fetch(name: str, set_: str, file: str, start: tuple[float, float, float], goal: tuple[float, float, float], scene: dict[str, Any] | None = None, base: float = 0.405, differs: str = "") -> Entry:
    task = {
        "scene": {"file": f"gymnasium_robotics/envs/assets/fetch/{file}.xml"} | (scene or {}),
        "start": {
            "objects": {"object0": _free(*start)},
            "joints": {"robot0:slide0": base, "robot0:slide1": 0.48, "robot0:slide2": 0},
            "poses": {"robot0:gripper_link": {"position": [base + 0.9169, 0.7491, 0.55], "quaternion_wxyz": [math.sqrt(0.5), 0, math.sqrt(0.5), 0]}},
        },
        "goal": _place("object0", *goal),
        "tolerance": {"position": 0.05, "angle": 0.1},
    }
    return Entry(f"fetch_{name}", set_, "object within 50 mm of the goal", task, "; ".join(filter(None, [FETCH, differs])))


UNACTUATED = {"robot": {"bodies": ["robot0:base_link"]}}
FETCHES = [
    _fetch("push", "push", "push", (1.3419, 0.63, 0.425), (1.42, 0.83, 0.425), UNACTUATED),
    _fetch("slide", "push", "slide", (0.9869, 0.63, 0.42), (1.15, 0.75, 0.42), UNACTUATED, 0.05, "goal within reach of the arm, where the maker's lies 0.4 m ahead on average"),
    _fetch("pick_and_place", "pick and place", "pick_and_place", (1.3419, 0.63, 0.425), (1.42, 0.75, 0.55)),
]

# ---- robosuite: arm, gripper and table of the package; what its Python code adds is written here

PANDA = {
    "name": "panda", "mjcf": "robosuite/models/assets/robots/panda/robot.xml", "base": {"position": [-0.56, 0, 0.912]},
    "mount": {"file": "robosuite/models/assets/grippers/panda_gripper.xml", "on": "right_hand"},
}  # fmt: skip
PANDA_JOINTS = [0, math.pi / 16, 0, -5 * math.pi / 6, 0, math.pi - 0.2, math.pi / 4, 0.020833, -0.020833]
TABLE = {"name": "table", "shapes": [{"box": {"size": [0.8, 0.8, 0.05]}, "pose": {"position": [0, 0, 0.775]}, "friction": 1}]}


def _cube(name: str, size: float) -> dict[str, Any]:
    return {"name": name, "joint": "free", "mass": 1000 * size**3, "shapes": [{"box": {"size": [size] * 3}, "friction": 1}]}


def _table(objects: list[dict[str, Any]], start: dict[str, Any], goal: dict[str, Any], position: float, robot: dict[str, Any] = PANDA) -> dict[str, Any]:
    return {
        "scene": {"robots": [robot], "objects": objects, "fixed": [TABLE], "gravity": [0, 0, -9.81]},
        "start": {"objects": start, "joints": PANDA_JOINTS},
        "goal": goal,
        "tolerance": {"position": position, "angle": 0.1},
    }


WRITTEN = "table and objects are written here, since the maker's code makes them"
DOOR_FRAME = {
    "name": "frame", "shapes": [
        {"cylinder": {"radius": 0.03, "length": 0.6}, "pose": {"position": [-0.452441, -0.308672, 1.1]}},
        {"cylinder": {"radius": 0.03, "length": 0.6}, "pose": {"position": [0.0536301, -0.371854, 1.1]}},
    ],
}  # fmt: skip
DOOR_TABLE = {"name": "table", "shapes": [{"box": {"size": [0.8, 0.3, 0.05]}, "pose": {"position": [-0.2, -0.35, 0.775]}}]}
PANEL = {"box": {"size": [0.44, 0.04, 0.58]}, "pose": {"position": [-0.255, 0, 0]}, "friction": 1}
DOOR = {
    "name": "door", "joint": "hinge", "axis": [0, 0, 1], "mass": 2.53455, "limits": [0, 0.4], "joint_friction": 0.001, "joint_damping": 0.1,
    "pose": {"position": [-0.452441, -0.308672, 1.1], "quaternion_wxyz": [-0.062062, 0, 0, -0.998072]},
}  # fmt: skip
HANDLE = [
    {"cylinder": {"radius": 0.025, "length": 0.125}, "pose": {"position": [-0.43, -0.0625, -0.025], "quaternion_wxyz": _quarter(-math.pi / 2, "x")}, "friction": 1},
    {"box": {"size": [0.15, 0.03, 0.04]}, "pose": {"position": [-0.355, -0.1, -0.025]}, "friction": 1},
]
LATCH = {
    "name": "latch", "joint": "hinge", "axis": [0, 1, 0], "mass": 0.1, "parent": "door", "limits": [-1.57, 1.57], "joint_friction": 0.1,
    "joint_stiffness": 1, "pose": {"position": [-0.43, 0, -0.025]},
    "shapes": [
        {"cylinder": {"radius": 0.025, "length": 0.1875}, "pose": {"position": [0, -0.03125, 0], "quaternion_wxyz": _quarter(math.pi / 2, "x")}, "friction": 1},
        {"box": {"size": [0.15, 0.03, 0.04]}, "pose": {"position": [0.075, -0.1, 0]}, "friction": 1},
        {"box": {"size": [0.05, 0.025, 0.0625]}, "pose": {"position": [-0.03125, 0.05, 0], "quaternion_wxyz": _quarter(math.pi / 2, "y")}, "friction": 1},
        {"cylinder": {"radius": 0.025, "length": 0.025}, "pose": {"position": [-0.0625, 0.05, 0], "quaternion_wxyz": _quarter(math.pi / 2, "x")}, "friction": 1},
    ],
}  # fmt: skip


def _door(name: str, objects: list[dict[str, Any]]) -> Entry:
    task = {
        "scene": {"robots": [PANDA], "objects": objects, "fixed": [DOOR_FRAME, DOOR_TABLE], "gravity": [0, 0, -9.81]},
        "start": {"objects": {o["name"]: _joint(0) for o in objects}, "joints": PANDA_JOINTS},
        "goal": {"objects": {"door": _joint(_beyond(0.32))}},
        "tolerance": {"position": 0.01, "angle": 0.02},
    }
    return Entry(f"robosuite_{name}", "joints", "door opened by 0.3 rad", task, WRITTEN)


ROBOSUITE = [
    _door("door", [DOOR | {"shapes": [PANEL, *HANDLE]}]),
    _door("door_latch", [DOOR | {"mass": 2.43455, "shapes": [PANEL]}, LATCH]),
    Entry("robosuite_lift", "pick and place", "cube more than 40 mm above the table",
          _table([_cube("cube", 0.042)], {"cube": _free(0, 0, 0.821)}, {"objects": {"cube": {"position": [None, None, _beyond(0.845)], "rpy": None}}}, 0.005), WRITTEN),
    Entry("robosuite_stack", "pick and place", "cube A rests on cube B",
          _table([_cube("cubeA", 0.04), _cube("cubeB", 0.05)], {"cubeA": _free(-0.05, 0.05, 0.82), "cubeB": _free(0.05, -0.05, 0.825)},
                 {"objects": {"cubeA": {"position": [0.05, -0.05, 0.87], "rpy": [0, 0, None]}}}, 0.01), WRITTEN),
]  # fmt: skip

# ---- playground

ALOHA = [
    Entry("aloha_hand_over", "whole arm", "box at its target, carried by the other hand",
          {"scene": {"file": "mujoco_playground/_src/manipulation/aloha/xmls/mjx_hand_over.xml"}, "start": {"keyframe": "home"},
           "goal": _place("box", 0.1, 0, 0.15), "tolerance": {"position": 0.05, "angle": 0.1}}, "any hand may carry it"),
    Entry("aloha_peg_insertion", "insertion", "peg in its socket, both in the air",
          {"scene": {"file": "mujoco_playground/_src/manipulation/aloha/xmls/mjx_single_peg_insertion.xml"}, "start": {"keyframe": "home"},
           "goal": _place("peg", -0.03, 0, 0.0228), "tolerance": {"position": 0.02, "angle": 0.1}}, "the socket may stay where it lies"),
    Entry("leap_cube", "in hand", "cube within 0.1 rad of the goal",
          {"scene": {"file": "mujoco_playground/_src/manipulation/leap_hand/xmls/scene_mjx_cube.xml"}, "start": {"keyframe": "home"},
           "goal": {"objects": {"cube": {"position": [0.1, 0, 0.05], "quaternion_wxyz": _unit(_quarter(math.pi / 3))}}}, "tolerance": {"position": 0.03, "angle": 0.1}}),
]  # fmt: skip

# ---- push-T: a point pushes the T of two boxes

PUSHER = (
    "<mujoco><compiler angle='radian'/><worldbody><body name='rail'><body name='pusher'><joint name='x' type='slide' axis='1 0 0' range='-0.5 0.5' limited='true'/>"
    "<joint name='y' type='slide' axis='0 1 0' range='-0.5 0.5' limited='true'/><geom name='tip' size='0.01' mass='0.2' friction='0.5'/></body></body></worldbody>"
    "<actuator><position joint='x' kp='500' kv='20' forcerange='-10 10'/><position joint='y' kp='500' kv='20' forcerange='-10 10'/></actuator></mujoco>"
)
T = [{"box": {"size": [0.2, 0.05, 0.04]}, "pose": {"position": [0, 0.025, 0]}}, {"box": {"size": [0.05, 0.15, 0.04]}, "pose": {"position": [0, -0.075, 0]}}]
PUSH_T = [
    Entry("push_t_planar", "push", "within 10 mm and 0.1 rad of the goal",
          {"scene": {"robots": [{"name": "p", "mjcf": PUSHER}], "objects": [{"name": "t", "joint": "planar_xy", "mass": 0.1, "friction": 0.5, "shapes": T}]},
           "start": {"objects": {"t": _joint(0, 0, 0)}, "joints": [0, -0.2]}, "goal": {"objects": {"t": _joint(0.05, 0.05, 1.5708)}}, "tolerance": {"position": 0.01, "angle": 0.1}},
          "start and goal of IMPACT's push-T, with a robot of two slides and without friction on the ground"),
    Entry("push_t_table", "push", "within 10 mm and 0.1 rad of the goal",
          {"scene": {"robots": [{"name": "p", "mjcf": PUSHER, "base": {"position": [0, 0, 0.02]}}], "objects": [{"name": "t", "joint": "free", "mass": 0.1, "friction": 0.5, "shapes": T}],
                     "fixed": [{"name": "table", "friction": 0.5, "shapes": [{"half_space": {}}]}], "filters": [{"exclude": ["p/*", "table"]}], "gravity": [0, 0, -9.81]},
           "start": {"objects": {"t": _free(0, 0, 0.02)}, "joints": [0, -0.2]}, "goal": {"objects": {"t": _free(0.05, 0.05, 0.02, _unit(_quarter(math.pi / 2)))}},
           "tolerance": {"position": 0.01, "angle": 0.1}},
          "the same T, which lies on a table and slides with friction"),
]  # fmt: skip

# ---- built-in tasks, of which only scene, start, goal and tolerance are taken

BUILT_IN = [
    Entry(name, set_, "the tolerance of the task", {"base": name}, "built in")
    for set_, names in {
        "push": ("planar_pushing", "ur5_mesh_push"),
        "in hand": ("planar_hand", "allegro_ball", "allegro_cube", "allegro_cube_180", "allegro_cube_roll", "allegro_pen"),
        "joints": ("allegro_door",),
        "pick and place": ("allegro_plate",),
        "whole arm": ("iiwa_bimanual", "iiwa_bimanual_box", "iiwa_bimanual_planar"),
    }.items()
    for name in names
]

ENTRIES = [*METAWORLD_JOINTS, *METAWORLD_FREE, *KITCHEN, *SHADOW, *ADROIT_TASKS, *FETCHES, *ROBOSUITE, *ALOHA, *PUSH_T, *BUILT_IN]


def select(words: Iterable[str]) -> list[Entry]:
    """The tasks of sets, or of names; all where there is no word. Raises InvalidInput."""
    words = list(words)
    known = {entry.name for entry in ENTRIES}
    for word in words:
        if word not in SETS and word not in known:
            near = sorted(name for name in known if word in name)[:5]
            raise InvalidInput(f"SET: got '{word}', expected {', '.join(repr(s) for s in SETS)} or the name of a task{f', as {chr(44).join(near)}' if near else ''}")
    return [entry for entry in ENTRIES if not words or entry.set in words or entry.name in words]


def find_packages(folder: Path | None) -> dict[str, Path]:
    """Where the packages are whose scenes are used: below a folder, or installed. They are not imported, so that theirs need not be there."""
    out = {}
    for name in WHEELS:
        if folder is not None:
            found = folder / name if (folder / name).is_dir() else None
        else:
            spec = importlib.util.find_spec(name)
            found = Path(spec.origin).parent if spec is not None and spec.origin is not None else None
        if found is not None:
            out[name] = found.resolve()
    return out


def _with_paths(value: Any, packages: Mapping[str, Path]) -> Any:
    if isinstance(value, str):
        head, slash, rest = value.partition("/")
        return str(packages[head] / rest) if slash and head in packages else value
    if isinstance(value, Mapping):
        return {key: _with_paths(inner, packages) for key, inner in value.items()}
    return [_with_paths(inner, packages) for inner in value] if isinstance(value, (list, tuple)) else value


def to_yaml(entry: Entry, packages: Mapping[str, Path]) -> str:
    """The task as a file: a key to a line, values in YAML's flow style."""
    lines = [f"# {entry.test}", *([f"# {entry.differs}"] if entry.differs else [])]
    task = entry.task | ({"base": str(load_task(entry.task["base"]).file)} if "base" in entry.task else {})
    for key, value in ({"name": entry.name} | _with_paths(task, packages)).items():
        lines.append(f"{key}: {json.dumps(value, ensure_ascii=False)}")
    return "\n".join(lines) + "\n"
