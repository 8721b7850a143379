"""What commands show: sections on standard output, progress on standard error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console

from elastocal.report import Section, print_sections


class _Terminal(Console):
    """A console that leaves a broken pipe to the command, whose exit status it is."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def show(sections: Sequence[Section]) -> None:
    """Print sections on standard output."""
    print_sections(sections, _Terminal(highlight=False))


@contextmanager
def progress(title: str) -> Iterator[Callable[[int, float], None] | None]:
    """A spinner on standard error while a fit runs, if that is a terminal; yields what to call after each step."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    with console.status(title) as status:
        yield lambda step, misfit: status.update(f"{title}: step {step}, sum of squares {misfit:.6g}")
