"""python -m stiction_view.studio.sense_live SCENARIO [--host ADDRESS] [--port N]; `stiction sense SCENARIO --live` starts it.

The moments of a scenario one after the other, at the speed at which they were measured: each is sensed when its time has come. A click on the robot pushes
it there, and what its torques then say is shown. Where the scenario looks for several contacts at the same time, so does the page, and further clicks push as well.
"""

from __future__ import annotations

import argparse
import queue
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import stiction as st
import viser

from .. import bodies as drawn
from .. import surfaces
from ..bodies import Color, body_meshes
from ..camera import choose_view
from ..drawing import Drawing, light, look
from ..program import add_address, announce, check_interrupted, end_on_signals, run_until_interrupted
from ..sense import EXPLAINS, MAX_OTHERS, OTHER, TRUTH
from .panel import TOUCHES
from .picture import Pictures
from .scenario import VERDICTS
from .server import serving
from .texts import plain

REST = 1.0  # [s] between the last moment and the first again
POKE = 1.5  # [s] for which a push by a click stays
LOW, HIGH = np.array([206.0, 24.0, 74.0]), np.array([232.0, 234.0, 238.0])  # colours of a residual of 0 and of all the torques
Force = tuple[np.ndarray, np.ndarray]  # point and force in the world
Contact = tuple[str, np.ndarray, np.ndarray]  # link, point and force in its frame
ARROWS: tuple[tuple[str, Color], ...] = (("explains", EXPLAINS), ("other", OTHER), ("truth", TRUTH))


@dataclass(frozen=True)
class Push:
    """A force along the inward normal at a sample of a link."""

    link: str
    p_L: np.ndarray
    n_L: np.ndarray
    newton: float


def find_sample(origin: np.ndarray, direction: np.ndarray, samples: list[tuple[str, np.ndarray, np.ndarray, float]]) -> tuple[int, int] | None:
    """Link and sample that a ray means: among samples that face it and lie within their spacing of it, the first on its way. Points and normals in the world."""
    best: tuple[float, int, int] | None = None
    for k, (_, points, normals, spacing) in enumerate(samples):
        along = (points - origin) @ direction
        off = np.linalg.norm(points - origin - along[:, None] * direction, axis=1)
        met = np.flatnonzero((off <= spacing) & (normals @ direction < 0) & (along > 0))
        for i in met:
            if best is None or along[i] < best[0]:
                best = (float(along[i]), k, int(i))
    return best[1:] if best is not None else None


