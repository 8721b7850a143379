"""A study from its file to a summary: only what is not there yet is calibrated."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from functools import partial
from pathlib import Path

from elastocal.errors import WorkerLostError
from elastocal.identification.threads import one_thread
from elastocal.io.fleet_files import write_tables
from elastocal.io.study_files import read_study
from elastocal.io.study_parts import read_rows, repeats_done, require_study_folder, write_part, write_record
from elastocal.io.study_values import Setting, Study, cell_key
from elastocal.parallel import completed, in_order
from elastocal.studies.item import FAILED, Calibrations, Lot, Row
from elastocal.studies.simulation import Poses, planned_poses
from elastocal.studies.summary import StudySummary, summarised
from elastocal.studies.tables import study_table

TOGETHER = 10
"""Repeats that go together to a worker, and into one part of the results."""


def require_study(study: str | Path | Study, folder: str | Path) -> Study:
    """The study of a file, if its results can be written into a folder.

    Raises:
        InputError: with every fault of the file, or of the folder.
    """
    found = study if isinstance(study, Study) else read_study(study)
    require_study_folder(Path(folder), found)
    return found


def run_study(
    study: str | Path | Study,
    folder: str | Path,
    *,
    executor: Executor | None = None,
    on_item: Callable[[int, int], None] | None = None,
) -> StudySummary:
    """Simulate and calibrate all points of a study's grid, and say what came of it.

    The results are a Parquet data set, folder/parts, one row a calibration; each part is written whole, so that the
    run may be stopped at any time, and calibrations that are there are not repeated. More repeats and other points of
    the grid go on with what is there. Beside it is written summary.parquet, one row a point of the grid.

    Args:
        study: a study, or its file (TOML).
        folder: of the results.
        executor: where calibrations run; None: here, one after the other. The results are the same.
        on_item: called with the number of calibrations done and of all that are to be.

    Raises:
        InputError: with every fault of the file, before anything is written.
        ClusterLostError: the scheduler of a cluster is gone; what is done is kept.
    """
    folder = Path(folder)
    study = require_study(study, folder)
    write_record(folder, study)
    missing = list(_missing(study, repeats_done(folder)))
    total, done = sum(len(lot.repeats) for lot in missing), 0
    lots = list(_with_plans(study, missing, executor))
    for number, rows in completed(Calibrations.of(study), lots, executor, lost=_lost):
        write_part(folder, lots[number].setting, rows)
        done += len(rows)
        if on_item is not None:
            on_item(done, total)
    summary = summarised(study, read_rows(folder, study.settings, study.repeats))
    write_tables(folder, {"summary.parquet": study_table(summary)})
    return summary


def _missing(study: Study, done: Mapping[str, set[int]]) -> Iterator[Lot]:
    """Repeats that are not there yet."""
    for setting in study.settings:
        there = done.get(cell_key(setting), set())
        repeats = [repeat for repeat in range(study.repeats) if repeat not in there]
        for first in range(0, len(repeats), TOGETHER):
            yield Lot(setting, tuple(repeats[first : first + TOGETHER]))


def _with_plans(study: Study, lots: list[Lot], executor: Executor | None) -> Iterator[Lot]:
    """The lots with their poses, where these are planned: once for each point of the grid."""
    settings = list(dict.fromkeys(lot.setting for lot in lots if lot.setting.selection == "planned"))
    found = in_order(partial(_planned, study), settings, executor, chunk=1)
    plans = dict(zip(settings, found, strict=True))
    for lot in lots:
        yield Lot(lot.setting, lot.repeats, tuple(plans.get(lot.setting, ())))


@one_thread
def _planned(study: Study, setting: Setting) -> list[Poses]:
    return planned_poses(study, setting)


def _lost(lot: Lot, error: WorkerLostError) -> list[Row]:
    """The rows of a lot that cost its workers their lives."""
    head = {"cell": cell_key(lot.setting), **vars(lot.setting), "status": FAILED, "reason": str(error)}
    return [head | {"repeat": repeat} for repeat in lot.repeats]
