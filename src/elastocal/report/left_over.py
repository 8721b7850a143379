"""Sections on what the model leaves: does it follow a joint's position, or its torque?"""

from __future__ import annotations

from elastocal.figures.residuals import Pattern, joint_panels, patterns, torque_panels
from elastocal.figures.rows import Means, Rows
from elastocal.identification import AnyResult
from elastocal.report.section import Section, Verdict

MUCH = 0.1
"""A share of what is left that is worth modelling."""

ALSO = 0.8
"""What follows the torque follows the position too, of which it is a function: told if it is this share of that."""

BY_CHANCE = 1e-4
"""Probability of a pattern by chance, below which it is told: twelve are looked at."""

FEWEST = 40
"""Rows from which on shares are told."""


POINTS = "Points are rows, the line is their mean with a band of two standard errors."


def pattern_section(result: AnyResult, rows: Rows) -> Section:
    """How much of what is left follows each joint's position, and its torque; what would model it."""
    told = (
        "What the calibrated model leaves, row by row, taken as a motion of one joint alone. What follows a joint's "
        "position is an error of its drive or geometry, what follows its torque is compliance. Shares of several "
        "joints overlap, since their motions do."
    )
    if len(rows) < FEWEST or not rows.measured:
        few = f"Of {len(rows)} rows no pattern is told: {FEWEST} are needed, with positions or distances."
        return Section("What is not yet modelled", prose=told, sentences=(few,))
    found = patterns(result, rows)
    table = tuple((p.element, _percent(p.position), "" if p.torque is None else _percent(p.torque)) for p in found)
    header = ("joint", "follows its position [%]", "follows its torque [%]")
    return Section("What is not yet modelled", header, table, prose=told, verdict=_verdict(result, found))


def _percent(found: Means) -> str:
    return f"{100.0 * found.share:.0f}"


def _much(found: Means | None) -> float:
    """The share that a pattern explains, if it is worth modelling and not there by chance."""
    return 0.0 if found is None or found.share < MUCH or found.probability > BY_CHANCE else found.share


def _verdict(result: AnyResult, found: list[Pattern]) -> Verdict:
    waves = [p for p in found if _much(p.position)]
    loads = [p for p in found if _much(p.torque) > ALSO * _much(p.position)]
    if not waves and not loads:
        text = f"Of what is left no {100 * MUCH:.0f} % follow the position of a joint, or its torque, beyond chance."
        return Verdict("good", text)
    told = []
    if waves:
        most = max(waves, key=lambda p: _much(p.position))
        remedy = "" if result.maps else ": joint maps may take it away (--transmission auto)"
        told.append(f"{_percent(most.position)} % of what is left follows the position of {most.element}{remedy}")
    if loads:
        most = max(loads, key=lambda p: _much(p.torque))
        joint, bends = most.element.rpartition(".")[0], most.element in result.robot.elastic
        remedy = "compare other laws (elastocal compare)" if bends else f"it may give way (--elastic {joint})"
        told.append(f"{100 * _much(most.torque):.0f} % follows the torque on {most.element}: {remedy}")
    return Verdict("caution", "; ".join(told) + ".")


def joint_section(result: AnyResult, rows: Rows) -> Section:
    """What is left against the position of each joint."""
    panels = tuple(joint_panels(result, rows)) if rows.measured else ()
    return Section(
        "Residual against joint position", prose=POINTS + " A flat mean: nothing is left to model.", panels=panels
    )


def torque_section(result: AnyResult, rows: Rows) -> Section:
    """What is left against the torque on each joint that carries one."""
    told = (
        POINTS + " Torques at the reported joint positions; a mean that leans or bends is compliance not yet modelled."
    )
    panels = tuple(torque_panels(result, rows)) if rows.measured else ()
    return Section("Residual against joint torque", prose=told, panels=panels)
