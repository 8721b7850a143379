"""Sections on the two papers, theirs beside ours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import pi

from elastocal.identification import CalibrationResult
from elastocal.report.section import Section
from elastocal.report.sections import with_deviation
from elastocal.reproduction import Figures, Paper, ParameterRow, Reproduction, ha006, stiffness_analysis
from elastocal.reproduction.nonlinear_stiffness import (
    BEFORE,
    CALIBRATED,
    EVALUATED,
    Ladder,
    RungRun,
    parameter_rows,
)
from elastocal.reproduction.stiffness_analysis import CaseRun

PRINTED_UNITS = {"rad": 1.0, "m": 1.0, "deg": 180.0 / pi}
"""Units of the papers' tables, and their factors from SI."""

TINY = 1e-5
"""Standard deviations smaller than this number are printed with an exponent."""

LABELS = {
    "rigid": "rigid",
    "linear": "linear",
    "step-ga": "step, genetic search",
    "step-exact": "step, exact search",
    "hinge": "hinge, exact search",
}


def reproduction_sections(found: Reproduction) -> list[Section]:
    """All sections: of each paper the errors first, then case by case, what was chosen, and the slips."""
    sections: list[Section] = []
    if found.cases:
        sections.append(_cases_section(found.cases))
        for case in found.cases:
            sections += _case_sections(case)
        sections += _paper_sections(stiffness_analysis.PAPER)
    if found.ladder:
        sections += _ladder_sections(found.ladder)
        sections += _paper_sections(ha006.PAPER)
    return sections


def _cases_section(runs: Sequence[CaseRun]) -> Section:
    rows = [
        (
            run.case.name,
            _joints(run.case.deflecting),
            _joints(run.case.elastic) or "rigid",
            *_beside(run.case.paper, run.ours, f"{run.ours.mean / run.case.paper.mean:.2f}"),
        )
        for run in runs
    ]
    return Section(
        f"{stiffness_analysis.PAPER.title}: position errors [mm]",
        ("case", "actual", "model", "mean, paper", "ours", "ratio", "max, paper", "ours"),
        tuple(rows),
        (
            "actual, model: the joints that give way in each. Poses, masses and stiffnesses are ours, so that errors "
            "agree only roughly.",
            *(sentence for run in runs if (sentence := _EXPLANATIONS.get(run.case.name))),
        ),
    )


def _joints(names: Sequence[str]) -> str:
    """Joint names, three and more in a row as a range."""
    return f"{names[0]}-{names[-1]}" if len(names) > 2 else ",".join(names)


_EXPLANATIONS = {
    "b-2": "b-2: the paper's fit had not come to rest; at rest it is as good as b-1, whose model it contains.",
}


def _beside(paper: Figures, ours: Figures, *between: str) -> tuple[str, ...]:
    """The mean of both, then the largest of both, in mm."""
    means = (_millimetres(value) for value in (paper.mean, ours.mean))
    return (*means, *between, *(_millimetres(value) for value in (paper.max, ours.max)))


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.3g}"


def _case_sections(run: CaseRun) -> list[Section]:
    slips = [slip for slip in stiffness_analysis.PAPER.slips if slip.place.startswith(f"Result {run.case.name},")]
    notes = tuple(f"Slip of the print: {slip.place}: {slip.printed}; meant: {slip.meant}." for slip in slips)
    sections = [parameter_section(f"{run.case.name}: parameters", run.parameters, notes)]
    if run.stiffness:
        sections.append(_stiffness_section(run))
    return sections


def parameter_section(title: str, rows: Sequence[ParameterRow], sentences: Sequence[str] = ()) -> Section:
    """Parameters in the units of the paper: nominal, actual, the paper's if it prints any, ours."""
    printed = any(row.paper is not None for row in rows)
    header = ("parameter", "unit", "nominal", "actual", *(("paper",) if printed else ()), "ours", "±", "verdict")
    cells = []
    for row in rows:
        scale = PRINTED_UNITS[row.unit]
        paper = (_plain(row.paper, scale),) if printed else ()
        ours, spread = _with_spread(row.ours, row.std, scale)
        cells.append((row.name, row.unit, _plain(row.nominal, scale), _plain(row.actual, scale), *paper, ours, spread))
    verdicts = [row.verdict for row in rows]
    if set(verdicts) == {"identified"}:
        return Section(title, header[:-1], tuple(cells), tuple(sentences))
    return Section(title, header, tuple((*c, v) for c, v in zip(cells, verdicts, strict=True)), tuple(sentences))


def _plain(value: float | None, scale: float) -> str:
    if value is None:
        return ""
    text = f"{value * scale:.7f}".rstrip("0").rstrip(".")
    return text if text != "-0" else "0"


def _with_spread(value: float, std: float | None, scale: float) -> tuple[str, str]:
    """A value and its standard deviation, this one with an exponent where it is tiny."""
    if std is None:
        return _plain(value, scale), ""
    shown, spread = with_deviation(value * scale, std * scale)
    return shown, spread if std * scale > TINY else f"{std * scale:.1e}"


