"""The report on a calibration: all its sections, with figures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace

from elastocal.errors import EquilibriumError
from elastocal.figures.accuracy import accuracy_panels, workspace_uncertainty
from elastocal.figures.compliance import law_panels, search_panels
from elastocal.figures.errors import error_panels, vector_panels
from elastocal.figures.maps import map_panels
from elastocal.figures.rows import MOST_ROWS, Rows, rows_of
from elastocal.identification import SavedResult, Statistics
from elastocal.report.left_over import joint_section, pattern_section, torque_section
from elastocal.report.maps import maps_section
from elastocal.report.parameters import (
    correlation_section,
    deviation_section,
    dropped_section,
    observability_section,
    parameters_section,
)
from elastocal.report.precision import uncertainty_sections
from elastocal.report.section import Kind, Section, Verdict
from elastocal.report.sections import advice_sections, elastic_section, error_section, outlier_section

AS_GOOD = 1.3
"""Unseen poses are predicted as well as fitted ones if their mean error is at most so many times as large."""

MOST_OUTLIERS = 200


def report_sections(result: SavedResult) -> list[Section]:
    """All sections of the report on a calibration, the verdict first.

    Args:
        result: as it was saved; of one without rows, what needs them is left out.
    """
    rows = _rows(result)
    sections = [summary_section(result), *advice_sections(result.warnings)]
    if rows is not None:
        sections += [errors_section(result), *_vectors(result, rows)]
        sections += [pattern_section(result, rows), joint_section(result, rows), torque_section(result, rows)]
    sections += [*_compliance(result, rows), *_maps(result, rows)]
    sections += [parameters_section(result), deviation_section(result), dropped_section(result)]
    sections += [correlation_section(result), observability_section(result), outliers_section(result)]
    if rows is not None:
        sections += _accuracy(result, rows)
    sections += advice_sections((), result.notes)
    return [section for section in sections if _says_something(section)] + [origin_section(result)]


def _says_something(section: Section) -> bool:
    return bool(section.rows or section.sentences or section.panels or section.facts or section.verdict)


def _rows(result: SavedResult) -> Rows | None:
    """The rows, if they were saved and the robot settles at all of them."""
    if result.errors is None:
        return None
    try:
        return rows_of(result)
    except EquilibriumError:
        return None


def summary_section(result: SavedResult) -> Section:
    """Status and verdict, what calibration gains, and the statistics of all errors."""
    status = result.status.replace("_", " ")
    kind: Kind = "problem" if result.status != "converged" else "caution" if result.warnings else "good"
    warned = len(result.warnings)
    told = f" {'A warning is' if warned == 1 else f'{warned} warnings are'} below." if warned else ""
    verdict = Verdict(kind, f"{result.verdict}{told}")
    table = error_section("Verdict", result.residuals, "")
    facts = (("Status", status), *_gains(result))
    return replace(table, sentences=(), verdict=verdict, facts=facts)


def _gains(result: SavedResult) -> Iterator[tuple[str, str]]:
    found = result.residuals
    for before, after, where in (
        ("held_out_nominal", "held_out", "held-out"),
        ("nominal", "cross_validated", "to expect"),
        ("nominal", "calibrated", "fitted"),
    ):
        if before in found and after in found:
            yield f"Mean error, {where}", _change(found[before], found[after], "mean")
            yield f"Largest error, {where}", _change(found[before], found[after], "max")
            break
    if "calibrated" in found:
        if "held_out" in found:
            yield "Rows fitted + held out", f"{found['calibrated'].n} + {found['held_out'].n}"
        else:
            yield "Rows", str(found["calibrated"].n)
    maps = {f"{e}.{key}" for e, error in result.robot.transmission.items() for key in error.coefficients}
    others = sum(name not in maps for name in result.names)
    of_maps = len(result.names) - others
    yield "Parameters identified", f"{others} + {of_maps} of maps" if of_maps else str(others)
    if math.isfinite(result.chi2_reduced):
        yield "Reduced χ²", f"{result.chi2_reduced:.2f}"


def _change(before: Statistics, after: Statistics, which: str) -> str:
    return f"{1e3 * getattr(before, which):.3g} → {1e3 * getattr(after, which):.3g} mm"


def errors_section(result: SavedResult) -> Section:
    """Errors before and after as histogram and cumulative curve, held-out rows beside fitted ones."""
    return Section(
        "Errors before and after",
        prose=(
            "Distance between measured and predicted position, of every row; before calibration the frames of base and "
            "tool are fitted already, so that the gain is the robot's alone."
        ),
        verdict=_unseen(result),
        panels=tuple(error_panels(result)),
    )


def _unseen(result: SavedResult) -> Verdict | None:
    found = result.residuals
    name = "held_out" if "held_out" in found else "cross_validated"
    if name not in found or "calibrated" not in found or not found["calibrated"].mean > 0.0:
        return None
    ratio = found[name].mean / found["calibrated"].mean
    rows = "Held-out rows" if name == "held_out" else "Unseen poses, each left out of the fit in turn,"
    if ratio <= AS_GOOD:
        return Verdict(
            "good", f"{rows} are predicted about as well as fitted ones ({ratio:.2f} times their mean error)."
        )
    return Verdict(
        "caution",
        f"{rows} are predicted worse than fitted ones ({ratio:.2f} times their mean error): the fit follows its own "
        "rows; measure more poses, or identify less.",
    )


def _vectors(result: SavedResult, rows: Rows) -> list[Section]:
    panels = vector_panels(result, rows)
    if not panels:
        return []
    told = (
        "Errors at the measured points, drawn longer by the number named, with the identified robot at the pose in "
        "the middle of all; base frame. Neighbouring vectors that point the same way are a systematic error. Choose "
        "what is shown at the upper left; drag to turn."
    )
    note = f"Figures are of {len(rows)} rows, evenly chosen of {rows.total}." if rows.total > MOST_ROWS else ""
    return [Section("Error vectors", prose=told, panels=tuple(panels), sentences=(note,) if note else ())]


def _compliance(result: SavedResult, rows: Rows | None) -> list[Section]:
    if not result.elastic:
        return []
    told = (
        "What each elastic element gives under load. Points are the rows: the law's deflection and what is left of "
        "the row, taken as a motion of this element alone. Where their means leave the band, the law does not hold."
    )
    panels = () if rows is None else tuple(law_panels(result, rows))
    found = [replace(elastic_section(result), title="Torque and deflection", prose=told, panels=panels)]
    searched = tuple(search_panels(result))
    if searched:
        told = (
            "How much worse other transition torques fit, all else at its best beside each: the root of the rise of "
            "chi-square. Within the stripe, below the dotted line, lies the torque with 95 % confidence."
        )
        method = result.search.method if result.search else ""
        proven = "All allowed combinations were compared." if result.search and result.search.proven else ""
        fits = f"{result.search.fits} combinations were fitted in full." if result.search and method != "given" else ""
        sentences = tuple(sentence for sentence in (proven, fits) if sentence)
        found.append(Section("Search for transition torques", prose=told, panels=searched, sentences=sentences))
    return found


def _maps(result: SavedResult, rows: Rows | None) -> list[Section]:
    if rows is None or not any(error.sin for error in result.robot.transmission.values()):
        return []
    told = (
        "The drives' transmission error, a function of each joint's own position. Bars at the bottom are rows "
        "measured; where there are none the map fades out and its band opens."
    )
    panels = tuple(map_panels(result, rows))
    if result.maps is None:
        return [Section("Joint maps", prose=told, panels=panels)]
    return [replace(maps_section(result), prose=told, panels=panels)]


def outliers_section(result: SavedResult) -> Section:
    """Rows that do not fit the others, or that there are none."""
    if not result.outliers:
        return Section("Outliers", verdict=Verdict("good", "No row stands out from the others."))
    left_out = sum(outlier.rejected for outlier in result.outliers)
    some = "A row does" if len(result.outliers) == 1 else f"{len(result.outliers)} rows do"
    told = f"{some} not fit the others; {left_out or 'none'} of them {'was' if left_out < 2 else 'were'} left out."
    hint = "" if left_out == len(result.outliers) else " Look at them, or leave them out with --loss cauchy."
    section = outlier_section(result, MOST_OUTLIERS)
    hints = tuple(f"{o.file or 'data'} row {o.row} fits {o.hint}." for o in result.outliers if o.hint)
    return replace(
        section, sentences=(*hints, *section.sentences), verdict=Verdict("caution", told + hint), sortable=True
    )


def _accuracy(result: SavedResult, rows: Rows) -> list[Section]:
    if not result.names or result.status == "not_identifiable":
        return []
    try:
        found = workspace_uncertainty(result)
    except EquilibriumError:
        return []
    table = uncertainty_sections(result.robot, found)[0]
    told = (
        f"Standard deviation of the predicted position at {len(found.data)} random poses within the joint limits, from "
        "what the parameters leave open and what the model leaves out. Dots were measured: far from them the "
        "prediction rests on the model alone."
    )
    panels = tuple(accuracy_panels(result, rows, found))
    return [replace(table, title="Accuracy over the workspace", prose=told, panels=panels)]


def origin_section(result: SavedResult) -> Section:
    """Where the result comes from, so that it can be made again: command, files with their hashes, settings."""
    settings = dict(result.settings)
    command = settings.pop("command", "")
    files = [str(name) for kind in ("data", "held_out") for name in _listed(settings.get(kind))]
    hashes = [*result.data_sha256, *[""] * len(files)]
    rows = [("robot", str(settings.pop("robot", "")), "")] if "robot" in settings else []
    rows += [("data", name, digest) for name, digest in zip(files, hashes, strict=False)]
    if not files:
        rows += [("data", "", digest) for digest in result.data_sha256]
    for kind in ("data", "held_out"):
        settings.pop(kind, None)
    asked = [
        ("setting", name, value if isinstance(value, str) else json.dumps(value, ensure_ascii=False))
        for name, value in settings.items()
    ]
    took = f"Made by elastocal {result.version}."
    prose = "What led to this result: with the same files, whose SHA-256 are listed, the command makes it again."
    table = (*rows, *asked)
    return Section("How to make it again", ("what", "name", "value"), table, (took,), prose=prose, code=str(command))


def _written(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _listed(value: object) -> list[object]:
    return list(value) if isinstance(value, (list, tuple)) else []
