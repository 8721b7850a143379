"""Plans out: a measurement table to fill in, and JSON."""

from __future__ import annotations

from importlib.metadata import version
from io import BytesIO
from typing import Any

import numpy as np
import polars as pl

from elastocal.design import Plan
from elastocal.io.results import dump

FORMAT = "elastocal-plan/1"

TO_FILL_IN = {
    "position": ("x [mm]", "y [mm]", "z [mm]"),
    "orientation": ("qw", "qx", "qy", "qz"),
    "distance": ("distance [mm]",),
}
"""Columns that the measurements go to, by kind."""


def plan_csv(plan: Plan) -> bytes:
    """The poses as a tidy table in rad and m, with empty columns for what is measured.

    Where the nominal robot's frames are known, columns that `calibrate` ignores say where to expect the target.
    """
    poses = plan.poses
    columns: dict[str, Any] = {f"q{i}": values for i, values in enumerate(poses.q.T, start=1)}
    for name, labels in (("target", poses.target), ("load", poses.load), ("station", poses.station)):
        if labels is not None:
            columns[name] = [labels.name(int(code)) for code in labels.codes]
    empty = pl.Series([None] * len(poses), dtype=pl.Float64)
    for kind in TO_FILL_IN:
        if kind in plan.reading.kinds:
            columns |= dict.fromkeys(TO_FILL_IN[kind], empty)
    if plan.expected is not None:
        millimetres = np.round(plan.expected / 1e-3, 3)
        columns |= {f"expected_{axis} [mm]": values for axis, values in zip("xyz", millimetres.T, strict=True)}
        if "distance" in plan.reading.kinds:
            columns["expected_distance [mm]"] = np.round(np.linalg.norm(plan.expected, axis=1) / 1e-3, 3)
    buffer = BytesIO()
    pl.DataFrame(columns).write_csv(buffer)
    return buffer.getvalue()


def plan_json(plan: Plan) -> str:
    """The plan as JSON, SI units."""
    seen, poses = plan.observability, plan.poses
    labels = {"target": poses.target, "load": poses.load, "station": poses.station}
    return dump(
        {
            "format": FORMAT,
            "robot": plan.robot.name,
            "status": plan.status,
            "criterion": plan.criterion,
            "poses": {
                "candidate": (plan.rows + 1).tolist(),
                "q": plan.q.tolist(),
                **{
                    name: [found.name(int(code)) for code in found.codes]
                    for name, found in labels.items()
                    if found is not None
                },
                "expected": None if plan.expected is None else plan.expected.tolist(),
            },
            "parameters": [
                {"name": p.name, "unit": p.unit, "nominal": p.nominal, "std": p.std} for p in plan.parameters
            ],
            "dropped": {name: found.verdict for name, found in plan.gauge.dropped.items()},
            "observability": {
                "rank": seen.rank,
                "parameters": seen.parameters,
                "condition": seen.condition,
                **{f"O{i}": getattr(seen, f"O{i}") for i in range(1, 6)},
            },
            "accuracy": plan.accuracy,
            "curve": [{"poses": p.poses, "planned": p.planned, "random": p.random} for p in plan.curve],
            "enough": plan.enough,
            "transitions": [
                {
                    "element": t.element,
                    "law": t.law,
                    "transition_torque": t.torque,
                    "source": t.source,
                    "loads": {
                        "below": t.below,
                        "above": t.above,
                        "lowest": t.lowest,
                        "highest": t.highest,
                        "widest_gap": t.widest_gap,
                    },
                }
                for t in plan.transitions
            ],
            "travel": dict(plan.travel),
            "candidates": plan.candidates,
            "measured": plan.measured,
            "warnings": list(plan.warnings),
            "notes": list(plan.notes),
            "seconds": plan.seconds,
            "settings": dict(plan.settings),
            "version": version("elastocal"),
        }
    )
