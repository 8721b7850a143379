"""Ctrl-C in a long command: what is done is kept, and said."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

OnPart = Callable[[int, int], None]


class Stopped(KeyboardInterrupt):
    """Ctrl-C, with a sentence on what is kept."""


@dataclass
class Count:
    """How much is done, and of how much."""

    done: int = 0
    total: int = 0

    def also(self, then: OnPart | None) -> OnPart:
        """A function to be called with both, which calls another with them."""

        def on_part(done: int, total: int) -> None:
            self.done, self.total = done, total
            if then is not None:
                then(done, total)

        return on_part


@contextmanager
def told_when_stopped(what: str, folder: Path) -> Iterator[Count]:
    """Turn ctrl-C into one with a sentence.

    Raises:
        Stopped: ctrl-C.
    """
    count = Count()
    try:
        yield count
    except KeyboardInterrupt:
        done = f"{count.done} of {count.total} {what} are done" if count.total else "what was done is kept"
        raise Stopped(f"stopped: {done}; the same command goes on from there ({folder})") from None
