"""What a report consists of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from elastocal.figures.panel import Panel

Kind = Literal["good", "caution", "problem"]


@dataclass(frozen=True)
class Verdict:
    """What a section comes to: how it is to be taken, and a sentence."""

    kind: Kind
    text: str


@dataclass(frozen=True)
class Section:
    """A part of a report: a table with sentences, and on a page figures.

    Attributes:
        title: above it.
        header: of the table.
        rows: of text; the first column is left-aligned, the rest right.
        sentences: below the table.
        prose: what is to be seen here; pages only.
        verdict: what it comes to.
        facts: names and figures that come first; pages only.
        panels: figures; pages only.
        code: a command line; pages only.
        sortable: whether a page lets the reader sort the table.
        page_only: whether a terminal leaves it out, as too wide for it.
    """

    title: str
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    sentences: tuple[str, ...] = ()
    prose: str = ""
    verdict: Verdict | None = None
    facts: tuple[tuple[str, str], ...] = ()
    panels: tuple[Panel, ...] = ()
    code: str = ""
    sortable: bool = False
    page_only: bool = False
