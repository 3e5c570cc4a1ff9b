"""A viser server that asks for the token of its address, and of which nothing is heard but faults of its own."""

from __future__ import annotations

import contextlib
import http.client
import io
import logging
import threading
from collections.abc import Callable, Iterator
from typing import Any

import viser
import viser._messages
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import InvalidHandshake
from websockets.http11 import Request, Response

from .access import LOOPBACK, WILDCARDS, Access, NotAllowed

Answer = Callable[[ServerConnection, Request], Response | None]
FORBIDDEN, SEE_OTHER = 403, 303
SELF_CHECK = 30.0  # [s] for an answer of the own server
_starting = threading.Lock()


class Unguarded(RuntimeError):
    """The server does not ask for its token: it was stopped at once."""


def _guarded(access: Access, answer: Answer | None) -> Answer:
    """Answers what `access` allows, as viser does."""

    def first(connection: ServerConnection, request: Request) -> Response | None:
        hosts = request.headers.get_all("Host")
        try:
            access.check(hosts, request.headers.get_all("Origin"), request.path)
        except NotAllowed as refused:
            return connection.respond(FORBIDDEN, str(refused).encode("ascii", "backslashreplace").decode() + "\n")
        opens_socket = request.headers.get("Upgrade", "").lower() == "websocket"
        target = None if opens_socket else access.forward(hosts[0], request.path)
        if target is not None:
            onward = connection.respond(SEE_OTHER, "")
            onward.headers["Location"] = target
            return onward
        response = answer(connection, request) if answer is not None else None
        if response is not None:
            response.headers["Referrer-Policy"] = "no-referrer"
        return response

    return first


@contextlib.contextmanager
def _asked_first(access: Access) -> Iterator[None]:
    """The server that viser starts in this block asks `access` before it answers.

    viser has no place for this. Up to 1.1.1 it starts its one server, for the page and for its WebSocket, with `websockets.asyncio.server.serve`, in a
    thread, while its constructor waits. For that time the function is another one here, which puts the question before viser's `process_request`.
    PageServer looks whether it is asked.
    """
    serve = websockets.asyncio.server.serve

    def ours(handler: Any, *place: Any, **options: Any) -> Any:
        if getattr(handler, "__module__", "").partition(".")[0] == "viser":
            options["process_request"] = _guarded(access, options.get("process_request"))
        return serve(handler, *place, **options)

    with _starting:
        websockets.asyncio.server.serve = ours  # type: ignore[assignment, misc]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve  # type: ignore[misc]


class PageServer(viser.ViserServer):
    """Serves the page to those that `access` allows. Where the port is taken, viser goes on to the next one. Raises Unguarded."""

    def __init__(self, host: str, port: int):
        self.access = Access(host)
        with _asked_first(self.access):
            super().__init__(host=host, port=port, label="stiction", verbose=False)
        for message in (viser._messages.ShareUrlRequest, viser._messages.ShareUrlDisconnect):  # a tunnel through a server of others
            self._websock_server.unregister_handler(message)
        try:
            self._check()
        except BaseException:
            self.stop()
            raise

    def urls(self) -> list[str]:
        """Where the page is, with the token; the first for a browser on this machine, where one can reach it there."""
        return self.access.urls(self.get_port())

    def _check(self) -> None:
        """Raises Unguarded: a version of viser starts its server otherwise."""
        socket_headers = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="}
        for headers in ({}, socket_headers):
            if (status := self._ask("/", headers)) != FORBIDDEN:
                raise Unguarded(f"viser {viser.__version__}: its server answers {status} to who has no token, expected {FORBIDDEN}; install viser 1.1.1")
        if (status := self._ask(f"/?token={self.access.token}", {})) != SEE_OTHER:
            raise Unguarded(f"viser {viser.__version__}: its server answers {status} to who has the token, expected {SEE_OTHER}; install viser 1.1.1")

    def _ask(self, path: str, headers: dict[str, str]) -> int:
        place = self.access.host
        if place in WILDCARDS:
            place = "::1" if place == "::" else LOOPBACK
        connection = http.client.HTTPConnection(place, self.get_port(), timeout=SELF_CHECK)
        try:
            connection.request("GET", path, headers=headers)
            return connection.getresponse().status
        finally:
            connection.close()


def _own_fault(record: logging.LogRecord) -> bool:
    """Whether more happened than that somebody hung up before a connection was open, as browsers do that connect ahead."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, (InvalidHandshake, ConnectionError, EOFError))


@contextlib.contextmanager
def quiet_server(host: str, port: int) -> Iterator[PageServer]:
    """A server that does not print, and logs faults alone. Where the port is taken, viser goes on to the next one."""
    logger = logging.getLogger("websockets.server")  # the one that is called: filters of its ancestors are not asked
    logger.setLevel(logging.ERROR)
    if _own_fault not in logger.filters:
        logger.addFilter(_own_fault)
    with contextlib.redirect_stdout(io.StringIO()):
        server = PageServer(host, port)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
