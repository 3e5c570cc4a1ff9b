"""A drawing of a plan as a recorded page and as a live view."""

from __future__ import annotations

import base64
import html
import time
from collections.abc import Callable

import viser
from viser.infra import StateSerializer

from . import charts
from .bodies import Color
from .drawing import Drawing, light, look
from .looks import NOTHING, Looks
from .plan import Plan
from .program import announce, check_interrupted
from .quiet import quiet_server


# The player reads its recording once, so that another one needs the page anew; the name of a window outlives that.
SWITCH = """<script>
if (window.name === "stiction touches") window.__VISER_EMBED_DATA__ = "@DATA@";
addEventListener("DOMContentLoaded", () => {
  const button = document.querySelector("#stiction button"), touches = window.name === "stiction touches";
  button.textContent = touches ? "Show what is seen" : "Show what touches";
  button.onclick = () => { window.name = touches ? "" : "stiction touches"; location.reload(); };
});
</script>"""


def open_scene(server: viser.ViserServer, make_drawing: Callable[[viser.ViserServer], Drawing]) -> Drawing:
    """The drawing, lit and looked at by whoever comes."""
    light(server.scene)
    drawing = make_drawing(server)
    look(server.initial_camera, drawing.view.aside(0.2))  # the panel with the figures is on the left
    return drawing


def make_page(plan: Plan, looks: Looks = NOTHING) -> str:
    """One self-contained page: the recorded scene with a time bar."""
    return record(lambda server, looks: Drawing(server, plan, looks=looks, touches=not looks), looks)


def record(make_drawing: Callable[[viser.ViserServer, Looks], Drawing], looks: Looks = NOTHING) -> str:
    """The page of a drawing. Where files show something, it has two recordings, and a button that goes from one to the other."""
    recording, drawing = _record(lambda server: make_drawing(server, looks))
    page = _with_overlay(recording.as_html(), drawing)
    if not looks:
        return page
    touching, _ = _record(lambda server: make_drawing(server, NOTHING))
    script = SWITCH.replace("@DATA@", base64.b64encode(touching.serialize()).decode("ascii"))
    return page.replace("</head>", f"{script}</head>", 1)


def _record(make_drawing: Callable[[viser.ViserServer], Drawing]) -> tuple[StateSerializer, Drawing]:
    with quiet_server("127.0.0.1", 0) as server:
        drawing = open_scene(server, make_drawing)
        drawing.show(int(drawing.frames[0]))
        recording = server.get_scene_serializer()
        for index, knot in enumerate(drawing.frames):
            if index > 0:
                drawing.show(int(knot))
            recording.insert_sleep(float(drawing.times[index + 1] - drawing.times[index]))
    return recording, drawing


def _with_overlay(page: str, drawing: Drawing) -> str:
    """Adds a title, figures, charts and a key to viser's page, and colours its time bar by kind of segment."""
    task = html.escape(drawing.plan.task)
    rows = "".join(f"<tr><td>{html.escape(k)}</td><td>{html.escape(v)}</td></tr>" for k, v in [*drawing.summary(), *drawing.looks.rows()])

    def key(color: Color, text: str) -> str:
        return f'<span><i style="background:rgb{color}"></i>{text}</span>'

    keys = "".join(key(color, text) for color, text in drawing.keys())
    found = charts.charts(drawing.plan.loads, drawing.frames) if drawing.plan.loads else []
    chart_style, chart_panel = charts.as_html(found, drawing.times)
    style = f"""<style>
#stiction {{ position: fixed; bottom: 56px; left: 14px; z-index: 2; pointer-events: none; max-width: 440px; color: #23262d; padding: 8px 12px;
  background: rgba(255, 255, 255, 0.8); border-radius: 8px;
  font: 13px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }}
#stiction h1 {{ font-size: 19px; margin: 0 0 4px; font-weight: 650; }}
#stiction td {{ padding: 0 14px 0 0; vertical-align: top; }} #stiction td:first-child {{ color: #767c88; white-space: nowrap; }}
#stiction p {{ margin: 8px 0 0; display: flex; flex-wrap: wrap; gap: 0 14px; }}
#stiction i {{ display: inline-block; width: 10px; height: 10px; border-radius: 3px; margin-right: 5px; }}
#stiction button {{ pointer-events: auto; margin-top: 8px; font: inherit; padding: 2px 10px; border: 1px solid #b9bec8; border-radius: 6px; background: #fff; cursor: pointer; }}
.mantine-Slider-track::before {{ background: {drawing.timeline()} !important; }}
.mantine-Slider-bar {{ background: rgba(20, 22, 28, 0.42) !important; }}
</style>{chart_style}"""
    button = "<button></button>" if drawing.looks else ""
    panel = f'<div id="stiction"><h1>{task}</h1><table>{rows}</table>{chart_panel}<p>{keys}</p>{button}</div>'
    page = page.replace("<title>Viser</title>", f"<title>{task} · stiction</title>", 1)
    head, rest = page.split("</head>", 1)
    body, end = rest.rsplit("</body>", 1)
    return f"{head}{style}</head>{body}{panel}</body>{end}"


def serve(plan: Plan, port: int, looks: Looks = NOTHING) -> None:
    """Live view on localhost until interrupted."""
    with quiet_server("127.0.0.1", port) as server:
        drawing = open_scene(server, lambda s: Drawing(s, plan, looks=looks))
        last = len(drawing.frames) - 1
        server.gui.configure_theme(show_share_button=False)
        server.gui.add_markdown(
            f"## {plan.task}\n" + "\n".join(f"- {name}: {value}" for name, value in drawing.summary())
        )
        if looks:
            touching = server.gui.add_checkbox("what touches", False, hint="The shapes that the planner lets touch, in place of what is seen")
            touching.on_update(lambda _: drawing.show_as(seen=not touching.value))
        playing = server.gui.add_checkbox("play", True)
        speed = server.gui.add_slider("speed", 0.1, 4.0, 0.1, 1.0)
        slider = server.gui.add_slider("frame", 0, max(1, last), 1, 0)
        announce(server)
        drawing.show(int(drawing.frames[0]))
        shown = 0
        while True:
            check_interrupted()
            wait = 0.03
            if playing.value:
                following = 0 if shown >= last else shown + 1
                wait = float(drawing.times[shown + 1] - drawing.times[shown]) / speed.value
                slider.value = following  # type: ignore[misc]  # viser says that it is read-only
            index = min(int(slider.value), last)
            if index != shown:
                drawing.show(int(drawing.frames[index]))
                shown = index
            time.sleep(wait)
