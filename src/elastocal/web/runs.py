"""Runs: folders with inputs, settings, log and result, whose state is what the files say."""

from __future__ import annotations

import json
import re
import secrets
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import Any

from elastocal.io import write_files
from elastocal.web.settings import Settings, settings_json, settings_of

_ID = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")

DOWNLOADS = ("robot.toml", "result.json", "residuals.csv", "report.html")
"""What can be had of a result."""


class State(StrEnum):
    """What a run is doing, or how it ended."""

    DRAFT = "draft"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    REFUSED = "refused"
    STOPPED = "stopped"
    INTERRUPTED = "interrupted"
    CRASHED = "crashed"


WORDS = {
    State.DRAFT: ("Draft", "Not run yet."),
    State.RUNNING: ("Running", "The calibration is at work."),
    State.DONE: ("Done", "The calibration converged."),
    State.FAILED: ("No verdict", "It ran, but it did not converge or the data do not tell all that was asked for."),
    State.REFUSED: ("Bad input", "Nothing was calculated: something in the files or the settings is wrong."),
    State.STOPPED: ("Stopped", "It was stopped before its end and left no result."),
    State.INTERRUPTED: (
        "Interrupted",
        "The page was closed down while it ran; it left no result.",
    ),
    State.CRASHED: ("Ended unexpectedly", "It ended without a result; the log says more."),
}
"""What a state is called, and a sentence on it."""

OF_STATUS = {0: State.DONE, 1: State.FAILED, 2: State.REFUSED}
"""State by the command's exit status; any other: crashed."""


@dataclass(frozen=True)
class Record:
    """When a run began and how it ended; times in ISO 8601.

    Attributes:
        status: the command's exit status; None while it runs.
        stopped: whether the user ended it.
        command: what ran.
    """

    started: str
    ended: str | None = None
    status: int | None = None
    stopped: bool = False
    command: str = ""


@dataclass(frozen=True)
class Run:
    """A run's folder."""

    folder: Path

    @property
    def id(self) -> str:
        """Its name in the folder of all runs, and in addresses."""
        return self.folder.name

    @property
    def inputs(self) -> Path:
        """Where the files are that the user gave."""
        return self.folder / "inputs"

    @property
    def result(self) -> Path:
        """Where the command writes its result."""
        return self.folder / "result"

    @property
    def created(self) -> datetime:
        """When it was made."""
        return datetime.strptime(self.id[:15], "%Y%m%d-%H%M%S")

    @property
    def settings(self) -> Settings:
        """What it is to do."""
        return settings_of(_json(self.folder / "settings.json"))

    @property
    def record(self) -> Record | None:
        """When it ran and how that ended; None before."""
        found = _json(self.folder / "record.json")
        return Record(**found) if found else None

    @property
    def summary(self) -> Mapping[str, Any] | None:
        """The result object; None without one."""
        return _json(self.result / "result.json") or None

    @property
    def log(self) -> str:
        """What the command said on standard error."""
        return _text(self.folder / "log.txt")

    def state(self, at_work: bool) -> State:
        """What it is doing.

        Args:
            at_work: whether its process runs.
        """
        record = self.record
        if at_work:
            return State.RUNNING
        if record is None:
            return State.DRAFT
        if record.stopped:
            return State.STOPPED
        if record.ended is None:
            return State.INTERRUPTED
        return OF_STATUS.get(record.status if record.status is not None else -1, State.CRASHED)

    def save_settings(self, settings: Settings) -> None:
        """Write what it is to do."""
        write_files(self.folder, {"settings.json": settings_json(settings)})

    def save_record(self, record: Record) -> None:
        """Write when it ran and how that ended."""
        write_files(self.folder, {"record.json": json.dumps(asdict(record), indent=1) + "\n"})

    def drop_half_result(self) -> bool:
        """Remove what an ended command left half; whether a result is there."""
        whole = all((self.result / name).is_file() for name in DOWNLOADS[:3])
        if not whole and self.result.exists():
            shutil.rmtree(self.result, ignore_errors=True)
        return whole

    def files(self) -> list[Path]:
        """The files that the user gave, by name."""
        return sorted(path for path in self.inputs.glob("*") if path.is_file() and not path.is_symlink())

    def downloads(self) -> list[str]:
        """Names of the result's files that are there."""
        return [name for name in DOWNLOADS if (self.result / name).is_file()]


@dataclass(frozen=True)
class Runs:
    """The folder of all runs, which the user names."""

    folder: Path

    def create(self, settings: Settings | None = None) -> Run:
        """A new run without files."""
        name = f"{datetime.now():%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"
        run = Run(self.folder / name)
        run.inputs.mkdir(parents=True)
        run.save_settings(settings or Settings())
        return run

    def copy(self, run: Run) -> Run:
        """A new run with the same files and settings."""
        made = self.create(run.settings)
        for path in run.files():
            shutil.copyfile(path, made.inputs / path.name)
        return made

    def get(self, name: str) -> Run | None:
        """The run of a name; None if there is none."""
        run = Run(self.folder / name)
        sound = _ID.fullmatch(name) and (run.folder / "settings.json").is_file() and not run.folder.is_symlink()
        return run if sound else None

    def all(self) -> list[Run]:
        """All runs, the latest first."""
        names = sorted((path.name for path in self.folder.glob("*-*-*")), reverse=True)
        return [run for run in map(self.get, names) if run]

    def delete(self, run: Run) -> None:
        """Remove a run with all its files."""
        shutil.rmtree(run.folder)


def _json(path: Path) -> dict[str, Any]:
    """A JSON object; empty where there is none that can be read."""
    try:
        found = json.loads(_text(path) or "{}")
    except json.JSONDecodeError:
        return {}
    return found if isinstance(found, dict) else {}


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
