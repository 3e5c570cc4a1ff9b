"""The controls beside the scene, one class for each part of the page. They know no task: the parts of the studio fill and read them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from .exporting import CHOICES
from .form import Field
from .own_scene import SHAPES
from .texts import plain

Post = Callable[[Callable[[], None]], None]
NOTHING = "nothing"
AS_GIVEN = "as given"
POSE, RESULT = "pose", "result"
SEEN, TOUCHES = "what is seen", "what touches"
Range = tuple[float, float] | None
CHART_HEIGHT = 130  # [px]
BLUE, RED, ORANGE, GREEN = "#2a6fd6", "#ce184a", "#ee7e24", "#26a05c"


class Handlers:
    """Who answers each control, by its name. `post` hands a call to the thread that owns the studio."""

    def __init__(self, post: Post):
        self._post = post
        self.by_name: dict[str, Callable[..., None]] = {}

    def add(self, **handlers: Callable[..., None]) -> None:
        self.by_name |= handlers

    def call(self, name: str, *words: Any) -> None:
        self._post(lambda: self.by_name[name](*words))

    def on_update(self, handle: Any, name: str) -> Any:
        handle.on_update(lambda _: self.call(name))
        return handle

    def on_click(self, handle: viser.GuiButtonHandle, name: str) -> viser.GuiButtonHandle:
        handle.on_click(lambda _: self.call(name))
        return handle


def set_choices(handle: viser.GuiDropdownHandle[str], choices: Sequence[str], value: str) -> None:
    distinct = tuple(dict.fromkeys(choices))  # the page cannot draw two of the same
    if tuple(handle.options) != distinct:
        handle.options = distinct
    if handle.value != value:
        handle.value = value


class HeadControls:
    """What is open, and one message."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers, labels: Sequence[str]):
        hint = "Built-in tasks and scenarios, and the files of the folder that was given"
        self.pick = handlers.on_update(gui.add_dropdown("Open", tuple(labels), hint=hint), "pick")
        self.about = gui.add_markdown("")
        self.notes_folder = gui.add_folder("Read otherwise than written", expand_by_default=False, visible=False)
        with self.notes_folder:
            self.notes = gui.add_markdown("")
        self.seen = handlers.on_update(gui.add_dropdown("Draw", (SEEN, TOUCHES), visible=False, hint="Bodies as their files show them, or the shapes that the planner lets touch"), "seen")
        self.message = gui.add_markdown("", visible=False)

    def describe(self, text: str, notes: Sequence[str] = ()) -> None:
        """What is open, in markdown, and what its reader has to say of it, in plain text."""
        self.about.content = text
        self.notes.content = "\n".join(f"- {plain(note)}" for note in notes)
        self.notes_folder.visible = bool(notes)

    def say(self, text: str, fault: bool = False) -> None:
        """In markdown, but a fault in plain text. Empty: no message."""
        self.message.content = (f"**⚠ {plain(text)}**" if fault else text) if text else ""
        self.message.visible = bool(text)


class SearchControls:
    """How a plan is searched for, and how far the job is that runs."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        with gui.add_folder("Search"):
            self.seed = handlers.on_update(gui.add_number("Seed", 0, min=0, step=1, hint="The same seed gives the same plan"), "seed")
            self.budget = gui.add_number("Time at most [s]", 20.0, min=1.0, max=600.0, step=1.0)
            self.refine = gui.add_checkbox("Refine it", False, hint="Shorter, with room in its regrasps; takes a few seconds more")
            self.again = gui.add_checkbox("Plan anew when moved", False)
            self.plan = handlers.on_click(gui.add_button("Plan", color="blue"), "plan")
            self.cancel = handlers.on_click(gui.add_button("Cancel", visible=False, hint="Keeps the best path so far"), "cancel")
            self.progress = gui.add_progress_bar(0.0, visible=False)
            self.progress_text = gui.add_markdown("", visible=False)

    def show_job(self, runs: bool) -> None:
        if runs:
            self.progress.value = 0.0
        for handle in (self.cancel, self.progress, self.progress_text):
            handle.visible = runs
        self.plan.disabled = runs

    def show_progress(self, fraction: float, text: str) -> None:
        self.progress.value = 100 * min(1.0, fraction)
        self.progress_text.content = plain(text)


class RunControls:
    """A closed loop that is watched."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        with gui.add_folder("Closed loop"):
            hint = "In MuJoCo: the plan that is shown, or the task, replanned wherever something is in the way. Drag an object with the mouse to pull at it. It goes on until it is cancelled"
            self.newton = gui.add_number("Pull at most [N]", 10.0, min=0.01, hint="At first the weight of the object; reached when the mouse is as far away as the object is long")
            self.run = handlers.on_click(gui.add_button("Run live", hint=hint), "run")