class Live:
    """One scenario on one server; only the thread that calls tick() touches it. `root` is where it is drawn: below another page's nodes it can be removed. `order` is that of its controls."""

    def __init__(self, server: viser.ViserServer, scenario: st.SensingScenario, seed: int = 0, root: str = "", order: float | None = None):
        self.server, self.scenario, self.root = server, scenario, root
        self.sensor, self.model = scenario.sensor, scenario.sensor.model
        self.events: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.rng = np.random.default_rng(seed)
        self.last: st.SenseResult | None = None
        self.last_sets: st.ContactSets | None = None
        self.moment, self.shown = -1, -1
        self.begun: float | None = None
        self.pushes: list[Push] = []
        self.push_until = 0.0
        self.several = scenario.max_contacts > 1 or scenario.base_wrench is not None

        self.pictures = Pictures(self.model)
        plan = self.pictures.plan(self.configuration(0), st.Pose(np.eye(3), np.zeros(3)), 0, scenario.name)
        self.drawing = Drawing(server, plan, root=root, rods=self.pictures.rods(), with_goal=False, looks=self.pictures.looks())
        self.drawing.label.visible = False
        self.view = choose_view(plan, body_meshes(plan, {}), self.drawing.frames)
        if not root:
            light(server.scene, shadows=False)
            look(server.initial_camera, self.view)
        self.clouds = {link.name: self._add_cloud(link) for link in self.sensor.links}
        self.arrows = {name: self._add_arrows(name, color) for name, color in ARROWS}
        self.folder = server.gui.add_folder("Live", order=order)
        with self.folder:
            self._add_controls()
        self._clicked = server.scene.on_click()(lambda event: self.events.put(lambda: self.poke(np.array(event.ray_origin), np.array(event.ray_direction))))

    def remove(self) -> None:
        """From the page of another: its nodes, its controls, and the clicks."""
        self.server.scene.remove_click_callback(self._clicked)
        self.folder.remove()
        if self.drawing.root_node is not None:
            self.drawing.root_node.remove()  # and all below it

    # ---- nodes ----

    def _add_cloud(self, link: st.SensedLink) -> viser.PointCloudHandle:
        patches = self.pictures.looks().patches.get(link.name, [])
        under = [surfaces.find_ways_out(link.p_L, link.n_L, (patch.vertices, patch.triangles), link.spacing) for patch in patches]
        above = 0.1 * link.spacing + np.max(under or [np.zeros(len(link.p_L))], axis=0)  # what touches and what is seen there
        lifted = link.p_L + above[:, None] * link.n_L
        return self.server.scene.add_point_cloud(
            f"{self.root}/residual/{drawn.slug(link.name)}", lifted.astype(np.float32), np.tile(HIGH.astype(np.uint8), (len(lifted), 1)), point_size=0.7 * link.spacing, point_shape="circle", precision="float32"
        )

    def _add_arrows(self, name: str, color: Color) -> viser.ArrowHandle:
        length = self.drawing.force_longest
        return self.server.scene.add_arrows(
            f"{self.root}/arrows/{name}", np.zeros((1, 2, 3)), color, shaft_radius=0.04 * length, head_radius=0.1 * length, head_length=0.25 * length, visible=False
        )

    def _add_controls(self) -> None:
        gui = self.server.gui
        if not self.root:
            gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=(38, 96, 180))
        gui.add_markdown(f"**{plain(self.scenario.name)}**  \n{plain(self.scenario.description)}")
        self.play = gui.add_checkbox("play", True)
        self.force = gui.add_number("click pushes with [N]", 15.0, min=1.0, max=200.0, step=1.0)
        if not self.root and self.pictures.looks():
            self.touching = gui.add_checkbox(TOUCHES, False, hint="The shapes that are sensed, in place of what is seen")
            self.touching.on_update(lambda _: self.events.put(lambda: self.drawing.show_as(seen=not self.touching.value)))
        self.words = gui.add_markdown("")

    # ---- moments ----

    def configuration(self, moment: int) -> np.ndarray:
        q = self.model.neutral()
        q[self.model.n_qu :] = self.scenario.q[moment]
        return q

    def due(self, now: float) -> int:
        """The moment whose time has come; after the last one, and a rest, the first again."""
        times = np.array(self.scenario.times)
        if self.begun is None or now - self.begun > times[-1] - times[0] + REST:
            self.begun = now
            self.last = self.last_sets = None
        return int(np.searchsorted(times - times[0], now - self.begun, side="right")) - 1

    def tick(self, now: float) -> None:
        """Whatever was clicked, then the moment that is due. A push stays for a while, and the series waits for it."""
        while not self.events.empty():
            self.events.get()()
        if self.pushes:
            if now < self.push_until:
                return
            self.pushes, self.begun, self.shown = [], None, -1
        if not self.play.value:
            if self.begun is not None and self.moment >= 0:  # goes on from here
                self.begun = now - (self.scenario.times[self.moment] - self.scenario.times[0])
            return
        self.moment = self.due(now)
        if self.moment != self.shown:
            self.shown = self.moment
            base = self.scenario.base_wrenches
            title = f"t = {self.scenario.times[self.moment]:.2f} s"
            self.sense(self.scenario.q[self.moment], self.scenario.tau[self.moment], base[self.moment] if base else None, self.truths(self.moment), title)

    def truths(self, moment: int) -> list[Contact]:
        """Known contacts that act."""
        pushed = self.scenario.pushed
        contacts = self.scenario.contacts if not pushed else [self.scenario.contacts[k] for k in pushed[moment]]
        return [(c.link, np.array(c.p_L), np.array(c.f_L)) for c in contacts]

    def poke(self, origin: np.ndarray, direction: np.ndarray) -> None:
        """Pushes where a click meets the robot, in the posture that is shown."""
        moment = max(self.moment, 0)
        X = self.model.body_poses(self.configuration(moment))
        samples = [(link.name, link.p_L @ X[link.name].R.T + X[link.name].p, link.n_L @ X[link.name].R.T, link.spacing) for link in self.sensor.links]
        met = find_sample(origin, direction / np.linalg.norm(direction), samples)
        if met is None:
            return
        link = self.sensor.links[met[0]]
        if len(self.pushes) == self.scenario.max_contacts:
            self.pushes = []
        self.pushes.append(Push(link.name, link.p_L[met[1]], link.n_L[met[1]], float(self.force.value)))
        self.push_until = time.monotonic() + POKE
        q = self.scenario.q[moment]
        contacts = [(push.link, push.p_L, -push.newton * push.n_L) for push in self.pushes]
        external = sum((st.calc_contact_torque(self.model, q, *contact) for contact in contacts), self.draw_noise())
        tau = self.scenario.rest + self.scenario.sign * external  # as the robot would report it
        self.last = self.last_sets = None
        self.sense(q, tau, self.wrench(contacts, X), contacts, "pushed at " + " and ".join(push.link for push in self.pushes))

    def draw_noise(self) -> np.ndarray:
        noise, n = np.asarray(self.scenario.noise), self.model.n_a
        return self.rng.multivariate_normal(np.zeros(n), noise) if noise.ndim == 2 else noise * self.rng.normal(size=n)

    def wrench(self, contacts: list[Contact], X: dict[str, st.Pose]) -> st.BaseWrench | None:
        """What the sensor under the base would measure of contacts, if the robot stands on one."""
        sensor = self.scenario.base_wrench
        if sensor is None:
            return None
        parts = [st.calc_base_wrench(X[link].R @ p_L + X[link].p, X[link].R @ f_L) for link, p_L, f_L in contacts]
        force = sum((part.force_W for part in parts), sensor.force_noise * self.rng.normal(size=3))
        moment = sum((part.moment_W for part in parts), sensor.moment_noise * self.rng.normal(size=3))
        return st.BaseWrench(force, moment, force_noise=sensor.force_noise, moment_noise=sensor.moment_noise)

    # ---- what the torques say ----

    def sense(self, q: np.ndarray, tau: np.ndarray, base: st.BaseWrench | None, truths: list[Contact], title: str) -> None:
        begun = time.perf_counter()
        result = self.last = self.scenario.sense(q, tau, self.last)
        sets = self.last_sets = self.scenario.sense_contacts(q, tau, base, self.last_sets) if self.several else None
        seconds = time.perf_counter() - begun
        full = self.model.neutral()
        full[self.model.n_qu :] = q
        X = self.model.body_poses(full)
        self.drawing.place(self.pictures.poses(full)[0])
        self.colour(q, tau, result.friction, X)
        if sets is not None and sets.count > 1:
            explaining, others, rows = self.several_contacts(sets, X)
        else:
            explaining, others, rows = self.single_contacts(result)
        known = [(X[link].R @ p_L + X[link].p, X[link].R @ f_L) for link, p_L, f_L in truths]
        forces = [np.linalg.norm(f) for _, f in [*explaining, *known]]
        scale = self.drawing.force_longest / max(forces, default=1.0)
        for name, some in zip(self.arrows, (explaining, others, known), strict=True):
            self.draw_arrows(name, some, scale)
        rows[0] = f"**{plain(title)}**: {rows[0]}, {1e3 * seconds:.1f} ms"
        rows += [f"known: {plain(link)}, {np.linalg.norm(f_L):.1f} N" for link, _, f_L in truths]
        self.words.content = "  \n".join(rows)

    @staticmethod
    def single_contacts(result: st.SenseResult) -> tuple[list[Force], list[Force], list[str]]:
        """Candidates that explain, others, and what is said."""
        explaining = [c for c in result.candidates if c.explains]
        others = [c for c in result.candidates if not c.explains][:MAX_OTHERS]
        rows = [VERDICTS[result.verdict]]
        for number, c in enumerate(explaining, 1):
            extent = f", within {100 * c.extent:.1f} cm" if c.extent > 0 else ""
            rows.append(f"{number}. {plain(c.link)}: {np.linalg.norm(c.f_W):.1f} N, leaves {np.sqrt(max(c.residual, 0.0)):.2f} N·m{extent}")
        return [(np.array(c.p_W), np.array(c.f_W)) for c in explaining], [(np.array(c.p_W), np.array(c.f_W)) for c in others], rows

    @staticmethod
    def several_contacts(sets: st.ContactSets, X: dict[str, st.Pose]) -> tuple[list[Force], list[Force], list[str]]:
        """Contacts of the best set, those of the best sets on other links, and what is said."""
        forces = [[(X[c.link].R @ c.p_L + X[c.link].p, X[c.link].R @ c.f_L) for c in one.contacts] for one in sets.best]
        if sets.verdict != st.Verdict.Explained:
            return [], sum(forces, []), [f"{sets.count} contacts at the same time do not explain the torques"]
        rows = [f"{sets.count} contacts at the same time explain the torques" + (", not in one way alone" if sets.ambiguous else "")]
        for number, one in enumerate(sets.best, 1):
            rows += [f"{number}. {plain(c.link)}: {np.linalg.norm(c.f_L):.1f} N, ± {100 * c.deviation:.1f} cm" for c in one.contacts]
        return forces[0], sum(forces[1:], []), rows

    def colour(self, q: np.ndarray, tau: np.ndarray, friction: float, X: dict[str, st.Pose]) -> None:
        """Samples by the share of the torques that the best force there leaves over."""
        shares = self.scenario.calc_residual_shares(q, tau, friction)
        for link, share in zip(self.sensor.links, shares, strict=True):
            cloud = self.clouds[link.name]
            cloud.colors = (LOW + share[:, None] * (HIGH - LOW)).astype(np.uint8)
            cloud.position = X[link.name].p
            cloud.wxyz = viser.transforms.SO3.from_matrix(X[link.name].R).wxyz

    def draw_arrows(self, name: str, forces: list[tuple[np.ndarray, np.ndarray]], scale: float) -> None:
        """An arrow ends where the force acts and comes from the side that pushes."""
        arrows = self.arrows[name]
        if forces:
            longest = self.drawing.force_longest
            ends = []
            for point, force in forces:
                newton = np.linalg.norm(force)
                length = min(max(newton * scale, 0.2 * longest), longest)
                ends.append([point - force / newton * length, point] if newton > 0 else [point, point])
            arrows.points = np.array(ends, dtype=np.float32)
        if arrows.visible != bool(forces):
            arrows.visible = bool(forces)

    def run(self) -> None:
        """Until the process is interrupted."""
        while True:
            check_interrupted()
            self.tick(time.monotonic())
            time.sleep(0.005)


def main() -> int:
    parser = argparse.ArgumentParser(prog="stiction sense --live", description="Shows in the browser where a robot is touched, moment by moment.")
    parser.add_argument("scenario", help="scenario (name or file)")
    add_address(parser)
    args = parser.parse_args()
    end_on_signals()

    def show() -> None:
        scenario = st.load_sensing_scenario(args.scenario)
        for note in scenario.notes:
            print(f"note: {note}", file=sys.stderr)
        with serving(args.host, args.port) as server:
            live = Live(server, scenario)
            announce(server)
            live.run()

    return run_until_interrupted(show, st.InvalidInput)


if __name__ == "__main__":
    sys.exit(main())
