"""What is wrong with a file, as the page lists it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong: where in its file ("row 3, column 'x'"), and what."""

    place: str
    what: str


def fault_of(text: str, folder: Path) -> Fault:
    """A fault as commands tell it, without the folder and with its place apart."""
    text = text.replace(f"{folder}/", "")
    head, mark, rest = text.partition(": ")
    if mark and (folder / head).exists():
        text = rest
        head, mark, rest = text.partition(": ")
    numbered = head.startswith(("row ", "line ", "column ", "columns.", "joint ", "link "))
    return Fault(head, rest) if mark and numbered and len(head) < 80 else Fault("", text)
