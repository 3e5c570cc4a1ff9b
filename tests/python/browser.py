"""Headless Chromium, driven over its DevTools protocol: opens a page, keeps what it logged and asked for, takes pictures."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import children
import numpy as np
import pytest
from PIL import Image
from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = [
    "--headless=new",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-sync",
    "--hide-scrollbars",
    "--mute-audio",
    "--remote-debugging-port=0",
    "--window-size=840,600",
    "about:blank",
]


def find() -> str | None:
    return next((path for name in NAMES if (path := shutil.which(name))), None)


needed = pytest.mark.skipif(find() is None, reason="no Chromium: `make setup` installs it")  # of tests


class PageLeft(Exception):
    """A question to a page that goes to another one just then."""


class Browser:
    """A context manager; open(file) loads a page, screenshot() shows it as an RGB array."""

    def __enter__(self) -> Browser:
        executable = find()
        assert executable is not None, f"none of {', '.join(NAMES)} found; `make setup` installs chromium"
        self._profile = tempfile.mkdtemp(prefix="stiction-chromium-")
        environment = {**os.environ, "HOME": self._profile}
        words = [executable, f"--user-data-dir={self._profile}", *FLAGS]
        self._process = children.Child(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
        try:
            self._socket = connect(self._page_address(), max_size=None, open_timeout=30)
        except BaseException:
            self.__exit__()
            raise
        self._next_id = 0
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.received = 0  # bytes of the page and of its socket, as they came over the wire
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        return self

    def __exit__(self, *_) -> None:
        self._process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(10)
        self._process.kill_group()  # with its renderers
        shutil.rmtree(self._profile, ignore_errors=True)

    def _page_address(self) -> str:
        """Address of the first tab, once Chromium has written down the port that it chose."""
        from urllib.request import ProxyHandler, build_opener

        port_file = Path(self._profile) / "DevToolsActivePort"
        opener = build_opener(ProxyHandler({}))
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            assert self._process.poll() is None, "Chromium ended at once"
            if port_file.exists() and (lines := port_file.read_text().splitlines()):
                with opener.open(f"http://127.0.0.1:{lines[0]}/json/list", timeout=10) as reply:
                    pages = [t for t in json.load(reply) if t["type"] == "page"]
                if pages:
                    return pages[0]["webSocketDebuggerUrl"]
            time.sleep(0.05)
        raise TimeoutError("Chromium does not answer")

    def _note(self, message: dict) -> None:
        method, params = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description", ""))) for a in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Network.loadingFinished":
            self.received += int(params["encodedDataLength"])
        elif method == "Network.webSocketFrameReceived":
            text = params["response"]["payloadData"]  # of binary ones in base64
            self.received += len(text) if params["response"]["opcode"] == 1 else len(text) * 3 // 4

    def call(self, method: str, **params) -> dict:
        self._next_id += 1
        self._socket.send(json.dumps({"id": self._next_id, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv(timeout=120))
            if message.get("id") == self._next_id:
                if "navigated" in message.get("error", {}).get("message", ""):
                    raise PageLeft(method)
                assert "error" not in message, f"{method}: {message['error']}"
                return message["result"]
            self._note(message)

    def evaluate(self, expression: str):
        """None where the page is being left: its successor has to be asked."""
        try:
            return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")
        except PageLeft:
            return None

    def open(self, file: Path) -> None:
        self.visit(file.resolve().as_uri())

    def visit(self, address: str) -> None:
        self.call("Page.navigate", url=address)

    def choose_file(self, file: Path) -> None:
        """Gives a file to the page's field for files."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        field = self.call("DOM.querySelector", nodeId=root, selector="input[type=file]")["nodeId"]
        assert field, "the page has no field for files"
        self.call("DOM.setFileInputFiles", nodeId=field, files=[str(file)])

    def scrub(self, fraction: float) -> None:
        """Clicks on the time bar, which also stops the playback; in a panel on the first slider."""
        box = self.evaluate(
            "(() => { const r = document.querySelector('.mantine-Slider-track').getBoundingClientRect();"
            " return [r.left, r.top + r.height / 2, r.width]; })()"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=box[0] + fraction * box[2], y=box[1], button="left", clickCount=1)

    def screenshot(self) -> np.ndarray:
        data = self.call("Page.captureScreenshot", format="png")["data"]
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))

    def wait_for(self, condition, seconds: float, what: str):
        """Polls until condition() is neither None nor False and returns its value."""
        deadline = time.monotonic() + seconds

        def ask():
            try:
                return condition()
            except PageLeft:
                return None

        while (value := ask()) is None or value is False:
            assert time.monotonic() < deadline, f"waited {seconds} s for {what}"
            time.sleep(0.2)
        return value
