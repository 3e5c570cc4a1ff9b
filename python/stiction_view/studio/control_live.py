"""An arm with bounded contact forces as it moves, at the pace of the clock on the wall, and a hand that pulls at its links with the mouse."""

from __future__ import annotations

import threading
import time

import numpy as np
import stiction as st
import viser

from ..bodies import FORCE, body_meshes
from ..camera import choose_view
from ..drawing import Drawing
from .live import Hand, Pull
from .picture import Pictures
from .scenario import error_unit
from .stage import HAND
from .texts import plain

LONGEST_ARROW = 3.0  # times the bound


class ControlLive:
    """A guest on the stage. The loop runs in a thread of its own; only the thread that calls tick() touches the page."""

    def __init__(self, server: viser.ViserServer, scenario: st.ControlScenario, root: str, order: float | None = None, pace: float = 1.0):
        self.server, self.scenario, self.model, self.pace = server, scenario, scenario.model, pace
        self.loop = st.ControlLoop(scenario)
        self.hold = Hand(self.model, 2.0 * scenario.lambda_max, 0.1)
        self.message = ""
        self._lock, self._stop = threading.Lock(), threading.Event()
        self._sample = self.loop.tick()
        self.pictures = Pictures(self.model)
        plan = self.pictures.plan(np.array(self.loop.q), st.Pose(np.eye(3), np.zeros(3)), 0, scenario.name)
        self.drawing = drawing = Drawing(server, plan, root=root, rods=self.pictures.rods(), with_goal=False, looks=self.pictures.looks())
        drawing.label.visible = False
        self.view = choose_view(plan, body_meshes(plan, {}), drawing.frames)
        self.forces, self.hand = self._arrows(f"{root}/contacts", FORCE), self._arrows(f"{root}/hand", HAND)
        for body in plan.bodies:
            for mesh, _ in drawing.painted.get(body.name, []) if body.kind == "robot" and body.moving is not None else []:
                self._let_pull(mesh, body.name)
        self._add_controls(order)
        self._thread = threading.Thread(target=self._run, name="control", daemon=True)
        self._thread.start()

    # ---- the loop ----

    def _run(self) -> None:
        begun = time.monotonic() - self.loop.time / max(self.pace, 1e-9)
        try:
            while not self._stop.is_set():
                pull, force = self.hold.force(np.array(self.loop.q))
                if pull is not None:
                    self.loop.push(pull.body, force, pull.p_B)
                elif self.hold.let_go():
                    self.loop.push(self.hold.last, np.zeros(3), np.zeros(3))
                sample = self.loop.tick()
                with self._lock:
                    self._sample = sample
                if self.pace > 0:
                    ahead = begun + self.loop.time / self.pace - time.monotonic()
                    if ahead > 0:
                        time.sleep(ahead)
                    else:
                        begun -= ahead  # what it is behind by is not made up for
        except st.InvalidInput as error:  # the simulation stopped
            self.message = str(error)

    def sample(self) -> st.ControlSample:
        """The newest one."""
        with self._lock:
            return self._sample

    # ---- the page ----

    def _arrows(self, name: str, color: tuple[int, int, int]) -> viser.ArrowHandle:
        length = self.drawing.force_longest
        return self.server.scene.add_arrows(name, np.zeros((1, 2, 3)), color, shaft_radius=0.04 * length, head_radius=0.1 * length, head_length=0.25 * length, visible=False)

    def _let_pull(self, mesh: viser.MeshHandle, body: str) -> None:
        @mesh.on_drag("left")
        async def _(event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
            self.pull(body, np.array(event.start_position), np.array(event.end_position), event.phase)

    def pull(self, body: str, point_W: np.ndarray, hand_W: np.ndarray, phase: str) -> None:
        """The mouse drags a link. Any thread may call it."""
        q = self.model.neutral()
        q[self.model.n_qu :] = self.sample().q
        self.hold.drag(q, body, point_W, hand_W, phase)

    def _add_controls(self, order: float | None) -> None:
        gui = self.server.gui
        self.folder = gui.add_folder("Live", order=order)
        with self.folder:
            gui.add_markdown("Drag a link with the mouse to pull at it: the arm yields, and its contacts stay at their bound.")
            self.newton = gui.add_number("Pull at most [N]", self.hold.newton, min=0.1, hint="Reached when the mouse is 0.1 m away")
            self.words = gui.add_markdown("")

    def tick(self, now: float) -> None:
        """Shows where the arm is."""
        self.hold.newton = float(self.newton.value)
        sample = self.sample()
        q = self.model.neutral()
        q[self.model.n_qu :] = sample.q
        self.drawing.place(self.pictures.poses(q)[0])
        scale = self.drawing.force_longest / self.scenario.lambda_max
        contacts = [(np.array(f.p_WC), np.array(f.force_W), f.pair < 0) for f in sample.forces]
        for arrows, of_hand in ((self.forces, False), (self.hand, True)):
            some = [(p, f * min(scale, LONGEST_ARROW * self.drawing.force_longest / np.linalg.norm(f))) for p, f, by_hand in contacts if by_hand == of_hand]
            if some:
                arrows.points = np.array([[p - f, p] for p, f in some], dtype=np.float32)
            if arrows.visible != bool(some):
                arrows.visible = bool(some)
        error = f"{1e3 * sample.error:.1f} {error_unit(self.scenario)} behind"
        force = f"**{sample.largest_force:.1f} N** of {self.scenario.lambda_max:g}{', at its bound' if sample.bounded else ''}" if contacts else "nothing touches"
        self.words.content = f"t = {sample.time:.2f} s: {force}, {error}" + (f"  \n⚠ {plain(self.message)}" if self.message else "")

    def remove(self) -> None:
        """From the page, with its thread."""
        self._stop.set()
        self._thread.join(5.0)
        self.folder.remove()
        assert self.drawing.root_node is not None
        self.drawing.root_node.remove()  # and all below it
