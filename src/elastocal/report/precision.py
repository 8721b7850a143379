"""Sections on how sure a calibration is: uncertainty of predicted positions, and what changed between two of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from elastocal.chain import Array
from elastocal.drift import Change, Difference
from elastocal.report.section import Section
from elastocal.report.sections import DISPLAY, advice_sections
from elastocal.robot import Robot
from elastocal.uncertainty import Uncertainty


def uncertainty_sections(robot: Robot, found: Uncertainty) -> list[Section]:
    """How uncertain the predicted position is, over all poses."""
    rows = [("from the parameters", *_spread(found.from_parameters))]
    rows.append(("from the model's error", *_spread(np.full(len(found.data), found.from_model))))
    rows.append(("together", *_spread(found.total)))
    header = ("standard deviation", "median [mm]", "95 % [mm]", "max [mm]")
    title = f"{robot.name}: uncertainty of the predicted position at {len(found.data)} poses"
    return [Section(title, header, tuple(rows), tuple(_explained(robot, found)))]


def _spread(values: Array) -> tuple[str, str, str]:
    median, most, largest = np.median(values), np.quantile(values, 0.95), values.max()
    return f"{1e3 * median:.4f}", f"{1e3 * most:.4f}", f"{1e3 * largest:.4f}"


def _explained(robot: Robot, found: Uncertainty) -> Iterator[str]:
    yield "Root mean square length of the position's error, in the instrument's frame."
    worst = int(np.argmax(found.from_parameters))
    slides = [row.joint == "prismatic" for row in robot.joints][: robot.positions]
    slides += [False] * (robot.positions - len(slides))
    joints = ", ".join(
        f"{1e3 * q:.1f} mm" if slide else f"{math.degrees(q):.1f} deg"
        for q, slide in zip(found.data.q[worst], slides, strict=True)
    )
    yield f"Largest at joint positions {joints}."
    ratio = found.measured_ratio
    if ratio is not None:
        yield f"The errors measured at these poses are {ratio:.2f} times as large, root mean square."


def difference_sections(found: Difference) -> list[Section]:
    """What changed between two calibrations, the most changed first, and what that means."""
    sections = [
        Section(f"{found.robot}: changes between two calibrations", HEADER, _rows(found.changes), (found.verdict,))
    ]
    if found.frames:
        moved = "These move with the instrument and the probe, which is no drift of the robot."
        sections.append(Section("Frames", HEADER, _rows(found.frames), (moved,)))
    only = (("first", found.only_before), ("second", found.only_after))
    told = [f"Only the {which} identified {', '.join(names)}." for which, names in only if names]
    if told:
        sections.append(Section("Not in both", sentences=tuple(told)))
    return sections + advice_sections(found.warnings)


HEADER = ("parameter", "unit", "before", "after", "change", "±", "in std")


def _rows(changes: Sequence[Change]) -> tuple[tuple[str, ...], ...]:
    rows = []
    for c in sorted(changes, key=lambda change: -abs(change.score)):
        unit, scale = DISPLAY.get(c.unit, (c.unit, 1.0))
        places = max(0, 1 - math.floor(math.log10(c.std * scale))) if c.std > 0.0 else 6
        values = (f"{value * scale:.{places}f}" for value in (c.before, c.after, c.change, c.std))
        name = c.name.replace(".transition_torque", " torque")
        rows.append((name, unit, *values, f"{c.score:+.1f}"))
    return tuple(rows)
