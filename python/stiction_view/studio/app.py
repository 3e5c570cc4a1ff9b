"""The studio: its parts, and which control is answered by which of them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import stiction as st
import viser

from ..program import check_interrupted
from . import catalog, scenario
from .control_live import ControlLive
from .desk import Desk
from .downloads import Downloads
from .jobs import Job
from .limits import limit_uploads
from .options import Options
from .own_files import OwnFiles
from .panel import POSE, SEEN, Panel, Handlers
from .picture import Pictures
from .planning import Planning
from .posing import Posing
from .problem import Problem
from .running import Running
from .sense_live import Live
from .showing import Showing
from .stage import Stage
from .work import Work

TICK = 1 / 60  # [s] how often the page is looked at


class Studio:
    """`entries` can be picked; `folder` is temporary and holds uploads. Only the thread that calls step() touches the parts."""

    def __init__(self, server: viser.ViserServer, entries: Sequence[catalog.Entry], first: catalog.Entry | None, folder: Path):
        self.entries, self.opened, self.folder = list(entries), "", folder
        self.desk = Desk(lambda text: self.panel.head.say(text, fault=True))
        self.handlers = Handlers(self.desk.post)
        self.stage = Stage(server)
        self.panel = panel = Panel(server.gui, self.handlers, [e.label for e in entries])
        self.work = Work(self.desk, panel.head, panel.search)
        self.posing = Posing(panel.pose, self.stage, self.desk.post, self._pose_changed)
        self.options = Options(panel.options, self._say_command)
        self.showing = Showing(panel.playback, panel.figures, self.stage, self._say_command)
        self.planning = Planning(server, panel.head, panel.search, self.stage, self.work, self.posing, self.showing)
        self.running = Running(panel.head, panel.run, self.stage, self.work, self.posing, self.showing)
        self.downloads = Downloads(server, panel.head, panel.export, panel.search, self.stage, self.work, self.posing, self.showing)
        self.own_files = OwnFiles(panel.head, panel.own, folder, self.take)
        self._connect()
        limit_uploads(server, lambda text: self.desk.post(lambda: panel.head.say(text, fault=True)))
        if first is not None:
            panel.head.pick.value = first.label
            self.desk.guarded(lambda: self.open(first))

    def _connect(self) -> None:
        """Every control by its name in the panel."""
        self.handlers.add(pick=self.pick, view=self.choose_view, seen=self.choose_seen, undo=self.posing.undo, seed=self.read_seed, reset=self.reset)
        self.handlers.add(handle=self.posing.choose_handle, goal=self.posing.read_goal, start=self.posing.read_start, joints=self.posing.read_joints)
        self.handlers.add(any_turn=self.posing.read_any_turn, keyframe=self.posing.choose_keyframe, goal_of=self.choose_goal_object)
        self.handlers.add(options=self.options.read, options_reset=self.options.reset)
        self.handlers.add(plan=self.planning.plan, simulate=self.planning.simulate, check=self.planning.check, cancel=self.work.cancel, run=self.running.run)
        self.handlers.add(live=self.live)
        self.handlers.add(which=self.showing.choose, beside=self.showing.choose_beside, save=self.downloads.save, report=self.downloads.report)
        self.handlers.add(upload=self.own_files.upload, kind=self.own_files.choose_kind, make=self.own_files.make)

    # ---- the loop ----

    def run(self) -> None:
        """Until interrupted."""
        try:
            while True:
                check_interrupted()
                self.step(TICK)
        finally:
            self.work.end()

    def step(self, wait_s: float) -> None:
        """Does what was asked for, and what is due."""
        self.desk.do_all(wait_s)
        self.desk.guarded(self._tick)

    def _tick(self) -> None:
        now = time.monotonic()
        self.stage.cameras.welcome()
        self.work.tick(now)
        self.posing.tick(now)
        self.planning.tick()
        self.running.tick()
        if self.stage.guest is not None:
            self.stage.guest.tick(now)
        self.showing.tick(now)

    # ---- between the parts ----

    def _pose_changed(self) -> None:
        self.showing.rest()
        self._say_command()

    def _say_command(self) -> None:
        self.downloads.say_command()

    def choose_view(self, name: str) -> None:
        """Raises ValueError: there is nothing to see."""
        if name != POSE:
            return self.showing.show()
        if self.posing.problem is None:
            raise ValueError("pose: no task is open; open one")
        self.posing.show()

    def choose_seen(self) -> None:
        self.stage.show_as(self.panel.head.seen.value == SEEN)

    def read_seed(self) -> None:
        if self.planning.read_seed():
            self._say_command()

    def live(self) -> None:
        """The scenario that is played, as it happens. Raises ValueError: none is."""
        scenario = self.showing.played.scenario if self.showing.played is not None else None
        if scenario is None:
            raise ValueError("live: no scenario of sensing or control is shown; open one")
        self.stage.clear()
        make = ControlLive if isinstance(scenario, st.ControlScenario) else Live
        self.stage.invite(make(self.stage.server, scenario, root="/live", order=self.panel.playback.folder.order - 0.5))

    def reset(self) -> None:
        """Start, goal and options as the task has them."""
        self.posing.reset()
        self.options.open(self.posing.problem)

    # ---- opening ----

    def pick(self) -> None:
        label = self.panel.head.pick.value
        if label != self.opened:
            self.open(next(e for e in self.entries if e.label == label))

    def open(self, entry: catalog.Entry) -> None:
        self.opened = entry.label
        self.panel.head.say("")
        self.work.drop()
        if entry.kind == catalog.TASK:
            return self.take(Problem.open(entry.source))
        if entry.kind == catalog.SCENE:
            return self.take(Problem.of_scene(Path(entry.source), self.folder))
        play = scenario.play_sense if entry.kind == catalog.SENSE else scenario.play_control
        self.work.when_free(lambda: self.work.start(Job(f"{entry.kind} of {entry.label}", lambda _: play(entry.source), self._played)))

    def choose_goal_object(self) -> None:
        """Another object is to be moved. Raises stiction.InvalidInput."""
        problem, name = self.posing.problem, self.panel.pose.goal_of.value
        if problem is not None and name in problem.model.object_names and name != problem.model.object_names[problem.goal_object]:
            self.take(problem.with_goal_of(problem.model.object_names.index(name)))

    def take(self, problem: Problem) -> None:
        """A task to pose and to plan."""
        self.work.drop()
        pictures = Pictures(problem.model)
        self.panel.head.describe(problem.about, [*problem.notes, *pictures.looks().notes])
        self.panel.head.seen.visible = bool(pictures.looks())
        self.posing.open(problem, pictures)
        self.options.open(problem)
        self.planning.open()
        self.running.open()
        self.showing.close_scenario()
        self.showing.list_results()
        self.posing.show(aim=True)

    def _played(self, job: Job) -> None:
        """A scenario was carried out."""
        self.posing.close()
        self.options.open(None)
        self.showing.show_scenario(job.result)
        self.panel.head.describe(job.result.words, job.result.pictures.looks().notes)
        self.panel.head.seen.visible = bool(job.result.pictures.looks())
