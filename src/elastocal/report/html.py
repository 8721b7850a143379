"""Sections as a web page: one file that opens anywhere and asks nothing of any network."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from elastocal.errors import ElastocalError
from elastocal.figures.panel import Panel
from elastocal.figures.style import DARK, LIGHT, dark_colors
from elastocal.report.section import Section

if TYPE_CHECKING:
    from jinja2 import Environment

MARKS = {
    "good": ("✓", "Good"),
    "caution": ("!", "Caution"),
    "problem": ("✗", "Problem"),
}
"""Of verdicts: a sign and a word, so that colour is not needed to tell them."""

CELLS = {
    "identified": ("good", "✓"),
    "best": ("good", "✓"),
    "fitted": ("", ""),
    "insignificant": ("caution", "~"),
    "left out": ("caution", "!"),
    "dependent": ("muted", "="),
    "fixed": ("muted", "·"),
    "unobservable": ("problem", "✗"),
}
"""Of cells that are verdicts: class and sign."""

TEXT = {"unit", "verdict", "reason", "name", "value", "meaning", "with", "file", "observation", "status", "errors"}
"""Columns of words are left-aligned, as the first is."""


def page_html(title: str, sections: Sequence[Section], about: str = "") -> str:
    """A whole page: the sections with a table of contents, all scripts and styles within.

    Args:
        title: of the page.
        sections: in order.
        about: a line below the title.
    """
    return (
        _environment()
        .get_template("page.html")
        .render(
            title=title,
            about=about,
            version=version("elastocal"),
            sections=_views(sections),
            settings=_json(figure_settings()),
            plotly=plotly_script() if any(section.panels for section in sections) else "",
        )
    )


def sections_html(sections: Sequence[Section]) -> str:
    """The sections alone, for a page that has report.css, report.js, plotly and `figure_settings` itself."""
    return _environment().get_template("sections.html").render(sections=_views(sections))


def asset(name: str) -> str:
    """A file that the page is made of, as "report.css" or "report.js"."""
    return (Path(__file__).with_name("templates") / name).read_text(encoding="utf-8")


def figure_settings() -> dict[str, Any]:
    """What report.js needs beside the panels: the templates of light and dark pages, and how colours change."""
    return {"light": LIGHT, "dark": DARK, "colors": dark_colors()}


@cache
def plotly_script() -> str:
    """plotly.js as the Python package brings it, which is not imported for that: only figures of scripts need it.

    Raises:
        ElastocalError: the package does not bring it.
    """
    found = find_spec("plotly")
    path = Path(found.origin).parent / "package_data" / "plotly.min.js" if found and found.origin else None
    if path is None or not path.is_file():
        raise ElastocalError("plotly is not installed as it should be: python -m pip install --force-reinstall plotly")
    return path.read_text(encoding="utf-8").replace("</script", "<\\/script")


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    loader = FileSystemLoader(Path(__file__).with_name("templates"))
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.globals["marks"] = MARKS
    environment.globals["asset"] = asset
    return environment


def _views(sections: Sequence[Section]) -> list[dict[str, Any]]:
    """Sections as the template takes them: with anchors, columns' alignments and panels as JSON."""
    anchors: dict[str, int] = {}
    views = []
    for number, section in enumerate(sections):
        anchor = re.sub(r"[^a-z0-9]+", "-", section.title.lower()).strip("-") or "section"
        anchors[anchor] = anchors.get(anchor, 0) + 1
        anchor = anchor if anchors[anchor] == 1 else f"{anchor}-{anchors[anchor]}"
        panels = [
            {"panel": p, "json": _json(panel_json(p)), "id": f"figure-{number}-{i}"}
            for i, p in enumerate(section.panels)
        ]
        views.append({"section": section, "anchor": anchor, "panels": panels, "table": _table(section)})
    return views


def _table(section: Section) -> dict[str, Any]:
    left = [column == 0 or name in TEXT or not name for column, name in enumerate(section.header)]
    rows = [[_cell(text, is_left) for text, is_left in zip(row, left, strict=True)] for row in section.rows]
    return {"header": list(zip(section.header, left, strict=True)), "rows": rows}


def _cell(text: str, left: bool) -> tuple[str, str, str]:
    """A cell's text, class and sign."""
    kind, sign = CELLS.get(text, ("", ""))
    return text, " ".join(filter(None, ("" if left else "number", kind))), sign


def panel_json(panel: Panel) -> dict[str, Any]:
    """A panel as plotly.js takes it, arrays packed."""
    return {"data": _packed(list(panel.data)), "layout": _packed({"height": panel.height} | dict(panel.layout))}


def _packed(value: Any) -> Any:
    """Arrays as plotly's typed arrays in base 64: a third of the text that numbers take, and read ten times as fast."""
    if isinstance(value, np.ndarray):
        packed = {"dtype": {"float32": "f4", "float64": "f8"}[value.dtype.name], "bdata": _encoded(value)}
        return packed if value.ndim == 1 else packed | {"shape": ", ".join(map(str, value.shape))}
    if isinstance(value, Mapping):
        return {key: _packed(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_packed(item) for item in value]
    return value


def _encoded(values: np.ndarray[Any, Any]) -> str:
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return b64encode(little.tobytes()).decode("ascii")


def _json(value: Any) -> str:
    """JSON that may stand in a script element: nothing in it ends the element."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text
