"""Sentences on outliers: which rows, what became of them, what to do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from elastocal.identification.outliers import MOST, Outlier
from elastocal.identification.result import CalibrationResult

LISTED = 10
"""Rows that a sentence lists."""


def on_outliers(result: CalibrationResult) -> Iterator[str]:
    """What to do about rows that do not fit the others."""
    left = [outlier for outlier in result.outliers if outlier.rejected]
    kept = [outlier for outlier in result.outliers if not outlier.rejected]
    fitted = int((~result.errors.held_out).sum())
    if left:
        yield (
            f"{_counted(left, 'outlier')} left out of the fit: {places(left)}; check these readings (line of sight, "
            "target); if they are right, the model lacks something (--elastic); residual statistics contain them"
        )
    if len(left) >= int(MOST * fitted):
        yield (
            f"{len(left)} of {fitted} rows do not fit the others, more than can be told from good ones: check target "
            "names, joint order and units, or let more give way (--elastic)"
        )
    elif kept:
        remedy = "repeat with --loss cauchy, which finds all outliers and leaves them out"
        if left:
            remedy = "measure them again, or leave them out of the file"
        yield (
            f"{_counted(kept, 'row')} too far from the fit of the others: {places(kept)}; {remedy}; if readings and "
            "names are right, the model lacks something (--elastic)"
        )
    for hint in dict.fromkeys(outlier.hint for outlier in result.outliers if outlier.hint):
        named = [outlier for outlier in result.outliers if outlier.hint == hint]
        fits = "fits" if len(named) == 1 else "fit"
        yield f"{places(named)} {fits} {hint}, not the one named there: correct the {hint.split()[0]}'s name"


def places(outliers: Sequence[Outlier], most: int = LISTED) -> str:
    """Where outliers come from, file by file: "fit.csv rows 3, 17"."""
    rows: dict[str, list[int]] = {}
    for outlier in sorted(outliers[:most], key=lambda one: (one.file, one.row)):
        rows.setdefault(outlier.file, []).append(outlier.row)
    told = [
        f"{file} {'rows' if len(numbers) > 1 else 'row'} {', '.join(map(str, numbers))}".lstrip()
        for file, numbers in rows.items()
    ]
    return "; ".join(told) + (f" and {len(outliers) - most} more" if len(outliers) > most else "")


def _counted(outliers: Sequence[Outlier], noun: str) -> str:
    return f"1 {noun} is" if len(outliers) == 1 else f"{len(outliers)} {noun}s are"
