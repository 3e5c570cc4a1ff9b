"""The controls beside the scene. They know no task: what is pressed or moved is posted to the application, which fills them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from .exporting import CHOICES
from .form import Field
from .own_scene import SHAPES

Post = Callable[[Callable[[], None]], None]
NOTHING = "nothing"
POSE, RESULT = "pose", "result"
CHART_HEIGHT = 130  # [px]
BLUE, RED, ORANGE, GREEN = "#2a6fd6", "#ce184a", "#ee7e24", "#26a05c"


class Controls:
    """Widgets; `post` hands a call to the thread that owns the application."""

    def __init__(self, server: viser.ViserServer, post: Post, labels: Sequence[str], on: dict[str, Callable[..., None]]):
        self.server, self.gui, self.post, self.on = server, server.gui, post, on
        gui = self.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=(38, 96, 180))
        gui.main_panel.dock_right()
        gui.main_panel.set_width(390)
        self.pick = self._input(gui.add_dropdown("Open", tuple(labels), hint="Built-in tasks and scenarios, and the files of the folder that was given"), "pick")
        self.about = gui.add_markdown("")
        self.message = gui.add_markdown("", visible=False)
        self._add_search()
        self._add_playback()
        tabs = gui.add_tab_group()
        with tabs.add_tab("Pose"):
            self._add_pose()
        with tabs.add_tab("Figures"):
            self.figures = gui.add_markdown("Nothing is planned yet.")
            self.charts = gui.add_folder("Along the motion", visible=False)
            self._charts: list[viser.GuiUplotHandle] = []
        with tabs.add_tab("Options"):
            self._add_options()
        with tabs.add_tab("Own"):
            self._add_own()
        with tabs.add_tab("Export"):
            self.format = gui.add_dropdown("What", CHOICES, hint="csv, npz, json, mcap: joints, commands, torques, poses, contacts over time. everything: a zip of all of them")
            self.save = gui.add_button("Download")
            self.save.on_click(lambda event: self.post(lambda: self.on["save"](event.client)))
            gui.add_markdown("The same again, on the command line:")
            self.command = gui.add_markdown("")

    # ---- parts ----

    def _add_search(self) -> None:
        gui = self.gui
        with gui.add_folder("Search"):
            self.seed = self._input(gui.add_number("Seed", 0, min=0, step=1, hint="The same seed gives the same plan"), "seed")
            self.budget = gui.add_number("Time at most [s]", 20.0, min=1.0, max=600.0, step=1.0)
            self.refine = gui.add_checkbox("Refine it", False, hint="Shorter, with room in its regrasps; takes a few seconds more")
            self.again = gui.add_checkbox("Plan anew when moved", False)
            self.plan = self._button("Plan", "plan", color="blue")
            self.cancel = self._button("Cancel", "cancel", visible=False, hint="Keeps the best path so far")
            self.progress = gui.add_progress_bar(0.0, visible=False)
            self.progress_text = gui.add_markdown("", visible=False)

    def _add_playback(self) -> None:
        gui = self.gui
        self.playback = gui.add_folder("Look", visible=False)
        with self.playback:
            self.view = gui.add_button_group("Show", (POSE, RESULT))
            self.view.on_click(lambda _: self.post(lambda: self.on["view"](str(self.view.value))))
            self.which = self._input(gui.add_dropdown("Plan", (NOTHING,)), "which")
            self.beside = self._input(gui.add_dropdown("Beside it", (NOTHING,), hint="A second plan, or the same one in MuJoCo"), "beside")
            self.frame = gui.add_slider("Knot", 0, 1, 1, 0)
            self.play = gui.add_checkbox("Play", False)
            self.speed = gui.add_slider("Speed [1/s]", 2, 96, 1, 24, hint="Knots per second")
            self.line = gui.add_markdown("")
            self.simulate = self._button("Run in MuJoCo", "simulate", hint="Open loop, beside the plan")
            self.check = self._button("Check", "check", hint="Simulated anew at half the step by code that shares nothing with the planner")

    def _add_pose(self) -> None:
        gui = self.gui
        self.faults = gui.add_markdown("")
        self.handle = self._input(gui.add_dropdown("Drag", (NOTHING,), hint="What the arrows and rings in the scene move"), "handle")
        self.goal_folder = gui.add_folder("Goal (green)")
        self.start_folder = gui.add_folder("Start of the object", expand_by_default=False)
        self.joints_folder = gui.add_folder("Start of the joints", expand_by_default=False)
        self.reset = self._button("Back to the task", "reset", hint="Start, goal and options as the task has them")
        self.goal: list[viser.GuiNumberHandle[float]] = []
        self.start: list[viser.GuiNumberHandle[float]] = []
        self.joints: list[viser.GuiSliderHandle[float]] = []

    def _add_options(self) -> None:
        gui = self.gui
        gui.add_markdown("A task needs none: they follow from the scene. Point at one to read what it is.")
        self.options_fault = gui.add_markdown("", visible=False)
        self.options_reset = self._button("Reset all", "options_reset")
        self.options_folder = gui.add_folder("Options")
        self.options: dict[str, tuple[Field, Any]] = {}

    def _add_own(self) -> None:
        gui = self.gui
        gui.add_markdown("Drop a robot (URDF or MJCF) and the meshes that it names, one file after the other; then an object: a shape, or a mesh that you dropped.")
        self.upload = gui.add_upload_button("Add a file", hint="At most 20 MB; .urdf, .xml, .mjcf, .stl, .obj, .dae")
        self.upload.on_upload(lambda _: self.post(lambda: self.on["upload"](self.upload.value.name, self.upload.value.content)))
        self.uploaded = gui.add_markdown("No files yet.")
        self.robot = gui.add_dropdown("Robot", (NOTHING,))
        self.kind = self._input(gui.add_dropdown("Object", tuple(SHAPES)), "kind")
        self.sizes = [gui.add_number(f"size {k}", 0.06, min=1e-4, step=0.001) for k in range(3)]
        self.scale = gui.add_number("scale of the mesh", 1.0, min=1e-6, step=0.001, visible=False, hint="0.001 for a mesh in millimetres")
        self.mass = gui.add_number("mass [kg]", 0.1, min=1e-6, step=0.01)
        self.friction = gui.add_number("friction", 0.8, min=0.0, max=10.0, step=0.05)
        self.floor = gui.add_checkbox("on a floor", True)
        self.make = self._button("Make the scene", "make", color="blue")

    # ---- helpers ----

    def _input(self, handle: Any, name: str) -> Any:
        handle.on_update(lambda _: self.post(lambda: self.on[name]()))
        return handle

    def _button(self, label: str, name: str, **more: Any) -> viser.GuiButtonHandle:
        button = self.gui.add_button(label, **more)
        button.on_click(lambda _: self.post(lambda: self.on[name]()))
        return button

    def say(self, text: str, fault: bool = False) -> None:
        """One message under the picker; empty: none."""
        self.message.content = (f"**⚠ {text}**" if fault else text) if text else ""
        self.message.visible = bool(text)

    # ---- filled anew for every task ----

    def fill_numbers(self, folder: viser.GuiFolderHandle, old: list[Any], names: Sequence[str], values: Sequence[float], step: float, name: str) -> list[Any]:
        for handle in old:
            handle.remove()
        with folder:
            return [self._input(self.gui.add_number(n, float(v), step=0.01 if "rad" in n else step), name) for n, v in zip(names, values)]

    def fill_joints(self, names: Sequence[str], ranges: Sequence[tuple[float, float]], values: Sequence[float], units: Sequence[str]) -> None:
        for handle in self.joints:
            handle.remove()
        self.joints = []
        with self.joints_folder:
            for name, (low, high), value, unit in zip(names, ranges, values, units):
                step = (high - low) / 500
                slider = self.gui.add_slider(f"{name} [{unit}]", low, high, step, float(np.clip(value, low, high)))
                self.joints.append(self._input(slider, "joints"))

    def fill_options(self, fields: Sequence[Field], values: dict[str, Any]) -> None:
        for _, handle in self.options.values():
            handle.remove()
        self.options = {}
        for field in fields:
            with self.options_folder:
                self.options[field.name] = (field, self._input(self._option(field, field.write(values.get(field.name))), "options"))

    def _option(self, field: Field, value: Any) -> Any:
        gui, label, hint = self.gui, field.name, field.meaning
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

    def fill_charts(self, x: np.ndarray, x_name: str, charts: Sequence[tuple[str, str, np.ndarray, str]]) -> None:
        """Title, unit, values and colour of each; none: none."""
        for chart in self._charts:
            chart.remove()
        self._charts = []
        self.charts.visible = bool(charts)
        if len(x) < 2:
            self.charts.visible = False
            return
        with self.charts:
            for title, unit, values, color in charts:
                plot = self.gui.add_uplot(
                    (x.astype(float), np.nan_to_num(values)),
                    ({"label": x_name}, {"label": f"{title} [{unit}]", "stroke": color, "width": 1.5}),
                    title=f"{title} [{unit}]",
                    height=CHART_HEIGHT,
                    scales={"x": {"time": False}},
                    legend={"show": False},
                    axes=({"size": 26}, {"size": 44}),
                )
                self._charts.append(plot)

    def set_choices(self, handle: viser.GuiDropdownHandle[str], choices: Sequence[str], value: str) -> None:
        if tuple(handle.options) != tuple(choices):
            handle.options = tuple(choices)
        if handle.value != value:
            handle.value = value

    def show_sizes(self, kind: str) -> None:
        """The sizes that a shape has."""
        names = SHAPES.get(kind, ())
        for k, handle in enumerate(self.sizes):
            handle.visible = k < len(names)
            if k < len(names):
                handle.label = names[k]
        self.scale.visible = kind not in SHAPES
