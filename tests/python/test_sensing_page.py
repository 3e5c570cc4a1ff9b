"""Pages of `stiction sense` and `stiction control`: drawn by a real browser, their forces those of the program, small and self-contained."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import children
import numpy as np
import pytest
import yaml

import browser
import pictured
from stiction_view import InvalidPlan, dress, looks
from stiction_view.canvas import blend, refine, shade
from stiction_view.control import load_control
from stiction_view.plan import rotation_matrices
from stiction_view.sense import load_sense

ROOT = Path(__file__).resolve().parents[2]
MAX_BYTES = 5_000_000


def make(program: Path, command: str, scenario: str | Path, file: Path) -> tuple[dict, dict]:
    """What the program prints with --json, and the data of its page."""
    done = children.run([program, command, str(scenario), "--html", file, "--json"], limit=300)
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out["page"] == str(file)
    text = file.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return out, json.loads(found.group(1))


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


@pytest.fixture(scope="module")
def sensed(program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict, dict]:
    file = tmp_path_factory.mktemp("sense") / "panda.html"
    return file, *make(program, "sense", "panda_wrist", file)


@pytest.fixture(scope="module")
def controlled(program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict, dict]:
    file = tmp_path_factory.mktemp("control") / "box.html"
    return file, *make(program, "control", "box_in_the_way", file)


# ---- what the pages hold ----


def test_forces_and_points_of_the_page_are_those_of_the_program(sensed: tuple[Path, dict, dict]) -> None:
    file, out, page = sensed
    assert file.stat().st_size < MAX_BYTES
    explaining = [c for c in out["moments"][0]["candidates"] if c["explains"]]
    arrows = page["arrows"][0]
    assert len(explaining) >= 1
    for candidate, arrow in zip(explaining, arrows):
        np.testing.assert_allclose(arrow["force"], candidate["f_W"], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(arrow["point"], candidate["p_W"], rtol=1e-12, atol=1e-12)
    truth = arrows[-1]
    assert truth["label"] == "the contact"
    # The scenario says 15 N; the nearest candidate is where the contact is, as the program says.
    assert np.linalg.norm(truth["force"]) == pytest.approx(15, rel=1e-6)
    nearest = min(np.linalg.norm(np.subtract(truth["point"], c["p_W"])) for c in explaining)
    assert nearest <= out["moments"][0]["distance"] + explaining[0]["extent"] + 1e-6


def test_credible_set_of_links_and_places_is_that_of_the_program(sensed: tuple[Path, dict, dict]) -> None:
    _, out, page = sensed
    posterior = out["moments"][0]["posterior"]
    rows = [(name, value) for name, value in page["frame_rows"][0] if name.startswith("95 %")]
    assert [name for name, _ in rows] == [f"95 %: {link.split('/')[-1]}" for link in posterior["credible"]]
    for (_, value), link in zip(rows, posterior["credible"]):
        assert float(value.removesuffix(" %")) == pytest.approx(100 * posterior["links"][link], abs=0.51)
    (field,) = (f for f in page["fields"] if f["name"] == "credible places")
    levels = [numbers(link, "<u2") / 65535 for link in field["values"][0]]
    assert [len(link) for link in levels] == [len(numbers(s["points"], "<f4")) // 3 for s in page["samples"]]
    assert min(link.min() for link in levels) == 0, "the likeliest place"
    held = [link.min() <= 0.95 for link in levels]
    names = [s["link"] for s in page["samples"]]
    assert any(held) and not all(held) and names == list(range(len(names)))
    # The known contact is in the credible set: the sample nearest to it on its link says so.
    truth = np.array(page["arrows"][0][-1]["point"])
    poses = numbers(page["poses"], "<f4").reshape(len(page["times"]), page["bodies"], 7)[0]
    distances = [np.linalg.norm(numbers(s["points"], "<f4").reshape(-1, 3) @ rotation_matrices(poses[None, s["body"], 3:])[0].T + poses[s["body"], :3] - truth, axis=1) for s in page["samples"]]
    nearest = int(np.argmin([d.min() for d in distances]))
    assert levels[nearest][distances[nearest].argmin()] <= 0.95


def test_contacts_at_the_same_time_are_drawn_together(program: Path, tmp_path: Path) -> None:
    out, page = make(program, "sense", "ur5_two_contacts", tmp_path / "two.html")
    arrows = {arrow["label"]: arrow for arrow in page["arrows"][0]}
    group = out["moments"][0]["contact_sets"]["groups"][0]
    for label, truth, contact in zip(("1a", "1b"), ("contact 1", "contact 2"), group["contacts"], strict=True):
        assert np.linalg.norm(arrows[label]["force"]) == pytest.approx(np.linalg.norm(contact["f_L"]), rel=1e-9)
        assert np.linalg.norm(np.subtract(arrows[label]["point"], arrows[truth]["point"])) < 0.01
        assert np.linalg.norm(np.subtract(arrows[label]["force"], arrows[truth]["force"])) < 0.1
    assert ["2 contacts", "isolated"] in page["frame_rows"][0]


def test_least_residual_of_the_page_lies_where_the_contact_is(sensed: tuple[Path, dict, dict]) -> None:
    _, out, page = sensed
    residual, eta, _ = page["fields"]
    samples = [numbers(link, "<u2") / 65535 for link in residual["values"][0]]
    assert all(len(link) == len(numbers(s["points"], "<f4")) // 3 for link, s in zip(samples, page["samples"]))
    least = {float(link.min()) for link in samples}
    assert min(least) < 0.1 < max(least), "some links explain the torques, others do not"
    assert len(eta["values"]) == 1 and "15 N" in eta["meaning"]
    assert all((numbers(link, "<u2") >= 0).all() for link in eta["values"][0])


def test_what_a_link_feels_follows_from_the_noise_of_the_joint_before_it(program: Path, tmp_path: Path) -> None:
    def etas(noise: object, **more: object) -> tuple[list[np.ndarray], str]:
        scenario = yaml.safe_load((ROOT / "scenarios/panda_wrist.yaml").read_text())
        scenario["sensing"] |= {"noise": noise, "probabilities": False, "links": ["arm/panda_link*", "arm/panda_leftfinger"]} | more
        (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario), encoding="utf-8")
        _, page = make(program, "sense", tmp_path / "scenario.yaml", tmp_path / "page.html")
        eta = page["fields"][1]
        return [numbers(link, "<u2") / 65535 for link in eta["values"][0]], eta["meaning"]

    (quiet, text), (loud, _) = etas(0.02), etas(0.2)
    assert "0.08 N·m" in text and all(b.mean() > a.mean() for a, b in zip(quiet, loud, strict=True))
    mixed, text = etas([0.02] * 5 + [0.2] * 3, unmeasured=["panda_finger_joint1"])
    assert "0.08 to 0.8 N·m" in text and len(mixed) == 8
    for k, (link, expected) in enumerate(zip(mixed, [*quiet[:5], *loud[5:7], np.ones_like(loud[7])], strict=True)):
        np.testing.assert_array_equal(link, expected, err_msg=f"link {k + 1}")


def test_series_has_a_frame_a_moment(program: Path, tmp_path: Path) -> None:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_forearm.yaml").read_text())
    del scenario["joints"], scenario["contact"]
    scenario["series"] = "series.csv"
    still = "0,-1.2,1.6,-1.97,-1.57,0"
    names = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))])
    lines = [names, *(f"{0.01 * k},{still},{3 * k},{4 * k},{-2 * k},0,0,0" for k in range(3))]
    (tmp_path / "series.csv").write_text("\n".join(lines))
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    out, page = make(program, "sense", tmp_path / "scenario.yaml", tmp_path / "series.html")
    assert page["times"] == [m["t"] for m in out["moments"]] and len(page["times"]) == 3
    # Twice the torques, twice the force at the same share left over; no torque, nothing explained.
    first, second = (np.concatenate([numbers(link, "<u2") for link in page["fields"][0]["values"][k]]) for k in (1, 2))
    np.testing.assert_allclose(first.astype(int), second.astype(int), atol=1)
    assert (numbers(page["fields"][0]["values"][0][0], "<u2") == 65535).all()


def test_control_page_has_every_tick_and_the_forces_of_the_run(controlled: tuple[Path, dict, dict]) -> None:
    file, out, page = controlled
    assert file.stat().st_size < MAX_BYTES
    ticks = round(out["duration_s"] / 0.005)
    assert len(numbers(page["plot_times"], "<f4")) == ticks
    forces = next(p for p in page["plots"] if p["title"] == "contact forces")
    bound = next(line for line in forces["lines"] if line["name"] == "λ_max")
    assert (numbers(bound["values"], "<f4") == out["lambda_max"]).all()
    largest = max(numbers(line["values"], "<f4").max() for line in forces["lines"] if line is not bound)
    assert largest == pytest.approx(out["peak_force"], rel=1e-5)
    # Arrows of a frame are the forces of its tick in the plot.
    times = numbers(page["plot_times"], "<f4")
    lines = np.array([numbers(line["values"], "<f4") for line in forces["lines"] if line is not bound])
    touched = 0
    for t, arrows in zip(page["times"], page["arrows"]):
        tick = int(np.argmin(np.abs(times - t)))
        drawn = sorted(float(np.linalg.norm(a["force"])) for a in arrows)
        np.testing.assert_allclose(drawn, sorted(float(v) for v in lines[:, tick] if v > 0), rtol=1e-5)
        touched += len(drawn) > 0
    assert touched > 10
    error = numbers(next(p for p in page["plots"] if p["title"] == "tracking error")["lines"][0]["values"], "<f4")
    assert error.max() >= 1e3 * out["rms_error_contact"]
    torques = next(p for p in page["plots"] if p["title"] == "motor torques")
    assert len(torques["lines"]) == 7 and torques["unit"] == "% of their limits"


# ---- in a browser ----


def opened(window: browser.Browser, file: Path) -> None:
    window.open(file)
    window.wait_for(lambda: window.evaluate("document.body !== null && document.body.dataset.drawn === '1'"), 90, "the drawing")


def yellow(picture: np.ndarray) -> float:
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 120) & (g > 120) & (b < 0.6 * g)).mean())


def scene(window: browser.Browser) -> np.ndarray:
    """The picture without the panels, whose scale has the colours of the surface."""
    window.evaluate("document.querySelectorAll('#stiction, #scale, .label').forEach((e) => { e.style.visibility = 'hidden'; })")
    return window.screenshot()


@browser.needed
def test_sense_page_switches_between_residual_and_detectability(sensed: tuple[Path, dict, dict]) -> None:
    with browser.Browser() as window:
        opened(window, sensed[0])
        assert window.evaluate("document.title") == "panda_wrist · stiction"
        residual = scene(window)
        assert (np.abs(residual.astype(int) - residual[-1, -1]).max(axis=2) > 20).mean() > 0.03, "more than the background"
        window.evaluate("document.querySelectorAll('[name=field]')[1].click()")
        assert "15 N" in window.evaluate("document.getElementById('meaning').textContent")
        eta = scene(window)
        assert yellow(eta) > yellow(residual) > 0, "most of the arm feels 15 N, few places explain these torques"
        window.evaluate("document.getElementById('dots').click()")
        assert np.abs(scene(window).astype(int) - eta).max() > 50, "samples are drawn"
        assert window.errors == [] and [u for u in window.requests if not u.startswith(("file:", "data:"))] == []


@browser.needed
def test_control_page_moves_with_its_slider_and_plots(controlled: tuple[Path, dict, dict]) -> None:
    with browser.Browser() as window:
        opened(window, controlled[0])
        start = scene(window)
        window.evaluate("s = document.getElementById('slider'); s.value = 290; s.dispatchEvent(new Event('input'))")
        later = scene(window)
        half = start.shape[0] // 2
        moved = np.abs(start[:half].astype(int) - later[:half]).max(axis=2) > 40
        assert moved.mean() > 0.002, "the arm is elsewhere and a force is drawn"
        time = controlled[2]["times"][290]
        assert window.evaluate("document.getElementById('clock').textContent") == f"{time:.2f} s"
        assert window.evaluate("document.querySelectorAll('#plots canvas').length") == 4
        window.evaluate("document.getElementById('play').click()")
        window.wait_for(lambda: int(window.evaluate("document.getElementById('slider').value")) > 291, 30, "the playback")
        assert window.errors == []


# ---- bodies as their files show them ----

SENSED = {"scene": {"robots": [{"name": "arm"}]}, "sensing": {"friction": 0.5, "noise": 0.05}, "joints": {"joint_2": 0.6, "joint_4": -1.4, "joint_6": 1.1}, "contact": {"link": "arm/link_6", "point": [0.06, 0, 0], "force": 20}}


@pytest.fixture(scope="module")
def pictured_sense(program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("pictured_sense")
    return folder / "page.html", make(program, "sense", pictured.write(SENSED, folder), folder / "page.html")[1]


@pytest.fixture(scope="module")
def pictured_control(program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("pictured_control")
    return folder / "page.html", make(program, "control", pictured.of("box_in_the_way", folder), folder / "page.html")[1]


def test_pages_have_links_as_they_are_seen_and_as_they_touch(pictured_sense: tuple[Path, dict], pictured_control: tuple[Path, dict]) -> None:
    for _, page in (pictured_sense, pictured_control):
        pictured.check(page)
        seen = [numbers(mesh["points"], "<f4").reshape(-1, 3) for mesh in page["meshes"] if mesh.get("as") == "seen"]
        np.testing.assert_allclose([seen[0].min(axis=0), seen[0].max(axis=0)], [[-0.072, -0.072, -0.002], [0.072, 0.072, 0.142]], atol=1e-6)
        half = pictured.WIDE * 0.067
        np.testing.assert_allclose([seen[1].min(axis=0), seen[1].max(axis=0)], [[-half, -0.05 - half, 0.175 - half], [half, -0.05 + half, 0.175 + half]], atol=1e-6)
    assert all(("link" in mesh) == (mesh["as"] == "touches") for mesh in pictured_sense[1]["meshes"]), "the field lies on what is sensed"


def test_arm_of_the_package_has_its_colours(sensed: tuple[Path, dict, dict]) -> None:
    colors = {tuple(mesh["color"]) for mesh in sensed[2]["meshes"] if mesh.get("as") == "seen"}
    assert len(colors) > 2, "white with black and grey parts"
    touching = {mesh["body"] for mesh in sensed[2]["meshes"] if mesh.get("as") == "touches"}
    assert touching == {mesh["body"] for mesh in sensed[2]["meshes"] if mesh.get("as") == "seen"}


def test_scene_that_is_gone_or_shows_nothing_has_no_looks(tmp_path: Path) -> None:
    assert dress.of_scene(None) == looks.NOTHING == dress.of_scene(str(tmp_path / "gone.yaml"))
    assert not dress.of_scene(str(ROOT / "scenarios" / "box_in_the_way.yaml"))


def test_page_without_pictures_draws_what_touches_alone(controlled: tuple[Path, dict, dict]) -> None:
    assert not any("as" in mesh for mesh in controlled[2]["meshes"])


@browser.needed
def test_marks_lie_over_bodies_as_they_are_seen_and_a_button_shows_what_touches(pictured_sense: tuple[Path, dict], pictured_control: tuple[Path, dict]) -> None:
    label = "document.querySelector('#stiction button').textContent"
    with browser.Browser() as window:
        opened(window, pictured_sense[0])
        assert window.evaluate(label) == "Show what touches"
        boxes = scene(window)
        assert pictured.red(boxes) > 0.01, "the boxes"
        assert yellow(boxes) > 1e-4, "places that explain the torques, which are inside the boxes"
        window.evaluate("document.querySelectorAll('[name=field]')[2].click()")
        boxes = scene(window)
        assert yellow(boxes) == 0 and (boxes[..., 2] > np.maximum(60, 1.3 * boxes[..., 0])).mean() > 1e-5, "the credible set, far smaller, in blue up to its edge"
        window.evaluate("document.getElementById('dots').click()")
        assert np.abs(scene(window).astype(int) - boxes).max() > 50, "samples as well"
        window.evaluate("document.querySelector('#stiction button').click()")
        assert window.evaluate(label) == "Show what is seen"
        assert pictured.red(scene(window)) < 1e-3
        assert window.errors == []

        opened(window, pictured_control[0])
        middle = "const b = document.querySelector('#stiction button'), r = b.getBoundingClientRect()"
        assert window.evaluate(f"(() => {{ {middle}; return document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2) === b; }})()"), "beside plots in a low window, too"
        touched = max(range(len(pictured_control[1]["arrows"])), key=lambda k: len(pictured_control[1]["arrows"][k]))
        window.evaluate(f"s = document.getElementById('slider'); s.value = {touched}; s.dispatchEvent(new Event('input'))")
        boxes = scene(window)
        assert pictured.red(boxes) > 0.01 and pictured.arrows(boxes) > 1e-4, "the force at a contact inside a box"
        window.evaluate("document.querySelector('#stiction button').click()")
        balls = scene(window)
        assert pictured.red(balls) < 1e-3 and pictured.arrows(balls) > 1e-4
        window.evaluate("document.querySelector('#stiction button').click()")
        assert np.array_equal(scene(window), boxes), "and back"
        assert window.errors == []


@browser.needed
def test_page_without_pictures_has_no_button(controlled: tuple[Path, dict, dict]) -> None:
    with browser.Browser() as window:
        opened(window, controlled[0])
        assert window.evaluate("document.querySelector('#stiction button').hidden")


# ---- surfaces ----

CUBE = np.array([[[x, y, z] for x, y, z in t] for t in [
    [(0, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (1, 0, 0)], [(0, 0, 1), (1, 0, 1), (1, 1, 1)], [(0, 0, 1), (1, 1, 1), (0, 1, 1)],
]], dtype=float)  # fmt: skip


def area(corners: np.ndarray) -> float:
    return float(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2)


def test_refined_triangles_are_small_and_cover_the_same_surface() -> None:
    fine = refine(CUBE, 0.3)
    assert np.linalg.norm(fine - np.roll(fine, -1, axis=1), axis=2).max() <= 0.3
    assert area(fine) == pytest.approx(area(CUBE), rel=1e-12)
    normal = np.cross(fine[:, 1] - fine[:, 0], fine[:, 2] - fine[:, 0])[:, 2]
    assert ((normal > 0) == (fine[:, 0, 2] > 0.5)).all(), "they wind as before"


def test_shading_keeps_sharp_edges_and_colours_stay_on_their_side() -> None:
    vertices, normals, triangles = shade(CUBE)
    np.testing.assert_allclose(np.abs(normals[:, 2]), 1, atol=1e-12)
    assert triangles.shape == (4, 3) and len(vertices) == 8
    points = np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.02]])  # of a plate much thinner than the samples lie apart
    near, weight = blend(points, np.array([[0, 0, -1.0], [0, 0, 1.0]]), points, np.array([[0, 0, -1.0], [0, 0, 1.0]]), 0.5)
    assert near[np.arange(2), weight.argmax(axis=1)].tolist() == [0, 1]
    assert weight.max(axis=1).min() > 0.99 and weight.sum(axis=1) == pytest.approx([1, 1])


# ---- bad input ----


@pytest.mark.parametrize(
    ("load", "document", "message"),
    [
        (load_sense, {"format": "stiction-control"}, "format: got 'stiction-control', expected 'stiction-sense'"),
        (load_sense, {"format": "stiction-sense", "format_version": 2}, "format_version: got 2, expected 1"),
        (load_sense, {"format": "stiction-sense", "format_version": 1}, "field 'moments' is missing"),
        (load_sense, {"format": "stiction-sense", "format_version": 1, "moments": []}, "moments: none"),
        (load_control, {"format": "stiction-control", "format_version": 1, "ticks": [], "frames": []}, "frames: none"),
    ],
)
def test_bad_document_is_refused_by_file_and_field(tmp_path: Path, load, document: dict, message: str) -> None:
    file = tmp_path / "page.json"
    file.write_text(json.dumps(document))
    with pytest.raises(InvalidPlan) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}: ") and message in str(caught.value)


@pytest.mark.parametrize("scenario", [("sense", "panda_wrist"), ("control", "box_in_the_way")])
def test_page_that_cannot_be_written_is_said_before_the_work(program: Path, tmp_path: Path, scenario: tuple[str, str]) -> None:
    (tmp_path / "taken").write_text("a file, not a folder")
    for page, message in ((tmp_path / "taken" / "page.html", "taken"), (tmp_path, "expected a file to write")):
        done = children.run([program, *scenario, "--html", page], limit=60)
        assert done.returncode == 2 and message in done.stderr and not done.stdout
