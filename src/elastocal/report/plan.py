"""Sections on a plan: which poses, what they tell, and how many are enough."""

from __future__ import annotations

import math
from collections.abc import Iterator

from elastocal.design import CurvePoint, Plan, PlannedTransition
from elastocal.report.section import Section
from elastocal.report.sections import DISPLAY, advice_sections

BAR = 24
"""Characters of the longest bar."""

LONGEST_BAR = 2.5
"""Times the accuracy of the plan: few poses are so bad that the other bars would be too short to compare."""

MOST_LISTED = 8

CRITERIA = {
    "O1": "O1, the determinant",
    "O2": "O2, the inverse condition number",
    "O3": "O3, the smallest singular value",
    "O4": "O4, the noise amplification",
    "O5": "O5, the inverse singular values' sum",
    "accuracy": "the accuracy over the workspace",
}


def plan_sections(plan: Plan) -> list[Section]:
    """All sections on a plan."""
    sections = [_summary(plan), _parameters(plan)]
    if plan.transitions:
        sections.append(_transitions(plan))
    sections.append(_curve(plan))
    notes = tuple(f"{note[:1].upper()}{note[1:]}." for note in plan.notes)
    return sections + advice_sections([f"{text[:1].upper()}{text[1:]}." for text in plan.warnings], notes)


def _summary(plan: Plan) -> Section:
    count = len(plan.rows)
    chosen = f"{count} of {plan.candidates} candidates, by {CRITERIA[plan.criterion]}"
    if plan.measured:
        chosen += f"; {plan.measured} measured before count too"
    seen = plan.observability
    told = f"{seen.rank} of {seen.parameters} parameters are told."
    rows = [(f"O{i}", f"{getattr(seen, f'O{i}'):.4g}") for i in range(1, 6)]
    rows.append(("condition", f"{seen.condition:.4g}" if math.isfinite(seen.condition) else ""))
    return Section(
        f"{plan.robot.name}: {chosen}",
        ("observability", "index"),
        tuple(rows) if seen.rank == seen.parameters else (),
        (told, _order(plan)),
    )


def _order(plan: Plan) -> str:
    before, after = plan.travel["before"], plan.travel["after"]
    if any(row.joint == "prismatic" for row in plan.robot.joints):
        ways = f"{after:.2f} rad or m, {before:.2f}"
    else:
        ways = f"{math.degrees(after):.0f} deg, {math.degrees(before):.0f} deg"
    return (
        f"In this order the largest joint moves add up to {ways} as they were chosen. The ways between the poses are "
        "not checked."
    )


def _parameters(plan: Plan) -> Section:
    rows = []
    for p in plan.parameters:
        unit, scale = DISPLAY.get(p.unit, (p.unit, 1.0))
        nominal = "" if p.nominal is None else f"{p.nominal * scale:.6g}"
        name = p.name.replace(".transition_torque", " torque")
        rows.append((name, unit, nominal, "" if p.std is None else f"{p.std * scale:.2g}"))
    header = ("parameter", "unit", "nominal", "expected ±")
    return Section("What they tell", header, tuple(rows), tuple(_not_told(plan)))


def _not_told(plan: Plan) -> Iterator[str]:
    reading = plan.reading
    noises = []
    if {"position", "distance"} & set(reading.kinds):
        noises.append(f"{1e3 * reading.noise:g} mm")
    if "orientation" in reading.kinds:
        noises.append(f"{1e3 * reading.noise_angle:g} mrad")
    yield f"±: standard deviation, of noise alone: {' and '.join(noises)} in each coordinate (--noise)."
    for verdict in ("dependent", "unobservable"):
        names = [name for name, dropped in plan.gauge.dropped.items() if dropped.verdict == verdict]
        if names:
            more = len(names) - MOST_LISTED
            yield f"{len(names)} {verdict}: {', '.join(names[:MOST_LISTED])}" + (
                f" and {more} more" if more > 0 else ""
            )


def _transitions(plan: Plan) -> Section:
    header = ("transition", "law", "torque", "below", "above", "loads", "widest gap")
    return Section("Loads about transition torques", header, tuple(_transition(t) for t in plan.transitions))


def _transition(t: PlannedTransition) -> tuple[str, ...]:
    loads = f"{t.lowest:.3g} … {t.highest:.3g}"
    return (t.element, t.law, f"{t.torque:.4g}", str(t.below), str(t.above), loads, f"{t.widest_gap:.3g}")


def _curve(plan: Plan) -> Section:
    found = [p.planned for p in plan.curve if p.planned is not None]
    longest = min(max(found, default=0.0), LONGEST_BAR * (plan.accuracy or math.inf))
    rows = tuple(_point(p, len(plan.rows), longest) for p in plan.curve)
    header = ("poses", "planned [mm]", "random [mm]", "█ planned, ░ random")
    return Section("Expected accuracy", header, rows, tuple(_how_many(plan)))


def _point(point: CurvePoint, count: int, longest: float) -> tuple[str, ...]:
    mark = f"{point.poses} *" if point.poses == count else f"{point.poses}  "
    if point.planned is None:
        return (mark, "", "", "")
    planned = min(BAR, round(BAR * point.planned / longest))
    more = max(0, min(BAR, round(BAR * (point.random or 0.0) / longest)) - planned)
    random = "" if point.random is None else f"{1e3 * point.random:.4f}"
    return (mark, f"{1e3 * point.planned:.4f}", random, ("█" * planned + "░" * more).ljust(BAR, "·"))


def _how_many(plan: Plan) -> Iterator[str]:
    yield (
        "Standard deviation of the predicted position over the workspace, root mean square, of noise alone; what the "
        "model leaves out adds to it. *: this plan."
    )
    last = plan.curve[-1].poses
    if plan.enough is not None:
        yield f"{plan.enough} poses are enough: from there on five more improve the accuracy by less than 5 %."
    elif any(p.planned is not None for p in plan.curve):
        yield f"Even at {last} poses five more improve the accuracy by 5 % or more."
    else:
        yield f"Up to {last} poses do not tell all parameters."