class PlaybackControls:
    """Which motion is seen, and its moment."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        self.folder = gui.add_folder("Look", visible=False)
        with self.folder:
            self.view = gui.add_button_group("Show", (POSE, RESULT))
            self.view.on_click(lambda _: handlers.call("view", str(self.view.value)))
            self.which = handlers.on_update(gui.add_dropdown("Plan", (NOTHING,)), "which")
            self.beside = handlers.on_update(gui.add_dropdown("Beside it", (NOTHING,), hint="A second plan, or the same one in MuJoCo"), "beside")
            self.frame = gui.add_slider("Knot", 0, 1, 1, 0)
            self.play = gui.add_checkbox("Play", False)
            self.speed = gui.add_slider("Speed [1/s]", 2, 96, 1, 24, hint="Knots per second")
            self.line = gui.add_markdown("")
            live_hint = "As it happens, at the pace of a clock. Click on a robot that senses to push it there; drag a link of one that is controlled to pull at it"
            self.live = handlers.on_click(gui.add_button("Live", visible=False, hint=live_hint), "live")
            self.simulate = handlers.on_click(gui.add_button("Run in MuJoCo", hint="Open loop, beside the plan"), "simulate")
            self.check = handlers.on_click(gui.add_button("Check", hint="Simulated anew at half the step by code that shares nothing with the planner"), "check")


class PoseControls:
    """Start and goal in numbers, and what lint finds."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        self._gui, self._handlers = gui, handlers
        self.faults = gui.add_markdown("")
        self.handle = handlers.on_update(gui.add_dropdown("Drag", (NOTHING,), hint="What the arrows and rings in the scene move. A click on a link takes that link: its joints follow"), "handle")
        self.posture = gui.add_markdown("", visible=False)
        self.undo = handlers.on_click(gui.add_button("Undo", disabled=True, hint="Start and goal before the last drag or number"), "undo")
        self.keyframe = handlers.on_update(gui.add_dropdown("Start at", (AS_GIVEN,), visible=False, hint="A keyframe of the scene"), "keyframe")
        self.goal_of = handlers.on_update(gui.add_dropdown("Goal of", (NOTHING,), visible=False, hint="Which object is to be moved"), "goal_of")
        self.goal_folder = gui.add_folder("Goal (green)")
        with self.goal_folder:
            self.any_turn = handlers.on_update(gui.add_checkbox("any orientation will do", False, visible=False), "any_turn")
        self.start_folder = gui.add_folder("Start of the object", expand_by_default=False)
        self.joints_folder = gui.add_folder("Start of the joints", expand_by_default=False)
        self.reset = handlers.on_click(gui.add_button("Back to the task", hint="Start, goal and options as the task has them"), "reset")
        self.goal: list[viser.GuiNumberHandle[float]] = []
        self.start: list[viser.GuiNumberHandle[float]] = []
        self.joints: list[viser.GuiSliderHandle[float]] = []

    def fill_goal(self, names: Sequence[str], values: Sequence[float], step: float, ranges: Sequence[Range]) -> None:
        """A number for each; a slider where it has a range."""
        self.goal = self._fill(self.goal_folder, self.goal, names, values, step, ranges, "goal")

    def fill_start(self, names: Sequence[str], values: Sequence[float], step: float, ranges: Sequence[Range]) -> None:
        self.start = self._fill(self.start_folder, self.start, names, values, step, ranges, "start")

    def _fill(self, folder: viser.GuiFolderHandle, old: list[Any], names: Sequence[str], values: Sequence[float], step: float, ranges: Sequence[Range], name: str) -> list[Any]:
        for handle in old:
            handle.remove()
        with folder:
            return [self._handlers.on_update(self._number(n, float(v), 0.01 if "rad" in n else step, r), name) for n, v, r in zip(names, values, ranges)]

    def _number(self, label: str, value: float, step: float, limits: Range) -> Any:
        if limits is None:
            return self._gui.add_number(label, value, step=step)
        low, high = limits
        return self._gui.add_slider(label, low, high, (high - low) / 500, float(np.clip(value, low, high)))

    def fill_joints(self, names: Sequence[str], ranges: Sequence[tuple[float, float]], values: Sequence[float], units: Sequence[str]) -> None:
        for handle in self.joints:
            handle.remove()
        self.joints = []
        with self.joints_folder:
            for name, (low, high), value, unit in zip(names, ranges, values, units):
                step = (high - low) / 500
                slider = self._gui.add_slider(f"{name} [{unit}]", low, high, step, float(np.clip(value, low, high)))
                self.joints.append(self._handlers.on_update(slider, "joints"))


class FigureControls:
    """What came out, in words and charts."""

    def __init__(self, gui: viser.GuiApi):
        self._gui = gui
        self.words = gui.add_markdown("Nothing is planned yet.")
        self.folder = gui.add_folder("Along the motion", visible=False)
        self.charts: list[viser.GuiUplotHandle] = []

    def fill_charts(self, x: np.ndarray, x_name: str, charts: Sequence[tuple[str, str, np.ndarray, str]]) -> None:
        """Title, unit, values and colour of each; none: none."""
        for chart in self.charts:
            chart.remove()
        self.charts = []
        self.folder.visible = bool(charts) and len(x) >= 2
        if len(x) < 2:
            return
        with self.folder:
            for title, unit, values, color in charts:
                plot = self._gui.add_uplot(
                    (x.astype(float), np.nan_to_num(values)),
                    ({"label": x_name}, {"label": f"{title} [{unit}]", "stroke": color, "width": 1.5}),
                    title=f"{title} [{unit}]",
                    height=CHART_HEIGHT,
                    scales={"x": {"time": False}},
                    legend={"show": False},
                    axes=({"size": 26}, {"size": 44}),
                )
                self.charts.append(plot)


