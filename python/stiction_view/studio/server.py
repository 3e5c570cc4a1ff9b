"""One port of this machine for the studio."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterator

from ..program import PortTaken
from ..quiet import PageServer, quiet_server


def check_port(host: str, port: int) -> None:
    """Raises PortTaken: nobody can listen there."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except socket.gaierror:
        raise PortTaken(f"--host: got '{host}', expected an address of this machine") from None
    except OSError as error:
        what = "which is in use" if error.errno == 98 else f"which cannot be listened on ({error.strerror})"
        raise PortTaken(f"--port: got {port} of {host}, {what}; expected a free one, or 0 for any") from None


@contextlib.contextmanager
def serving(host: str, port: int) -> Iterator[PageServer]:
    """A quiet server. Raises PortTaken."""
    check_port(host, port)
    with quiet_server(host, port) as server:
        if port not in (0, server.get_port()):  # somebody was faster, and the server went on to the next one
            raise PortTaken(f"--port: got {port} of {host}, which is in use; expected a free one, or 0 for any")
        yield server
