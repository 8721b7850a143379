"""Panels: what a figure shows, as plotly's own description of it, with arrays in place of lists.

Reports write panels down as they are, which takes a tenth of the time that checked plotly figures do; `figure` makes
such a figure of them.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.figures.style import LIGHT, tinted

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

Trace = dict[str, Any]

MOST_POINTS = 800
"""Points of a cloud that a panel draws: more are one blot on a screen, and slow to scroll past."""


@dataclass(frozen=True)
class Panel:
    """One pair of axes, or one scene, and what is drawn in it.

    Attributes:
        title: shown above it.
        data: plotly's traces.
        layout: plotly's layout.
        note: what of the data is not drawn.
        height: in pixels.
        wide: whether it takes the whole width of a page.
    """

    title: str
    data: Sequence[Trace]
    layout: Mapping[str, Any]
    note: str = ""
    height: int = 320
    wide: bool = False


def plain(text: str) -> str:
    """A name as plotly shows it to the letter: it takes text for a kind of HTML."""
    return html.escape(text, quote=False)


def numbers(values: Array | Sequence[float]) -> NDArray[np.float32]:
    """Numbers as a screen needs them."""
    return np.asarray(values, dtype=np.float32)


def thinned(n: int, most: int = MOST_POINTS) -> NDArray[np.intp]:
    """At most so many of n rows, evenly spread."""
    return np.arange(n) if n <= most else np.unique(np.linspace(0, n - 1, most).astype(int))


def counted(shown: int, n: int, what: str = "points") -> str:
    """How many of n are drawn; nothing if all are."""
    return "" if shown >= n or not shown else f"{shown} of {n} {what} drawn"


def points(x: Array, y: Array, name: str, color: str, **more: Any) -> Trace:
    """A cloud of points."""
    marker = {"size": 4, "color": color, "opacity": 0.45, "line": {"width": 0}} | more.pop("marker", {})
    trace = {"type": "scatter", "mode": "markers", "x": numbers(x), "y": numbers(y), "name": plain(name)}
    return trace | {"marker": marker} | more


def line(x: Array, y: Array, name: str, color: str, dash: str = "solid", **more: Any) -> Trace:
    """A curve."""
    trace = {"type": "scatter", "mode": "lines", "x": numbers(x), "y": numbers(y), "name": plain(name)}
    return trace | {"line": {"color": color, "width": 2, "dash": dash}} | more


def band(x: Array, low: Array, high: Array, name: str, color: str) -> Trace:
    """What lies between two curves."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(np.concatenate([x, x[::-1]])),
        "y": numbers(np.concatenate([high, low[::-1]])),
        "name": plain(name),
        "line": {"width": 0, "color": color},
        "fill": "toself",
        "fillcolor": tinted(color),
        "hoverinfo": "skip",
    }


def axes(x: str, y: str, **more: Any) -> dict[str, Any]:
    """The layout of two axes with titles; `xaxis` and `yaxis` add to them."""
    return {
        "xaxis": {"title": {"text": x}} | more.pop("xaxis", {}),
        "yaxis": {"title": {"text": y}} | more.pop("yaxis", {}),
    } | more


def upright(x: float, color: str, dash: str = "dash") -> dict[str, Any]:
    """A line across the panel at x."""
    place = {"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "y domain"}
    return place | {"line": {"color": color, "width": 1.5, "dash": dash}}


def level(y: float, color: str, dash: str = "dash") -> dict[str, Any]:
    """A line across the panel at y."""
    place = {"type": "line", "y0": y, "y1": y, "x0": 0, "x1": 1, "xref": "x domain"}
    return place | {"line": {"color": color, "width": 1.5, "dash": dash}}


def stripe(low: float, high: float, color: str) -> dict[str, Any]:
    """A stripe across the panel between two x."""
    place = {"type": "rect", "x0": low, "x1": high, "y0": 0, "y1": 1, "yref": "y domain"}
    return place | {"line": {"width": 0}, "fillcolor": tinted(color), "layer": "below"}


def figure(panels: Sequence[Panel], columns: int = 2) -> Figure:
    """Panels as one plotly figure, several of them in a grid."""
    from plotly.graph_objects import Figure

    if len(panels) == 1:
        only = panels[0]
        title = {"text": plain(only.title), "font": {"size": 15}, "y": 0.98, "yanchor": "top"}
        own = {"template": LIGHT, "title": title, "height": only.height + 80, "margin": {"t": 80}}
        return Figure(list(only.data), own | dict(only.layout))
    data: list[Trace] = []
    layout: dict[str, Any] = {
        "template": LIGHT,
        "shapes": [],
        "annotations": [],
        "showlegend": False,
        "margin": {"t": 30},
    }
    rows = -(-len(panels) // columns)
    layout["height"] = 60 + sum(max(p.height for p in panels[i : i + columns]) for i in range(0, len(panels), columns))
    for number, panel in enumerate(panels):
        _place(panel, number, (rows, columns), data, layout)
    return Figure(data, layout)


def _place(panel: Panel, number: int, grid: tuple[int, int], data: list[Trace], layout: dict[str, Any]) -> None:
    """Put a panel into its place of a grid: its axes get numbers of their own."""
    row, column = divmod(number, grid[1])
    width, height = 1.0 / grid[1], 1.0 / grid[0]
    left, top = column * width, 1.0 - row * height
    across, upward = [left + 0.1 * width, left + 0.95 * width], [top - 0.78 * height, top - 0.1 * height]
    own, other = ("" if number == 0 else str(2 * number + 1)), str(2 * number + 2)  # a second axis shares the panel
    names = {"x": f"x{own}", "y": f"y{own}", "y2": f"y{other}"}
    for trace in panel.data:
        moved = trace | {"xaxis": names["x"], "yaxis": names[trace.get("yaxis", "y")]}
        if "colorbar" in trace:
            beside = {"x": across[1], "xanchor": "left", "y": sum(upward) / 2, "len": upward[1] - upward[0]}
            moved["colorbar"] = trace["colorbar"] | beside
        data.append(moved)
    layout[f"xaxis{own}"] = {"domain": across, "anchor": names["y"]} | panel.layout.get("xaxis", {})
    layout[f"yaxis{own}"] = {"domain": upward, "anchor": names["x"]} | panel.layout.get("yaxis", {})
    if "scaleanchor" in layout[f"yaxis{own}"]:
        layout[f"yaxis{own}"]["scaleanchor"] = names["x"]
    if "yaxis2" in panel.layout:
        layout[f"yaxis{other}"] = panel.layout["yaxis2"] | {"overlaying": names["y"], "anchor": names["x"]}
    for shape in panel.layout.get("shapes", ()):
        moved = {"xref": "x", "yref": "y"} | shape
        for key in ("xref", "yref"):
            axis, _, domain = moved[key].partition(" ")
            moved[key] = f"{names[axis]} {domain}".strip()
        layout["shapes"].append(moved)
    title = {"text": plain(panel.title), "showarrow": False, "font": {"size": 14}}
    place = {"xref": "paper", "yref": "paper", "x": sum(across) / 2, "y": upward[1] + 0.02, "yanchor": "bottom"}
    layout["annotations"].append(title | place)