class OptionControls:
    """One field for each option of the planner."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        self._gui, self._handlers = gui, handlers
        gui.add_markdown("A task needs none: they follow from the scene. Point at one to read what it is.")
        self.fault = gui.add_markdown("", visible=False)
        self.reset = handlers.on_click(gui.add_button("Reset all"), "options_reset")
        self.folder = gui.add_folder("Options")
        self.fields: dict[str, tuple[Field, Any]] = {}

    def say(self, text: str) -> None:
        """Empty: nothing."""
        if text:
            self.fault.content = text
        self.fault.visible = bool(text)

    def fill(self, fields: Sequence[Field], values: dict[str, Any]) -> None:
        for _, handle in self.fields.values():
            handle.remove()
        self.fields = {}
        for field in fields:
            with self.folder:
                self.fields[field.name] = (field, self._handlers.on_update(self._option(field, field.write(values.get(field.name))), "options"))

    def _option(self, field: Field, value: Any) -> Any:
        gui, label, hint = self._gui, field.name, field.meaning
        match field.kind:
            case "bool":
                return gui.add_checkbox(label, value, hint=hint)
            case "int":
                return gui.add_number(label, value, min=None if field.low is None else int(field.low), max=None if field.high is None else int(field.high), step=1, hint=hint)
            case "number":
                return gui.add_number(label, float(value), min=field.low, max=field.high, hint=hint)
            case "choice":
                return gui.add_dropdown(label, field.choices, initial_value=value, hint=hint)
            case _:
                return gui.add_text(label, value, hint=hint)


class OwnControls:
    """A robot and an object that are dropped."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        gui.add_markdown("Drop a robot (URDF, MJCF or SDF) and the meshes that it names, one file after the other; then an object: a shape, or a mesh that you dropped.")
        self.upload = gui.add_upload_button("Add a file", hint="At most 20 MB; .urdf, .xml, .mjcf, .sdf, .stl, .obj, .dae")
        self.upload.on_upload(lambda _: handlers.call("upload", self.upload.value.name, self.upload.value.content))
        self.uploaded = gui.add_markdown("No files yet.")
        self.robot = gui.add_dropdown("Robot", (NOTHING,))
        self.kind = handlers.on_update(gui.add_dropdown("Object", tuple(SHAPES)), "kind")
        self.sizes = [gui.add_number(f"size {k}", 0.06, min=1e-4, step=0.001) for k in range(3)]
        self.scale = gui.add_number("scale of the mesh", 1.0, min=1e-6, step=0.001, visible=False, hint="0.001 for a mesh in millimetres")
        self.mass = gui.add_number("mass [kg]", 0.1, min=1e-6, step=0.01)
        self.friction = gui.add_number("friction", 0.8, min=0.0, max=10.0, step=0.05)
        self.floor = gui.add_checkbox("on a floor", True)
        self.make = handlers.on_click(gui.add_button("Make the scene", color="blue"), "make")

    def show_sizes(self, kind: str) -> None:
        """The sizes that a shape has."""
        names = SHAPES.get(kind, ())
        for k, handle in enumerate(self.sizes):
            handle.visible = k < len(names)
            if k < len(names):
                handle.label = names[k]
        self.scale.visible = kind not in SHAPES


class ExportControls:
    """What is taken away."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers):
        self.format = gui.add_dropdown("What", CHOICES, hint="csv, npz, json, mcap: joints, commands, torques, poses, contacts over time. everything: a zip of all of them")
        self.save = gui.add_button("Download")
        self.save.on_click(lambda event: handlers.call("save", event.client))
        gui.add_markdown("The same again, on the command line:")
        self.command = gui.add_markdown("")
        self.note = gui.add_text("What went wrong", "", hint="It is put into the report")
        self.report = gui.add_button("Report a problem", hint="A zip of task, plan, seed and version, without paths and names. Nothing is sent: look at it, then send it yourself")
        self.report.on_click(lambda event: handlers.call("report", event.client))


class Panel:
    """All controls, laid out."""

    def __init__(self, gui: viser.GuiApi, handlers: Handlers, labels: Sequence[str]):
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=(38, 96, 180))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(390)
        self.head = HeadControls(gui, handlers, labels)
        self.search = SearchControls(gui, handlers)
        self.run = RunControls(gui, handlers)
        self.playback = PlaybackControls(gui, handlers)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Pose"):
            self.pose = PoseControls(gui, handlers)
        with tabs.add_tab("Figures"):
            self.figures = FigureControls(gui)
        with tabs.add_tab("Options"):
            self.options = OptionControls(gui, handlers)
        with tabs.add_tab("Own"):
            self.own = OwnControls(gui, handlers)
        with tabs.add_tab("Export"):
            self.export = ExportControls(gui, handlers)
