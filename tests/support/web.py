"""The web page for tests: asked in this process, or served by a process of its own."""

from __future__ import annotations

import html
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from elastocal.web import create_app
from support.files import save_simulated

PORT = 8722
ORIGIN = f"http://127.0.0.1:{PORT}"


def client_of(folder: Path) -> TestClient:
    """A browser on the page of a folder, which follows no redirection."""
    return TestClient(create_app(folder), base_url=ORIGIN, headers={"origin": ORIGIN}, follow_redirects=False)


@dataclass(frozen=True)
class Page:
    """The page of one folder, asked in this process."""

    folder: Path
    client: TestClient

    def new(self, files: Mapping[str, str | bytes] | None = None) -> str:
        """A new run with files; its address."""
        made = self.client.post("/runs")
        assert made.status_code == 201
        for name, content in (files or {}).items():
            assert self.upload(made.text, name, content).status_code == 201
        return made.text

    def upload(self, run: str, name: str, content: str | bytes) -> object:
        """Give a run a file."""
        return self.client.put(f"{run}/files/{name}", content=content)

    def text(self, address: str) -> str:
        """A page."""
        got = self.client.get(address)
        assert got.status_code == 200, got.text
        return got.text

    def do(self, address: str, **form: str | list[str]) -> str:
        """Send a form that leads to another page; its address."""
        done = self.client.post(address, data=form)
        assert done.status_code == 303, done.text
        return done.headers["location"]

    def run_folder(self, run: str) -> Path:
        """Where a run is kept."""
        return self.folder / run.rpartition("/")[2]

    def finished(self, run: str, seconds: float = 120.0) -> str:
        """Wait for a run's end; its page then."""
        wait_for(lambda: "hx-refresh" in self.client.get(f"{run}/progress").headers, seconds)
        return self.text(run)


def wait_for(done: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait until something is so.

    Raises:
        TimeoutError: it is not in time.
    """
    end = time.monotonic() + seconds
    while not done():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.05)


def simulated_files(folder: Path, fit: int = 40) -> dict[str, bytes]:
    """A robot file, measurements and held-out ones of an arm with two soft joints."""
    folder.mkdir(exist_ok=True)
    save_simulated(folder, fit=fit)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


SETTINGS = {
    "groups": ["offsets", "lengths", "angles"],
    "transition": "exact",
    "population": "40",
    "generations": "50",
    "loss": "linear",
    "maps": "none",
    "orders": "60",
    "bootstrap": "0",
    "seed": "0",
}
"""A form as the page has it before anything is changed in it, without laws and hold-out."""


@dataclass(frozen=True)
class Served:
    """The page, served by a process of its own."""

    process: subprocess.Popen[bytes]
    origin: str
    folder: Path

    @classmethod
    def start(cls, folder: Path) -> Served:
        """Serve a folder at a free port."""
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        command = [sys.executable, "-m", "elastocal", "serve", str(folder), "--no-browser", "--port", str(port)]
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        served = cls(process, f"http://127.0.0.1:{port}", folder)
        wait_for(served._answers)
        return served

    def _answers(self) -> bool:
        assert self.process.poll() is None, "elastocal serve has ended"
        try:
            socket.create_connection(("127.0.0.1", int(self.origin.rpartition(":")[2])), timeout=1.0).close()
        except OSError:
            return False
        return True

    def stop(self) -> None:
        """End it as Ctrl-C does."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(60)

    def kill(self) -> None:
        """End it as a power cut does."""
        self.process.kill()
        self.process.wait(60)


def alive(pid: int) -> bool:
    """Whether there is a process, other than one that has ended and was not waited for."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    """The page of an empty folder."""
    with client_of(tmp_path / "runs") as client:
        yield Page(tmp_path / "runs", client)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a simulated robot, by name."""
    return simulated_files(tmp_path_factory.mktemp("files"))


def words(text: str) -> str:
    """A page's text without markup in one line."""
    return " ".join(html.unescape(text).split())
