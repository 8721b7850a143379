"""The page at work: its socket, its folder claimed, its server."""

from __future__ import annotations

import socket
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

import uvicorn

from elastocal.errors import InputError
from elastocal.web.app import create_app

HOST = "127.0.0.1"


@contextmanager
def listening(port: int) -> Iterator[socket.socket]:
    """A socket of this computer that nobody else's can reach.

    Raises:
        InputError: the port is taken.
    """
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((HOST, port))
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise InputError(f"--port {port}: {reason}: choose another, as --port {port + 1}") from None
        yield found
    finally:
        found.close()


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """A folder of runs for one server alone; the system gives it back, however this ends.

    Raises:
        InputError: another one has it, or it cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = (folder / ".lock").open("w")
    except OSError as error:
        raise InputError(f"{folder}: cannot be written to: {(error.strerror or str(error)).lower()}") from None
    with file:
        if not _locked(file):
            raise InputError(f"{folder}: another elastocal serve has this folder: choose another, or end that one")
        yield


def _locked(file: IO[str]) -> bool:
    """Whether a file could be locked, which lasts until it is closed."""
    try:
        import fcntl
    except ImportError:  # Windows
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def serve_folder(folder: Path, found: socket.socket, address: str | None = None) -> None:
    """Serve the page until it is ended.

    Args:
        folder: of the runs.
        found: the socket to listen at.
        address: to open in the browser; None: none.

    Raises:
        InputError: another server has the folder.
    """
    with claimed(folder):
        configuration = uvicorn.Config(
            create_app(folder), log_level="warning", access_log=False, timeout_graceful_shutdown=2, ws="none"
        )
        if address is not None:
            threading.Timer(0.5, webbrowser.open, [address]).start()
        with suppress(KeyboardInterrupt):  # Ctrl-C is how it ends
            uvicorn.Server(configuration).run(sockets=[found])
