"""The figures of a reproduction as plain tables, SI: what `reproduce --json` prints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from elastocal.identification import CalibrationResult
from elastocal.reproduction import ha006, stiffness_analysis
from elastocal.reproduction.nonlinear_stiffness import (
    BEFORE,
    CALIBRATED,
    EVALUATED,
    Ladder,
    RungRun,
    parameter_rows,
)
from elastocal.reproduction.selection import Reproduction
from elastocal.reproduction.stiffness_analysis import CaseRun
from elastocal.reproduction.values import ParameterRow, StiffnessRow


def figures(reproduction: Reproduction) -> dict[str, Any]:
    """All figures by paper and case, with each paper's open inputs (`chosen`) and slips; SI."""
    found: dict[str, Any] = {}
    papers = []
    if reproduction.cases:
        papers.append(stiffness_analysis.PAPER)
        found[papers[-1].key] = {run.case.name: _case(run) for run in reproduction.cases}
    if reproduction.ladder:
        papers.append(ha006.PAPER)
        found[papers[-1].key] = _ladder(reproduction.ladder)
    return found | {
        "seed": reproduction.seed,
        "chosen": {paper.key: [asdict(chosen) for chosen in paper.chosen] for paper in papers},
        "slips": {paper.key: [asdict(slip) for slip in paper.slips] for paper in papers},
    }


def _case(run: CaseRun) -> dict[str, Any]:
    return {
        "paper": asdict(run.case.paper),
        "ours": asdict(run.ours),
        "deflecting": list(run.case.deflecting),
        "elastic": list(run.case.elastic),
        **_outcome(run.result),
        "parameters": _parameters(run.parameters),
        "stiffness": [_stiffness(row) for row in run.stiffness],
    }


def _ladder(ladder: Ladder) -> dict[str, Any]:
    before = asdict(ladder.before) | {"paper": asdict(BEFORE), "evaluated": asdict(ladder.before_evaluated)}
    return {"before": before, **{run.rung.name: _rung(ladder, run) for run in ladder.runs}}


def _rung(ladder: Ladder, run: RungRun) -> dict[str, Any]:
    search = run.result.search
    found = {
        "calibrated": asdict(run.calibrated),
        "evaluated": asdict(run.evaluated),
        **_outcome(run.result),
        "elastic": [asdict(element) for element in run.result.elastic],
        "search": None if search is None else {"method": search.method, "proven": search.proven, "fits": search.fits},
        "parameters": _parameters(parameter_rows(ladder.experiment, run)),
    }
    if run.rung.printed:
        found["paper"] = {"calibrated": asdict(CALIBRATED), "evaluated": asdict(EVALUATED)}
    return found


def _outcome(result: CalibrationResult) -> dict[str, Any]:
    return {"status": result.status, "warnings": list(result.warnings)}


def _parameters(rows: Iterable[ParameterRow]) -> list[dict[str, Any]]:
    return [asdict(row) | {"unit": "m" if row.unit == "m" else "rad"} for row in rows]


def _stiffness(row: StiffnessRow) -> dict[str, Any]:
    return asdict(row) | {"ours": row.ours}
