"""Sections on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from elastocal.report.section import Section

STYLES = {"identified": "green", "insignificant": "yellow", "unobservable": "red", "dependent": "dim", "fixed": "dim"}


def print_sections(sections: Sequence[Section], console: Console) -> None:
    """Print sections one after the other, as wide as the terminal."""
    for section in sections:
        if section.page_only or not (section.rows or section.sentences or section.verdict):
            continue
        console.print(Text(section.title, style="bold"))
        if section.rows:
            console.print(_table(section))
        if section.verdict:
            console.print(Padding(Text(section.verdict.text), (0, 0, 0, 1)))
        for sentence in section.sentences:
            mark = "! " if section.title == "Warnings" else "- " if section.title == "Notes" else ""
            console.print(Padding(Text(mark + sentence), (0, 0, 0, 1)))
        console.print()


def _table(section: Section) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), collapse_padding=True)
    text = {"verdict", "unit"}
    for column, name in enumerate(section.header):
        left = column == 0 or name in text
        table.add_column(Text(name), justify="left" if left else "right", no_wrap=column > 0, overflow="fold")
    for row in section.rows:
        table.add_row(*(Text(cell, style=STYLES.get(cell, "")) for cell in row))
    return table
