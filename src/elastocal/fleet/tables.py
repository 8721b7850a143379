"""A fleet's summary as tables and as JSON, SI units."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from elastocal.drift import Change
from elastocal.fleet.summary import Drift, FleetSummary, accuracy
from elastocal.fleet.task import FleetOutcome
from elastocal.identification import IdentifiedParameter
from elastocal.io.results import dump


def fleet_json(summary: FleetSummary) -> str:
    """A fleet's summary as JSON, SI units."""
    return dump(
        {
            "format": "elastocal-fleet-summary/1",
            "verdict": summary.verdict,
            "calibrations": fleet_tables(summary)["summary.parquet"],
            "siblings": [
                {
                    "robot": group.robot,
                    "serials": list(group.serials),
                    "threshold": group.threshold,
                    "parameters": [
                        {"name": name, "unit": unit, "median": median, "scatter": scatter}
                        for name, unit, median, scatter in zip(
                            group.parameters, group.units, group.median.tolist(), group.scatter.tolist(), strict=True
                        )
                    ],
                    "deviations": [asdict(deviation) for deviation in group.deviations],
                }
                for group in summary.siblings
            ],
            "version": version("elastocal"),
        }
    )


def fleet_tables(summary: FleetSummary) -> dict[str, list[dict[str, Any]]]:
    """The summary as tables by file name, SI units: a row for each calibration, and one for each of its parameters."""
    latest = {(serial, name): score for serial, name, score in _scores(summary)}
    changes = {
        (drift.serial, drift.after, change.name): change
        for drift in summary.drifts
        if drift.found is not None
        for change in drift.found.changes
    }
    drifts = {(drift.serial, drift.after): drift for drift in summary.drifts}
    last = _latest(summary.outcomes)
    odd: dict[str, list[str]] = defaultdict(list)
    for group in summary.siblings:
        for deviation in group.deviations:
            odd[deviation.serial].append(deviation.parameter)
    rows = [
        _row(o, drifts.get((o.row.serial, o.row.date)), odd[o.row.serial] if last[o.row.serial] == o.row.date else [])
        for o in summary.outcomes
    ]
    parameters = [
        _parameter(outcome, p, latest if last[outcome.row.serial] == outcome.row.date else {}, changes)
        for outcome in summary.outcomes
        if outcome.result is not None
        for p in outcome.result.parameters
    ]
    return {"summary.parquet": rows} | ({"parameters.parquet": parameters} if parameters else {})


def _scores(summary: FleetSummary) -> Iterator[tuple[str, str, float]]:
    for group in summary.siblings:
        for serial, scores in zip(group.serials, group.scores.tolist(), strict=True):
            for name, score in zip(group.parameters, scores, strict=True):
                yield serial, name, score


def _latest(outcomes: Sequence[FleetOutcome]) -> dict[str, str]:
    """The date of each serial's last sound calibration."""
    found: dict[str, str] = {outcome.row.serial: "" for outcome in outcomes}
    for outcome in outcomes:
        if outcome.status == "converged":
            found[outcome.row.serial] = max(found[outcome.row.serial], outcome.row.date)
    return found


def _row(outcome: FleetOutcome, drift: Drift | None, differs_in: list[str]) -> dict[str, Any]:
    judged, before, after = accuracy(outcome.result) if outcome.result else ("", None, None)
    told = drift.found if drift else None
    return {
        "serial": outcome.row.serial,
        "date": outcome.row.date,
        "robot": outcome.result.robot.name if outcome.result else None,
        "folder": str(outcome.row.folder),
        "status": outcome.status,
        "reason": outcome.reason or None,
        "judged_by": judged or None,
        **{f"before_{key}": getattr(before, key, None) for key in ("n", "mean", "max", "rms")},
        **{f"after_{key}": getattr(after, key, None) for key in ("n", "mean", "max", "rms")},
        "chi2_reduced": outcome.result.chi2_reduced if outcome.result else None,
        "differs_in": differs_in,
        "drift_since": drift.before if drift else None,
        "drift": told.drift if told else None,
        "drift_probability": told.probability if told else None,
        "drift_flange_rms": told.position[0] if told else None,
        "drift_flange_noise": told.noise if told else None,
    }


def _parameter(
    outcome: FleetOutcome,
    p: IdentifiedParameter,
    scores: Mapping[tuple[str, str], float],
    changes: Mapping[tuple[str, str, str], Change],
) -> dict[str, Any]:
    change = changes.get((outcome.row.serial, outcome.row.date, p.name))
    return {
        "serial": outcome.row.serial,
        "date": outcome.row.date,
        "parameter": p.name,
        "unit": p.unit,
        "nominal": p.nominal,
        "identified": p.identified,
        "std": p.std,
        "verdict": p.verdict,
        "sibling_score": scores.get((outcome.row.serial, p.name)),
        "change": change.change if change else None,
        "change_std": change.std if change else None,
        "change_score": change.score if change else None,
    }
