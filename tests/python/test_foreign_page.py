"""Pages of other sites, names that were bound to this machine, and visitors without the token get nothing of a page that is served."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import socket
from collections.abc import Iterator
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import viser
import viser._messages
import websockets
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from stiction_view import quiet
from stiction_view.access import Access, NotAllowed
from stiction_view.quiet import PageServer, Unguarded, quiet_server

LIMIT = 30  # [s] for an answer
PROTOCOL = [f"viser-v{viser.__version__}"]


@pytest.fixture(scope="module")
def server() -> Iterator[PageServer]:
    with quiet_server("127.0.0.1", 0) as server:
        server.scene.add_point_cloud("/secret", np.zeros((9, 3)), np.zeros((9, 3)))
        yield server


def ask(server: PageServer, path: str, host: str | None = None, origin: str | None = None) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body of the answer to a request for a page."""
    port = server.get_port()
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=LIMIT)) as connection:
        connection.request("GET", path, headers={"Host": host or f"localhost:{port}"} | ({"Origin": origin} if origin is not None else {}))
        answer = connection.getresponse()
        return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()


def open_socket(server: PageServer, path: str, host: str | None = None, origin: str | None = None) -> ClientConnection:
    """Raises InvalidStatus: it is refused."""
    port = server.get_port()
    sock = socket.create_connection(("127.0.0.1", port), timeout=LIMIT)
    return connect(f"ws://{host or f'localhost:{port}'}{path}", sock=sock, origin=origin, subprotocols=PROTOCOL, open_timeout=LIMIT, max_size=None, compression=None)  # type: ignore[arg-type]


def status_of_socket(server: PageServer, *words: str | None) -> int:
    """101: it is open, and the scene comes through it."""
    try:
        with open_socket(server, *words) as connection:
            assert len(connection.recv(timeout=LIMIT)) > 0
            return 101
    except InvalidStatus as refused:
        assert b"secret" not in refused.response.body
        return refused.response.status_code


# Host, Origin and query of a visitor; {port}: of the server, {token}: its token.
OWN = [
    ("localhost:{port}", "http://localhost:{port}", "?token={token}"),
    ("127.0.0.1:{port}", "http://127.0.0.1:{port}", "?token={token}"),
    ("127.0.0.1:{port}", "http://localhost:{port}", "?token={token}"),
    ("LocalHost:{port}", "http://localhost:{port}", "?token={token}"),
    ("localhost:9000", "http://localhost:9000", "?token={token}"),  # another port of this machine that is forwarded
    ("localhost:{port}", None, "?darkMode&token={token}"),
]
FOREIGN = [
    ("localhost:{port}", "http://another.example", "?token={token}"),
    ("localhost:{port}", "http://another.example", ""),
    ("localhost:{port}", "http://localhost:9000", "?token={token}"),  # another program on this machine
    ("localhost:{port}", "https://localhost:{port}", "?token={token}"),
    ("localhost:{port}", "http://localhost:{port}.another.example", "?token={token}"),
    ("localhost:{port}", "null", "?token={token}"),
    ("localhost:{port}", "", "?token={token}"),
    ("another.example", None, "?token={token}"),  # DNS rebinding
    ("another.example:{port}", "http://another.example:{port}", "?token={token}"),
    ("localhost.another.example:{port}", None, "?token={token}"),
    ("10.1.2.3:{port}", "http://10.1.2.3:{port}", "?token={token}"),
    ("another@localhost:{port}", None, "?token={token}"),
    ("localhost:{port}", "http://localhost:{port}", ""),
    ("localhost:{port}", None, "?token="),
    ("localhost:{port}", None, "?token=0123456789abcdef0123456789abcdef"),
    ("localhost:{port}", None, "?token={token}0"),
    ("localhost:{port}", None, "?token={token}&token=x"),
    ("localhost:{port}", None, "?websocket=ws://localhost:{port}/"),
]


def filled(server: PageServer, visitor: tuple[str, str | None, str]) -> tuple[str, str | None, str]:
    return tuple(word and word.format(port=server.get_port(), token=server.access.token) for word in visitor)  # type: ignore[return-value]


@pytest.mark.parametrize("visitor", OWN)
def test_own_page_is_served_and_its_socket_opens(server: PageServer, visitor: tuple[str, str | None, str]) -> None:
    host, origin, query = filled(server, visitor)
    status, headers, _ = ask(server, f"/{query}", host, origin)
    assert status == 303, "to the page that opens its socket with the token"
    target = parse_qs(urlsplit(headers["location"]).query)["websocket"][0]
    assert target == f"ws://{host}/?token={server.access.token}"
    status, headers, body = ask(server, headers["location"], host, origin)
    assert status == 200 and b"<title>Viser</title>" in body and headers["referrer-policy"] == "no-referrer"
    assert status_of_socket(server, target.removeprefix(f"ws://{host}"), host, origin) == 101


@pytest.mark.parametrize("visitor", FOREIGN)
def test_foreign_page_gets_nothing(server: PageServer, visitor: tuple[str, str | None, str]) -> None:
    host, origin, query = filled(server, visitor)
    came: list[int] = []
    server.on_client_connect(lambda client: came.append(client.client_id))
    for path in (f"/{query}", f"/index.html{query}"):
        status, headers, body = ask(server, path, host, origin)
        assert status == 403 and headers["content-type"].startswith("text/plain") and len(body) < 500
        assert b"expected" in body and server.access.token.encode() not in body
    if "@" not in host:  # which a client takes for a password
        assert status_of_socket(server, f"/{query}", host, origin) == 403
    assert came == []


