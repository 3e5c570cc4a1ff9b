"""`stiction check --tube` and calc_tube(): the table, the JSON object, the verdict, bad input; the scores and factors of bench/tube.py."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
sys.path.insert(0, str(ROOT / "bench"))
st = pytest.importorskip("stiction", reason="build/release/python does not exist: run `make build`")
if not hasattr(st, "calc_tube"):
    pytest.skip("the module that is installed is not the one of this folder", allow_module_level=True)
import tube as bench  # noqa: E402

NO_ERRORS = ("--start-error", 0, "--start-turn", 0, "--friction-error", 0, "--mass-error", 0)


@pytest.fixture(scope="module")
def real_plan(stiction, real_plan: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The refined plan, whose regrasps pass the box at a distance: at 2 degrees its corners are 17 mm elsewhere."""
    folder = tmp_path_factory.mktemp("refined")
    done = stiction("refine", real_plan, "-o", folder)
    assert done.returncode == 0, done.stderr
    return folder / "plan.json"


@pytest.fixture(scope="module")
def tubes(stiction, real_plan: Path) -> dict[str, dict]:
    """Reports of the same plan, for the standard sets, for none, and for a start that nobody knows."""
    sets = {"standard": (), "none": NO_ERRORS, "unknown": ("--start-error", 0.2)}
    return {name: json.loads(stiction("check", real_plan, "--tube", "--json", *words).stdout) for name, words in sets.items()}


def test_json_has_a_bound_for_every_rest_and_says_what_it_is_made_of(tubes: dict[str, dict], real_plan: Path) -> None:
    tube = tubes["standard"]["tube"]
    assert tube["status"] == "Solved" and tube["calibrated"]
    assert {"position": 0.002, "friction": 0.3, "mass": 0.3}.items() <= tube["errors"].items()
    assert tube["factors"]["made_by"].startswith("bench/tube.py")
    kinds = [segment["kind"] for segment in json.loads(real_plan.read_text())["segments"]]
    assert [rest["last_segment"] for rest in tube["rests"]][-1] == len(kinds) - 1
    for rest in tube["rests"]:
        assert (rest["kind"] == "regrasp") == (kinds[rest["last_segment"]] == "regrasp")
        assert rest["position"] > 0 and rest["angle"] > 0 and rest["offset_position"] >= 0
    last = tube["rests"][-1]
    assert tube["goal"]["position"] >= last["position"] and tube["goal"]["angle"] >= last["angle"]


def test_verdict_is_that_of_the_bound_and_decides_the_exit_code(stiction, tubes: dict[str, dict], real_plan: Path) -> None:
    for report in tubes.values():
        tube = report["tube"]
        assert tube["inside"] == all(tube["goal"][key] <= tube["tolerance"][key] for key in ("position", "angle"))
        assert report["status"] == "Passed", "the plan itself is good"
    assert tubes["none"]["tube"]["inside"] and not tubes["unknown"]["tube"]["inside"]
    yes, no = stiction("check", real_plan, "--tube", *NO_ERRORS), stiction("check", real_plan, "--tube", "--start-error", 0.2)
    assert (yes.returncode, no.returncode) == (0, 1)
    assert "inside the goal's tolerance: yes" in yes.stdout and "inside the goal's tolerance: no" in no.stdout
    assert "tube" not in json.loads(stiction("check", real_plan, "--json").stdout)


def test_wider_sets_make_a_wider_tube(tubes: dict[str, dict]) -> None:
    width = [[rest["position"] for rest in tubes[name]["tube"]["rests"]] for name in ("none", "standard", "unknown")]
    assert width[0][0] < width[1][0] < width[2][0]
    assert max(width[1]) > 2 * max(width[0])


def test_module_computes_the_tube_of_the_program(tubes: dict[str, dict], real_plan: Path) -> None:
    plan = st.read_plan(real_plan)
    tube = st.calc_tube(plan, threads=2)
    assert [rest["position"] for rest in tubes["standard"]["tube"]["rests"]] == [rest.position for rest in tube.rests]
    assert len(tube.rests[0].scenarios) == 17 and tube.lost == 0
    farthest = max(float(np.linalg.norm(pose.p - tube.rests[-1].centre.p)) for pose in tube.rests[-1].scenarios)
    assert farthest < tube.rests[-1].position
    assert st.calc_tube(plan, timeout_s=1e-9).status == st.Status.MaxIterations


@pytest.mark.parametrize(
    "words, parts",
    [
        (("--start-error", "-1"), ("--start-error", "'-1'")),
        (("--start-turn", "nan"), ("--start-turn", "'nan'")),
        (("--friction-error", "1"), ("friction", "got 1", "[0, 1)")),
        (("--mass-error", "2"), ("mass", "got 2", "[0, 1)")),
        (("--worlds", "0"), ("--worlds",)),
    ],
)
def test_sets_that_are_none_are_refused(stiction, real_plan: Path, words: tuple[str, ...], parts: tuple[str, ...]) -> None:
    done = stiction("check", real_plan, "--tube", *words)
    assert done.returncode == 2
    assert all(part in done.stderr for part in parts), done.stderr


