"""Functions for workers, which must be importable there."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path


def square(x: int) -> int:
    """The square, after a while that is shorter for later ones."""
    time.sleep(0.002 * (x % 3 == 0))
    return x * x


@dataclass(frozen=True)
class Marking:
    """The square; each run leaves a mark in a folder, so that runs can be counted, and some end their process.

    Attributes:
        folder: of the marks.
        once: items that kill the process that first works on them.
        always: items that kill each process.
    """

    folder: Path
    once: tuple[int, ...] = ()
    always: tuple[int, ...] = ()

    def __call__(self, x: int) -> int:
        """Leave a mark and answer, or end."""
        before = len(list(self.folder.glob(f"{x}-*")))
        (self.folder / f"{x}-{before}").touch()
        if x in self.always or (x in self.once and not before):
            os.kill(os.getpid(), signal.SIGKILL)
        return x * x


def fail(x: int) -> int:
    """An error of the function's own."""
    if x == 3:
        raise ValueError("three")
    return x


def slow(x: float) -> float:
    """The number, after so many seconds."""
    time.sleep(x)
    return x
