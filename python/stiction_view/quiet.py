"""A viser server of which nothing is heard but faults of its own."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterator

import viser
from websockets.exceptions import InvalidHandshake


def _own_fault(record: logging.LogRecord) -> bool:
    """Whether more happened than that somebody hung up before a connection was open, as browsers do that connect ahead."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, (InvalidHandshake, ConnectionError, EOFError))


@contextlib.contextmanager
def quiet_server(host: str, port: int) -> Iterator[viser.ViserServer]:
    """A server that does not print, and logs faults alone. Where the port is taken, viser goes on to the next one."""
    logger = logging.getLogger("websockets.server")  # the one that is called: filters of its ancestors are not asked
    logger.setLevel(logging.ERROR)
    if _own_fault not in logger.filters:
        logger.addFilter(_own_fault)
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label="stiction", verbose=False)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