def _stiffness_section(run: CaseRun) -> Section:
    rows = []
    for row in run.stiffness:
        compliance, spread = _with_spread(row.compliance, row.std, 1e6)
        actual, ours = (_million(value) or "rigid" for value in (row.actual, row.ours))
        rows.append((row.joint, actual, _million(row.paper), ours, compliance, spread, row.verdict))
    return Section(
        f"{run.case.name}: stiffness [10⁶ N·m/rad], compliance c [µrad/(N·m)]",
        ("joint", "actual", "paper", "ours", "c", "±", "verdict"),
        tuple(rows),
        tuple(_physical_sense(run)),
    )


def _million(stiffness: float | None) -> str:
    return "" if stiffness is None else f"{1e-6 * stiffness:.5g}"


def _physical_sense(run: CaseRun) -> Iterable[str]:
    """What a huge or negative stiffness means, and what the calibration has to say on compliances."""
    yield from _on_compliance(run.result)
    senseless = [
        row.joint for row in run.stiffness if row.verdict == "insignificant" and row.actual is None and row.std
    ]
    if senseless:
        yield (
            f"The stiffness of joints {', '.join(senseless)} is no quantity here: it is the inverse of a compliance "
            "that is zero within its uncertainty, so it comes out huge, with either sign. --non-negative keeps "
            "compliances from going below zero."
        )


def _on_compliance(result: CalibrationResult) -> list[str]:
    return [f"{warning[0].upper()}{warning[1:]}." for warning in result.warnings if warning.startswith("compliance")]


def _paper_sections(paper: Paper) -> list[Section]:
    chosen = tuple(f"Chosen: {chosen.what}: {chosen.value}. Reason: {chosen.reason}." for chosen in paper.chosen)
    slips = tuple(f"Slip: {slip.place}: {slip.printed}; meant: {slip.meant}." for slip in paper.slips)
    return [
        Section(f"{paper.title}: inputs that the paper does not give", sentences=chosen),
        Section(f"{paper.title}: slips of the print", sentences=slips),
    ]


def _ladder_sections(ladder: Ladder) -> list[Section]:
    title = ha006.PAPER.title
    sections = [
        _errors_section(f"{title}: errors after calibration, 45 poses [mm]", ladder, "calibrated"),
        _errors_section(f"{title}: errors on evaluation, 95 poses [mm]", ladder, "evaluated"),
    ]
    laws = [row for run in ladder.runs for row in _law_rows(run)]
    if laws:
        header = ("model", "joint", "transition", "below", "above", "verdict")
        sentences = tuple(sentence for run in ladder.runs for sentence in _on_search(run))
        sections.append(Section(f"{title}: torque [N·m], stiffness [10⁵ N·m/rad]", header, tuple(laws), sentences))
    shown = next((run for run in ladder.runs if run.rung.name == "step-exact"), ladder.runs[-1])
    rows = parameter_rows(ladder.experiment, shown)
    name = f"{title}: parameters, {LABELS[shown.rung.name]}"
    return [*sections, parameter_section(name, rows, _gauge_sentences(shown))]


def _errors_section(title: str, ladder: Ladder, which: str) -> Section:
    before = ladder.before if which == "calibrated" else ladder.before_evaluated
    printed = {"calibrated": CALIBRATED, "evaluated": EVALUATED}[which]
    rows = [("before calibration", *_maybe_beside(BEFORE if which == "calibrated" else None, before))]
    for run in ladder.runs:
        ours: Figures = getattr(run, which)
        rows.append((LABELS[run.rung.name], *_maybe_beside(printed if run.rung.printed else None, ours)))
    return Section(title, ("model", "mean, paper", "ours", "max, paper", "ours"), tuple(rows))


def _maybe_beside(paper: Figures | None, ours: Figures) -> tuple[str, ...]:
    if paper is not None:
        return _beside(paper, ours)
    return "", _millimetres(ours.mean), "", _millimetres(ours.max)


def _law_rows(run: RungRun) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for element in run.result.elastic:
        stiffness = [f"{1e-5 / c:.3g}" if c else "rigid" for c in element.coefficients]
        torque = "" if element.transition_torque is None else f"{element.transition_torque:.1f}"
        above = stiffness[1] if len(stiffness) > 1 else ""
        joint = element.element.partition(".")[0]
        rows.append((LABELS[run.rung.name], joint, torque, stiffness[0], above, element.verdict))
    return rows


def _on_search(run: RungRun) -> Iterable[str]:
    """How transition torques were found, and what the calibration warns of."""
    label, search = LABELS[run.rung.name], run.result.search
    if search is not None:
        proven = ", all combinations compared" if search.proven else ""
        yield f"{label[0].upper()}{label[1:]}: {search.fits} full fits{proven}."
    yield from (f"{label[0].upper()}{label[1:]}: {warning}." for warning in run.result.warnings)


def _gauge_sentences(run: RungRun) -> list[str]:
    """How our choice of parameters differs from the paper's."""
    dropped = run.result.gauge.dropped
    asked = len(run.result.gauge.kept) + len(dropped)
    if not dropped:
        return [f"All {asked} parameters that the paper identifies can be told apart."]
    return [f"{name} is {found.verdict}: it {found.reason}." for name, found in dropped.items()]
