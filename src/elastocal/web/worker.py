"""Runs at work: each is the command in a process of its own, followed by a thread."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from typing import IO

from elastocal.errors import InputError
from elastocal.web.command import command_line
from elastocal.web.runs import Record, Run

PATIENCE = 3.0
"""Seconds that a process has to end by itself, before it is killed."""

KEPT = 300
"""Steps of a fit whose misfit is shown."""


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes:
        step, misfit: the last step of the fit and its sum of squares.
        done, total: parts of all that is to be done, generations or fits of a bootstrap; 0 of 0 where there are none.
        trace: sums of squares of the steps so far.
    """

    step: int = 0
    misfit: float = 0.0
    done: int = 0
    total: int = 0
    trace: tuple[float, ...] = ()


class _Job:
    """One process, its progress, and the thread that writes down what it says."""

    def __init__(self, run: Run, given: Sequence[str]) -> None:
        self.run = run
        self.progress = Progress()
        self.stopped = False
        self.closing = False
        now = datetime.now().isoformat(timespec="seconds")
        self.record = Record(started=now, command=command_line(given))
        run.save_record(self.record)
        self.log = (run.folder / "log.txt").open("w", encoding="utf-8")
        environment = {**os.environ, "ELASTOCAL_PROGRESS": "json", "COLUMNS": "100", "PYTHONIOENCODING": "utf-8"}
        with (run.folder / "output.txt").open("wb") as output:
            self.process = subprocess.Popen(
                # -P: the folder of the user's files is no place to import from
                [sys.executable, "-P", "-m", "elastocal", *given],
                cwd=run.inputs,
                stdin=subprocess.DEVNULL,
                stdout=output,
                # a pipe: should this process die, the command's next line ends it too
                stderr=subprocess.PIPE,
                env=environment,
                start_new_session=True,
            )
        self.thread = threading.Thread(target=self._follow, name=f"run {run.id}", daemon=True)
        self.thread.start()

    def _follow(self) -> None:
        """Read what the process says to its end, then write down how it ended."""
        assert self.process.stderr is not None  # it is a pipe
        with self.log, self.process.stderr as said:
            self._read(said)
        status = self.process.wait()
        whole = self.run.drop_half_result()
        if not self.closing:
            ended = datetime.now().isoformat(timespec="seconds")
            stopped = self.stopped and not whole  # else it was done before it could be stopped
            with suppress(InputError, OSError):  # the folder is gone
                self.run.save_record(replace(self.record, ended=ended, status=status, stopped=stopped))

    def _read(self, said: IO[bytes]) -> None:
        for line in said:
            text = line.decode(errors="replace")
            if not text.startswith('{"progress"'):
                self.log.write(text)
                self.log.flush()
                continue
            with suppress(ValueError, TypeError, KeyError):
                told = json.loads(text)["progress"]
                self.progress = replace(self.progress, **told)
                if "misfit" in told:
                    self.progress = replace(self.progress, trace=(*self.progress.trace, told["misfit"])[-KEPT:])

    def end(self) -> None:
        """End the process and those that it has started."""
        self._signal(signal.SIGTERM)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._signal(getattr(signal, "SIGKILL", signal.SIGTERM))
        self.thread.join(PATIENCE)

    def _signal(self, number: signal.Signals) -> None:
        with suppress(ProcessLookupError, PermissionError):  # it has ended by itself
            if hasattr(os, "killpg"):
                os.killpg(self.process.pid, number)
            else:
                self.process.terminate()


class Workers:
    """The runs at work."""

    def __init__(self) -> None:
        self._jobs: dict[str, _Job] = {}
        self._lock = threading.Lock()

    def start(self, run: Run, given: Sequence[str]) -> bool:
        """Start a run, unless it is at work.

        Args:
            run: whose inputs are the command's working folder.
            given: the command's arguments.

        Returns:
            Whether it was started.
        """
        with self._lock:
            if self.at_work(run):
                return False
            self._jobs[run.id] = _Job(run, given)
            return True

    def at_work(self, run: Run) -> bool:
        """Whether a run's process is at work, or its end not yet written down."""
        job = self._jobs.get(run.id)
        return job is not None and job.thread.is_alive()

    def progress(self, run: Run) -> Progress:
        """How far a run is."""
        job = self._jobs.get(run.id)
        return job.progress if job else Progress()

    def stop(self, run: Run) -> None:
        """End a run; nothing that it would have written is left half."""
        job = self._jobs.get(run.id)
        if job is not None and self.at_work(run):
            job.stopped = True
            job.end()

    def close(self) -> None:
        """End all runs, which leaves them interrupted."""
        for job in self._jobs.values():
            if job.thread.is_alive():
                job.closing = True
                job.end()