def test_sets_without_a_tube_are_refused(stiction, real_plan: Path) -> None:
    done = stiction("check", real_plan, "--start-error", 0.001)
    assert done.returncode == 2 and "--tube" in done.stderr


@pytest.mark.parametrize(
    "change, parts",
    [
        (lambda plan: plan["task"].update(file="planar_hand.yaml"), ("plan.json", "scene_sha256", "planar_hand")),
        (lambda plan: plan["goal"].update(object="nothing"), ("plan.json", "goal.object", "nothing")),
        (lambda plan: plan.update(segments=[]), ("plan.segments",)),
    ],
    ids=["of another task", "without its object", "without commands"],
)
def test_plans_that_have_no_tube_are_refused(stiction, real_plan: Path, tmp_path: Path, change: Callable[[dict], None], parts: tuple[str, ...]) -> None:
    plan = json.loads(real_plan.read_text())
    change(plan)
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    done = stiction("check", tmp_path, "--tube")
    assert done.returncode == 2
    assert all(part in done.stderr for part in parts), done.stderr


def test_module_names_bad_input(real_plan: Path) -> None:
    plan = st.read_plan(real_plan)
    for given, part in (({"position": -1.0}, "position"), ({"angle": math.nan}, "angle"), ({"friction": 1.0}, "friction"), ({"contact": -1.0}, "contact")):
        with pytest.raises(st.InvalidInput, match=part):
            st.ErrorSets(**given)
    with pytest.raises(st.InvalidInput, match="factors.angle"):
        st.calc_tube(plan, factors=(1.0, 0.0))
    with pytest.raises(st.InvalidInput, match="start_error"):
        st.transfer(plan, start_error=[0.0])
    with pytest.raises(st.InvalidInput, match="mass_scale"):
        st.transfer(plan, mass_scale=0.0)


# ---- the bench


def test_conformal_quantile_is_the_rank_of_one_more() -> None:
    assert bench.conformal_quantile(list(range(1, 20)), 0.95) == 19, "of 19 values the largest has 95 % below or at it"
    assert bench.conformal_quantile(list(range(1, 19)), 0.95) == math.inf, "18 are too few"
    assert bench.conformal_quantile(list(range(1, 100)), 0.95) == 95


def test_quaternions_and_angles_between_them() -> None:
    random = np.random.default_rng(0)
    for _ in range(20):
        axis, angle = random.standard_normal(3), random.uniform(0.01, math.pi - 0.01)
        axis /= np.linalg.norm(axis)
        K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        R = np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K
        q = np.array(bench.quaternion(R))
        assert abs(q @ np.append(axis * math.sin(angle / 2), math.cos(angle / 2))) == pytest.approx(1)
        assert bench.rotation_angle(np.array([0, 0, 0, 1.0]), -q) == pytest.approx(angle)


def test_score_is_by_what_a_radius_is_too_small(real_plan: Path) -> None:
    tube = st.calc_tube(st.read_plan(real_plan))
    poses = [[*rest.centre.p, *bench.quaternion(rest.centre.R)] for rest in tube.rests]
    assert bench.scores(tube.rests, {"poses": poses}) == pytest.approx((0, 0), abs=1e-6)
    poses[1][1] += 3 * tube.rests[1].position
    assert bench.scores(tube.rests, {"poses": poses})[0] == pytest.approx(3)
    assert bench.scores(tube.rests, {"poses": poses[:-1]}) == (math.inf, math.inf), "a run that ended before its plan"


def test_linear_tube_is_that_of_starts_that_are_a_little_off(real_plan: Path) -> None:
    """Up to the first rest: against exact steps from starts that are off by a micrometre along either axis."""
    plan = st.read_plan(real_plan)
    off, steps, model = 1e-6, len(plan[0].q), plan.task.model
    rests = bench.linear_tube(plan, st.ErrorSets(position=off, angle=0.0, friction=0.0, mass=0.0))
    assert len(rests) == len(st.calc_tube(plan).rests)
    starts = np.array([plan.q[0], *(plan.q[0] + off * np.eye(5)[i] for i in range(2))])
    ends = st.rollout_batch(model, starts, np.tile(plan.u[1 : steps + 1], (3, 1, 1)), h=plan.h, threads=1).q[:, -1, :2]
    assert rests[0].position == pytest.approx(np.linalg.norm(np.abs(ends[1:] - ends[0]).sum(axis=0)), rel=1e-2)
    assert rests[0].position != pytest.approx(math.sqrt(2) * off, rel=0.1), "the hand did not touch the box: the test would say little"
