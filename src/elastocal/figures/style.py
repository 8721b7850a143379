"""Colours that people with any colour vision tell apart (Okabe and Ito, 2008), on light and on dark pages."""

from __future__ import annotations

from typing import Any

BEFORE, AFTER, UNSEEN = "#d55e00", "#0072b2", "#009e73"
"""Errors before calibration, after it on fitted rows, after it on held-out rows."""

LAW, DATA, MEANS, MARK = "#0072b2", "#79838f", "#1b1f26", "#d55e00"
"""What the model says, single rows, averages of rows, and what is pointed at, as a transition torque."""

LINK, JOINT = "#5c6672", "#cc79a7"
"""Of the drawn robot."""

NEUTRAL = "#f6f7f8"
"""Between the two ends of a diverging scale."""

SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#79838f")
"""Of results side by side."""

DIVERGING = [[0.0, "#0072b2"], [0.5, NEUTRAL], [1.0, "#d55e00"]]
SEQUENTIAL = "Cividis"

ON_DARK = {
    "#d55e00": "#ff8f4d",
    "#0072b2": "#5bb8f5",
    "#009e73": "#35cfa0",
    "#79838f": "#8d98a6",
    "#1b1f26": "#eef1f5",
    "#5c6672": "#a3adba",
    "#cc79a7": "#e6a5ca",
    "#e69f00": "#ffc14d",
    "#f6f7f8": "#20252c",
}
"""What each colour becomes on a dark page, tints of it likewise."""


def tinted(color: str) -> str:
    """A colour that lets through what lies below."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.18)"


def dark_colors() -> dict[str, str]:
    """Colours and their tints on a light page, and what they become on a dark one."""
    return ON_DARK | {tinted(light): tinted(dark) for light, dark in ON_DARK.items()}


FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', sans-serif"


def _template(ink: str, grid: str, rule: str, label: str) -> dict[str, Any]:
    axis = {
        "gridcolor": grid,
        "linecolor": rule,
        "zerolinecolor": rule,
        "zerolinewidth": 1,
        "tickcolor": rule,
        "ticks": "outside",
        "ticklen": 4,
        "showline": True,
        "automargin": True,
        "title": {"standoff": 8},
    }
    solid = {"gridcolor": grid, "linecolor": rule, "zerolinecolor": rule, "showbackground": False, "color": ink}
    return {
        "layout": {
            "font": {"family": FONT, "size": 12, "color": ink},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "colorway": list(SERIES),
            "xaxis": axis,
            "yaxis": axis,
            "scene": {"xaxis": solid, "yaxis": solid, "zaxis": solid},
            "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
            "margin": {"l": 8, "r": 8, "t": 8, "b": 8},
            "hoverlabel": {"bgcolor": label, "bordercolor": rule, "font": {"color": ink, "family": FONT}},
            "hovermode": "closest",
        }
    }


LIGHT = _template("#1b1f26", "#e4e8ed", "#9aa4b0", "#ffffff")
DARK = _template("#e4e8ee", "#2f363f", "#6b7683", "#20252c")
"""Templates of figures on light and on dark pages."""
