"""The parts of result.json as values; what an earlier version did not write is empty."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from elastocal.identification import (
    Band,
    IdentifiedElement,
    IdentifiedParameter,
    MapFit,
    Observability,
    Outlier,
    Search,
    Statistics,
    TorqueCurve,
    TorqueMap,
    TransitionData,
)

Table = Mapping[str, Any]


def parameter_from(row: Table) -> IdentifiedParameter:
    """A parameter; an interval without an upper end reaches to infinity."""
    low, high = row.get("interval") or (None, None)
    interval = None if low is None else (float(low), math.inf if high is None else float(high))
    values = {key: row[key] for key in ("name", "unit", "nominal", "identified", "std", "verdict")}
    share = row.get("data_share")
    return IdentifiedParameter(**values, reason=row.get("reason", ""), interval=interval, data_share=share)


def element_from(row: Table, parameters: Iterable[IdentifiedParameter]) -> IdentifiedElement:
    """An elastic element; the interval of its torque is told among the parameters."""
    return IdentifiedElement(
        element=row["element"],
        law=row["law"],
        transition_torque=row["transition_torque"],
        coefficients=tuple(row["coefficients"]),
        std=tuple(row["std"]),
        verdict=row["verdict"],
        transition_std=row.get("transition_std"),
        transition=_transition(row, parameters) if "transition_gap" in row else None,
    )


def _transition(row: Table, parameters: Iterable[IdentifiedParameter]) -> TransitionData:
    low, high = row["transition_gap"]
    name, curve = f"{row['element']}.transition_torque", row.get("curve")
    return TransitionData(
        spread=row.get("transition_std") or 0.0,
        gap=(float(low), math.inf if high is None else float(high)),
        below=row["loads"]["below"],
        above=row["loads"]["above"],
        searched=row.get("searched", row.get("transition_std") is not None),
        interval=next((p.interval for p in parameters if p.name == name), None),
        curve=None if curve is None else TorqueCurve(tuple(curve["torques"]), tuple(curve["rises"])),
    )


def statistics_from(table: Table) -> Statistics:
    """Statistics, with those of the angle."""
    angle = table.get("angle")
    values = {key: table[key] for key in ("n", "mean", "max", "rms", "std")}
    return Statistics(**values, angle=None if angle is None else statistics_from(angle))


def observability_from(table: Table) -> Observability:
    """Observability; no condition is infinite."""
    condition = table.get("condition")
    return Observability(
        rank=table["rank"],
        parameters=table["parameters"],
        condition=math.inf if condition is None else float(condition),
        **{f"O{i}": float(table.get(f"O{i}") or 0.0) for i in range(1, 6)},
        singular_values=tuple(table.get("singular_values", ())),
        weakest=table.get("weakest", {}),
    )


def search_from(table: Table) -> Search:
    """How transition torques were found."""
    pair = table.get("pair")
    if pair is not None:
        one, other = pair["elements"]
        first, second = pair["torques"]
        rises = tuple(tuple(row) for row in pair["rises"])
        pair = TorqueMap((one, other), (tuple(first), tuple(second)), rises)
    return Search(
        method=table["method"],
        proven=table["proven"],
        fits=table["fits"],
        history=tuple(table.get("best_fitness", ())),
        seconds=table.get("seconds", 0.0),
        pair=pair,
    )


def maps_from(table: Table) -> MapFit:
    """How joint maps were found."""
    bands = tuple(Band(band["first"], band["last"], band["std"]) for band in table["bands"])
    return MapFit(table["orders"], bands, {int(orders): v for orders, v in table.get("log_evidence", {}).items()})


def outlier_from(row: Table) -> Outlier:
    """A row that does not fit the others."""
    return Outlier(
        index=row.get("index", -1),
        file=row["file"],
        row=row["row"],
        kind=row["kind"],
        residual=row["residual"],
        score=row["score"],
        rejected=row["rejected"],
        hint=row.get("hint", ""),
    )