def raw(server: PageServer, text: str) -> bytes:
    """What comes back for bytes that no client would send."""
    with socket.create_connection(("127.0.0.1", server.get_port()), timeout=LIMIT) as visitor:
        visitor.sendall(text.format(port=server.get_port(), token=server.access.token).replace("\n", "\r\n").encode())
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while part := visitor.recv(65536):
                answer += part
        return answer


@pytest.mark.parametrize(
    "text",
    [
        "GET /?token={token} HTTP/1.1\n\n",
        "GET /?token={token} HTTP/1.1\nHost: localhost:{port}\nHost: another.example\n\n",
        "GET /?token={token} HTTP/1.1\nHost: another.example\nHost: localhost:{port}\n\n",
        "GET /?token={token} HTTP/1.1\nHost: localhost:{port}\nOrigin: http://localhost:{port}\nOrigin: http://another.example\n\n",
        "GET http://localhost:{port}/?token={token} HTTP/1.1\nHost: another.example\n\n",
        "GET /?token=\u00e4 HTTP/1.1\nHost: localhost:{port}\n\n",
        "GET /?token={token} HTTP/1.1\nHost: \u00e4\n\n",
        "GET //[?token=x HTTP/1.1\nHost: localhost:{port}\n\n",
    ],
)
def test_requests_that_no_browser_sends_are_refused(server: PageServer, text: str) -> None:
    assert raw(server, text).startswith(b"HTTP/1.1 403 ")


def test_nothing_is_taken_by_post(server: PageServer) -> None:
    answer = raw(server, "POST /?token={token} HTTP/1.1\nHost: localhost:{port}\nContent-Length: 3\n\nabc")
    assert not answer.startswith((b"HTTP/1.1 2", b"HTTP/1.1 3"))


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_beyond_the_loopback_address_the_token_is_asked_for_as_well(host: str) -> None:
    if host == "::" and not socket.has_dualstack_ipv6():
        pytest.skip("this machine has no addresses of version 6")
    with quiet_server(host, 0) as server:
        port, token = server.get_port(), server.access.token
        first, second = server.urls()
        assert first == f"http://localhost:{port}/?token={token}" and second == f"http://{socket.gethostname().lower()}:{port}/?token={token}"
        if host == "::":
            return  # what is below speaks version 4
        for name in ("localhost", socket.gethostname(), "192.168.1.7", "[fd00::1]"):
            assert ask(server, f"/?token={token}", f"{name}:{port}")[0] == 303
            assert ask(server, "/", f"{name}:{port}")[0] == 403
            assert status_of_socket(server, "/", f"{name}:{port}", f"http://{name}:{port}") == 403
        assert ask(server, f"/?token={token}", f"another.example:{port}")[0] == 403
        assert ask(server, f"/?token={token}", f"192.168.1.7:{port}", f"http://10.1.2.3:{port}")[0] == 403, "a page that another machine serves at the same port"


def test_each_run_has_its_own_token() -> None:
    tokens = {Access("127.0.0.1").token for _ in range(100)}
    assert len(tokens) == 100 and all(len(token) == 32 for token in tokens)
    assert tokens.isdisjoint(repr(Access("127.0.0.1")).split("'")), "it does not get into messages"


def test_message_of_what_is_refused_says_what_to_do() -> None:
    access = Access("127.0.0.1", token="abc")
    for hosts, origins, path, message in (
        (["another.example"], [], "/?token=abc", r"Host: got 'another.example', expected 127.0.0.1, \[::1\], localhost; open the address that the program has printed"),
        (["localhost:80"], ["http://b"], "/?token=abc", "Origin: got 'http://b', expected 'http://localhost:80'; pages of other sites have no access"),
        (["localhost:80"], [], "/", "token: got none, expected that of this run; open the address that the program has printed"),
        (["localhost:80"], [], "/?token=x", "token: got another one, expected"),
    ):
        with pytest.raises(NotAllowed, match=message):
            access.check(hosts, origins, path)
    access.check(["localhost:80"], ["http://localhost:80"], "/?token=abc")


def test_server_that_does_not_ask_for_the_token_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a version of viser would be that starts its server in another way."""
    started: list[PageServer] = []
    check = PageServer._check
    monkeypatch.setattr(PageServer, "_check", lambda self: started.append(self) or check(self))
    monkeypatch.setattr(quiet, "_asked_first", lambda _: contextlib.nullcontext())
    with pytest.raises(Unguarded, match=rf"viser {viser.__version__}: its server answers 200 to who has no token, expected 403; install viser"), quiet_server("127.0.0.1", 0):
        pass
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", started[0].get_port()), timeout=LIMIT).close()


def test_servers_of_others_in_this_process_are_left_alone(server: PageServer) -> None:
    async def served() -> int:
        async def handler(connection: websockets.asyncio.server.ServerConnection) -> None:
            await connection.send("hello")

        async with websockets.asyncio.server.serve(handler, "127.0.0.1", 0) as other:
            port = other.sockets[0].getsockname()[1]
            async with websockets.connect(f"ws://127.0.0.1:{port}/", origin="http://another.example", open_timeout=LIMIT) as connection:  # type: ignore[arg-type]
                return len(await asyncio.wait_for(connection.recv(), LIMIT))

    with quiet._asked_first(server.access):
        assert asyncio.run(served()) == 5


def test_no_page_can_ask_for_a_tunnel_to_the_world(server: PageServer) -> None:
    heard = server._websock_server._incoming_handlers
    assert heard, "the page is heard"
    assert {viser._messages.ShareUrlRequest, viser._messages.ShareUrlDisconnect}.isdisjoint(heard)
