"""The figure: held-out error by arm and tool, on a logarithmic axis, as an SVG for light and dark pages.

It brings its own background, because a page and the system that shows it need not agree on light or dark.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from runs import Result
from summary import LAWS, Cell, cell, of_setting
from tools import TOOLS

WIDTH, LEFT, RIGHT, TOP = 860, 150, 36, 92
ROW, GROUP_GAP = 27, 34
LOW, HIGH = 0.01, 10.0
"""Ends of the axis [mm]."""

TITLES = {
    "rigid": "Rigid arms",
    "linear": "Joints that give way in proportion to their load",
    "step": "Joints that stiffen by a step at a torque",
    "hinge": "Joints that stiffen by a kink at a torque",
}

STYLE = """
  .ink { fill: #1f2937 } .soft { fill: #5b6472 } .ours { fill: #1d4ed8 } .peer { fill: #64748b }
  .grid { stroke: #d5dae1 } .zero { stroke: #b45309; stroke-dasharray: 3 3 } .note { fill: #b45309 }
  .span-ours { stroke: #1d4ed8 } .span-peer { stroke: #64748b } .hole { fill: #ffffff }
  .band { fill: #1d4ed8; fill-opacity: 0.06 }
  text { font: 13px system-ui, -apple-system, "Segoe UI", Helvetica, Arial, sans-serif }
  .title { font-size: 17px; font-weight: 600 } .group { font-weight: 600 } .small { font-size: 12px }
  .bold { font-weight: 600 }
  @media (prefers-color-scheme: dark) {
    .ink { fill: #e6eaf0 } .soft { fill: #9aa4b2 } .ours { fill: #7aa7ff } .peer { fill: #94a3b8 }
    .grid { stroke: #333b47 } .zero { stroke: #e0a458 } .note { fill: #e0a458 }
    .span-ours { stroke: #7aa7ff } .span-peer { stroke: #94a3b8 } .hole { fill: #0d1117 }
    .band { fill: #7aa7ff; fill-opacity: 0.09 }
  }
"""


def x_of(error: float) -> float:
    """Where an error [mm] stands, within the axis."""
    share = math.log(max(LOW, min(HIGH, error)) / LOW) / math.log(HIGH / LOW)
    return LEFT + share * (WIDTH - LEFT - RIGHT)


def figure(results: Sequence[Result]) -> str:
    """The SVG of all results."""
    height_of_group = ROW * len(TOOLS) + GROUP_GAP
    bottom = TOP + height_of_group * len(LAWS)
    parts = [_head(bottom + 44), *_axis(bottom)]
    for i, law in enumerate(LAWS):
        parts += _group(results, law, TOP + i * height_of_group)
    return "\n".join([*parts, "</svg>\n"])


def _head(height: float) -> str:
    legend = TOP - 40
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" \
height="{height}" role="img" aria-label="Held-out position error of four tools on four kinds of arm">
<style>{STYLE}</style>
<rect width="{WIDTH}" height="{height}" rx="10" class="hole"/>
<text x="16" y="28" class="ink title">
How far off after calibration, at poses that the fit has not seen</text>
<circle cx="22" cy="{legend - 4}" r="5" class="peer"/><text x="33" y="{legend}" class="soft small">at its best</text>
<circle cx="118" cy="{legend - 4}" r="4.5" class="hole span-peer" stroke-width="1.6"/>
<text x="129" y="{legend}" class="soft small">as it comes</text>
<line x1="211" x2="239" y1="{legend - 4}" y2="{legend - 4}" class="span-peer" stroke-width="5" stroke-opacity="0.28" \
stroke-linecap="round"/>
<text x="248" y="{legend}" class="soft small">from the best to the worst arm</text>
<line x1="441" x2="441" y1="{legend - 12}" y2="{legend + 3}" class="zero" stroke-width="1.5"/>
<text x="450" y="{legend}" class="soft small">not calibrated</text>
<text x="{WIDTH - RIGHT}" y="{legend}" text-anchor="end" class="soft small">mean position error [mm], log scale\
</text>"""


def _axis(bottom: float) -> list[str]:
    lines = []
    for tick in (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0):
        x = x_of(tick)
        lines.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP - 12}" y2="{bottom}" class="grid"/>')
        lines.append(f'<text x="{x:.1f}" y="{bottom + 20}" text-anchor="middle" class="soft small">{tick:g}</text>')
    return lines


def _group(results: Sequence[Result], law: str, y: float) -> list[str]:
    """The rows of one kind of arm, from y down."""
    first, last = y + GROUP_GAP - 4, y + GROUP_GAP + ROW * (len(TOOLS) - 1) + 4
    nominal = x_of(cell(results, "nominal", "aligned", law).mean)
    parts = [
        f'<rect x="8" y="{first - ROW / 2 + 4:.1f}" width="{WIDTH - 16}" height="{ROW}" rx="6" class="band"/>',
        f'<text x="16" y="{y + 12}" class="ink group">{escape(TITLES[law])}</text>',
        f'<line x1="{nominal:.1f}" x2="{nominal:.1f}" y1="{first - 9}" y2="{last + 9}" class="zero" '
        'stroke-width="1.5"/>',
    ]
    for i, tool in enumerate(TOOLS):
        best, default = (cell(results, tool.name, setting, law) for setting in ("best", "default"))
        off = sum(r.law == law and not r.mean <= HIGH for r in of_setting(results, tool.name, "default"))
        parts += _row(tool.name, best, default, f"{off} of {default.arms} diverge", y + GROUP_GAP + i * ROW)
    return parts


def _row(name: str, best: Cell, default: Cell, off: str, y: float) -> list[str]:
    kind, weight = ("ours", " bold") if name == "elastocal" else ("peer", "")
    parts = [f'<text x="{LEFT - 18}" y="{y + 4}" text-anchor="end" class="{kind}{weight}">{name}</text>']
    if math.isfinite(default.mean):
        parts += _default(kind, default, off, y)
    if not math.isfinite(best.mean):
        return [*parts, f'<text x="{LEFT}" y="{y + 4}" class="note small">no result</text>']
    least, most, x = x_of(best.least), x_of(best.most), x_of(best.mean)
    parts.append(
        f'<line x1="{least:.1f}" x2="{most:.1f}" y1="{y}" y2="{y}" class="span-{kind}" stroke-width="5" '
        'stroke-opacity="0.28" stroke-linecap="round"/>'
    )
    parts.append(f'<circle cx="{x:.1f}" cy="{y}" r="5.5" class="{kind}"/>')
    parts.append(
        f'<text x="{least - 9:.1f}" y="{y + 4}" text-anchor="end" class="{kind} small{weight}">{best.mean:.2g}</text>'
    )
    return parts


def _default(kind: str, default: Cell, off: str, y: float) -> list[str]:
    """An open circle, or an arrow where the error leaves the axis."""
    if default.mean <= HIGH:
        return [f'<circle cx="{x_of(default.mean):.1f}" cy="{y}" r="4.5" class="hole span-{kind}" stroke-width="1.6"/>']
    x = WIDTH - RIGHT
    return [
        f'<path d="M{x - 10} {y - 5} L{x} {y} L{x - 10} {y + 5} Z" class="note"/>',
        f'<text x="{x - 16}" y="{y + 4}" text-anchor="end" class="note small">{off}</text>',
    ]
