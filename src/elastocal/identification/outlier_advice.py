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
    fitted, rejected, misfits = _counts(result)
    if left:
        yield (
            f"{_counted(rejected, 'outlier')} left out of the fit: {places(left, rejected)}; check these readings "
            "(line of sight, target); if they are right, the model lacks something (--elastic); residual statistics "
            "contain them"
        )
    if rejected >= int(MOST * fitted):
        yield (
            f"{rejected} of {fitted} rows do not fit the others, more than can be told from good ones: check target "
            "names, joint order and units, or let more give way (--elastic)"
        )
    elif kept:
        remedy = "repeat with --loss cauchy, which finds all outliers and leaves them out"
        if left:
            remedy = "measure them again, or leave them out of the file"
        yield (
            f"{_counted(misfits, 'row')} too far from the fit of the others: {places(kept, misfits)}; {remedy}; if "
            "readings and names are right, the model lacks something (--elastic)"
        )
    for hint in dict.fromkeys(outlier.hint for outlier in result.outliers if outlier.hint):
        named = [outlier for outlier in result.outliers if outlier.hint == hint]
        fits = "fits" if len(named) == 1 else "fit"
        yield f"{places(named)} {fits} {hint}, not the one named there: correct the {hint.split()[0]}'s name"


def _counts(result: CalibrationResult) -> tuple[int, int, int]:
    """How many rows there were to fit, how many outliers were left out, and how many were not."""
    if result.streamed is not None:  # of which the worst are listed only
        found = result.streamed
        return found.rows, found.rejected, found.outliers - found.rejected
    rejected = sum(outlier.rejected for outlier in result.outliers)
    return int((~result.errors.held_out).sum()), rejected, len(result.outliers) - rejected


def places(outliers: Sequence[Outlier], count: int = 0, most: int = LISTED) -> str:
    """Where outliers come from, file by file: "fit.csv rows 3, 17"; of `count` in all, if these are not all."""
    more = max(count, len(outliers)) - most
    rows: dict[str, list[int]] = {}
    for outlier in sorted(outliers[:most], key=lambda one: (one.file, one.row)):
        rows.setdefault(outlier.file, []).append(outlier.row)
    told = [
        f"{file} {'rows' if len(numbers) > 1 else 'row'} {', '.join(map(str, numbers))}".lstrip()
        for file, numbers in rows.items()
    ]
    return "; ".join(told) + (f" and {more} more" if more > 0 else "")


def _counted(count: int, noun: str) -> str:
    return f"1 {noun} is" if count == 1 else f"{count} {noun}s are"
