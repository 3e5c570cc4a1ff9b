"""Who may see a page that is served: whoever knows the token of the printed address, and only from that address.

A server on this machine can be reached by every page that a browser on this machine shows. A page of another site names its own site in the header
`Origin`. A page whose name was bound to this machine by its DNS server names that site in `Host`. Both are refused. Any other program on this machine, or
on the network, has no token.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
import socket
from dataclasses import dataclass, field
from urllib.parse import parse_qs, quote

LOOPBACK = "127.0.0.1"
LOOPBACK_NAMES = frozenset({"localhost", LOOPBACK, "[::1]"})
WILDCARDS = ("", "0.0.0.0", "::")  # all addresses of the machine
HOST = re.compile(r"(?P<name>\[[0-9a-f:.]+\]|[a-z0-9._-]+)(?P<port>:[0-9]{1,5})?", re.ASCII)


class NotAllowed(Exception):
    """The message says what was given, what is expected, and what to do."""


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """None: it is a name."""
    try:
        return ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
    except ValueError:
        return None


def in_url(name: str) -> str:
    """A name or an address as it stands in a URL: addresses of version 6 have brackets."""
    return f"[{name}]" if ":" in name and not name.startswith("[") else name.lower()


def is_loopback(name: str) -> bool:
    address = _address(name)
    return name.lower() == "localhost" if address is None else address.is_loopback


def _query(path: str) -> dict[str, list[str]]:
    return parse_qs(path.partition("?")[2])


def _make_token() -> str:
    return secrets.token_hex(16)  # 128 bits


@dataclass(frozen=True)
class Access:
    """Decides on requests to a server that listens on `host`."""

    host: str
    token: str = field(default_factory=_make_token, repr=False)

    def names(self) -> frozenset[str]:
        """What the server is called. Beyond the loopback address it is called by every IP address as well: a page cannot bind one to another machine."""
        if is_loopback(self.host):
            return LOOPBACK_NAMES | {in_url(self.host)}
        machine = socket.gethostname().lower()
        return LOOPBACK_NAMES | {machine, machine.partition(".")[0], machine.partition(".")[0] + ".local"} | ({in_url(self.host)} if self.host not in WILDCARDS else set())

    def urls(self, port: int) -> list[str]:
        """Where the page is: the first for a browser on this machine, where one can reach it there."""
        if self.host in WILDCARDS:
            names = ["localhost", socket.gethostname().lower()]
        else:
            names = ["localhost" if self.host == LOOPBACK else in_url(self.host)]
        return [f"http://{name}:{port}/?token={self.token}" for name in names]

    # ---- requests ----

    def check(self, hosts: list[str], origins: list[str], path: str) -> None:
        """Raises NotAllowed. `hosts`, `origins`: all values of these headers."""
        host = self._own(hosts)
        if origins:  # browsers send one with each WebSocket
            self._same(origins, host)
        given = _query(path).get("token", [])
        if len(given) != 1 or not hmac.compare_digest(given[0].encode(errors="surrogateescape"), self.token.encode()):
            raise NotAllowed("token: got " + ("none" if not given else "another one") + ", expected that of this run; open the address that the program has printed")

    def _own(self, given: list[str]) -> re.Match[str]:
        match = HOST.fullmatch(given[0].lower()) if len(given) == 1 else None
        if match is None or not (match["name"] in self.names() or (not is_loopback(self.host) and _address(match["name"]) is not None)):
            expected = ", ".join(sorted(self.names())) + ("" if is_loopback(self.host) else " or an IP address")
            raise NotAllowed(f"Host: got '{', '.join(given)}', expected {expected}; open the address that the program has printed")
        return match

    def _same(self, given: list[str], host: re.Match[str]) -> None:
        scheme, _, rest = given[0].lower().partition("://")
        match = HOST.fullmatch(rest) if len(given) == 1 and scheme == "http" else None
        same = match is not None and (match["name"] == host["name"] or {match["name"], host["name"]} <= LOOPBACK_NAMES) and match["port"] == host["port"]
        if not same:
            raise NotAllowed(f"Origin: got '{', '.join(given)}', expected 'http://{host[0]}'; pages of other sites have no access")

    def forward(self, host: str, path: str) -> str | None:
        """Where the page is that opens its WebSocket with the token; None: it is that already. viser's page takes the address from its `websocket`."""
        page, _, query = path.partition("?")
        if page != "/" or "websocket" in _query(path):
            return None
        return f"/?{query}&websocket={quote(f'ws://{host}/?token={self.token}', safe='')}"
