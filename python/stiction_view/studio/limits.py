"""Uploads are refused by their announced size, before they are held in memory."""

from __future__ import annotations

from collections.abc import Callable

import viser
from viser import _messages

from .uploads import Refused, check_name, check_size, check_total


def limit_uploads(server: viser.ViserServer, refused: Callable[[str], None]) -> None:
    """Replaces the server's reception of files: what is too large or has no name of ours is said to `refused` and dropped as it comes in."""
    gui = server.gui
    interface = gui._websock_interface
    take_start, take_part = gui._handle_file_transfer_start, gui._handle_file_transfer_part

    def start(client: int, message: _messages.FileTransferStartUpload) -> None:
        try:
            check_size(message.filename, message.size_bytes)
            check_name(message.filename)
            check_total(sum(s["total_bytes"] for s in gui._current_file_upload_states.values()) + message.size_bytes)
        except Refused as error:
            refused(str(error))
            done = _messages.FileTransferPartAck(message.source_component_uuid, message.transfer_uuid, message.size_bytes, message.size_bytes)
            interface.queue_message(done)  # ends the page's own notice
            return
        take_start(client, message)

    def part(client: int, message: _messages.FileTransferPart) -> None:
        state = gui._current_file_upload_states.get(message.transfer_uuid)
        if state is None:
            return
        if state["transferred_bytes"] + len(message.content) > state["total_bytes"]:
            gui._current_file_upload_states.pop(message.transfer_uuid, None)
            refused(f"{state['filename']}: got more than the {state['total_bytes']} bytes that were announced")
            return
        take_part(client, message)

    interface.unregister_handler(_messages.FileTransferStartUpload, take_start)
    interface.unregister_handler(_messages.FileTransferPart, take_part)
    interface.register_handler(_messages.FileTransferStartUpload, start)
    interface.register_handler(_messages.FileTransferPart, part)
