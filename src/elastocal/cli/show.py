"""What commands show: sections on standard output, progress on standard error."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn

from elastocal.report import Section, print_sections


class _Terminal(Console):
    """A console that leaves a broken pipe to the command, whose exit status it is."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def show(sections: Sequence[Section]) -> None:
    """Print sections on standard output."""
    print_sections(sections, _Terminal(highlight=False))


class Calls(NamedTuple):
    """What to call on the way: after each step of a fit, and after each part of all that is to be done."""

    on_step: Callable[[int, float], None] | None = None
    on_part: Callable[[int, int], None] | None = None


PROGRESS = "ELASTOCAL_PROGRESS"
"""Set to "json" in the environment, progress goes to standard error as lines for another program, one object each."""

OFTEN = 0.05
"""Seconds between two such lines, at least."""


def _json_lines() -> Calls:
    told = [-OFTEN]

    def tell(last: bool = False, **values: float) -> None:
        now = time.monotonic()
        if last or now - told[0] >= OFTEN:
            told[0] = now
            print(json.dumps({"progress": values}), file=sys.stderr, flush=True)

    return Calls(
        lambda step, misfit: tell(step=step, misfit=misfit),
        lambda done, total: tell(done == total, done=done, total=total),
    )


@contextmanager
def progress(title: str) -> Iterator[Calls]:
    """Progress on standard error while a fit runs, if that is a terminal: steps told, parts as a bar."""
    if os.environ.get(PROGRESS) == "json":
        yield _json_lines()
        return
    console = Console(stderr=True)
    if not console.is_terminal:
        yield Calls()
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task(title, total=None)

        def on_step(step: int, misfit: float) -> None:
            shown.update(task, description=f"{title}: step {step}, sum of squares {misfit:.6g}", total=None)

        def on_part(done: int, total: int) -> None:
            shown.update(task, description=f"{title}: {done} of {total}", completed=done, total=total)

        yield Calls(on_step, on_part)
