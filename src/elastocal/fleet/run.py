"""A fleet from manifest to summary: only what is not there yet is calibrated."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from elastocal.errors import InputError, WorkerLostError
from elastocal.fleet.summary import FleetSummary, summarised
from elastocal.fleet.tables import fleet_tables
from elastocal.fleet.task import FAILED, FleetFiles, FleetOutcome, FleetTask, calibrated, prepared
from elastocal.io import load_result
from elastocal.io.fleet_files import is_done, record_of, require_fleet_folder, write_row, write_tables
from elastocal.io.manifests import FleetRow, read_manifest
from elastocal.parallel import completed


def require_fleet(manifest: Path, folder: Path) -> tuple[FleetRow, ...]:
    """The rows of a manifest, if they can be calibrated into a folder.

    Raises:
        InputError: with every fault of the manifest, or of the folder.
    """
    rows = read_manifest(manifest)
    require_fleet_folder(folder, rows, manifest)
    return rows


def run_fleet(
    manifest: str | Path,
    folder: str | Path,
    *,
    executor: Executor | None = None,
    on_row: Callable[[int, int], None] | None = None,
) -> FleetSummary:
    """Calibrate every row of a manifest, and say what the robots have in common and what not.

    Each row gets a folder, as `calibrate -o` writes it, below `folder`: SERIAL/DATE. It is written whole, so that the
    run may be stopped at any time; rows whose folder holds the result of the same inputs are not run again. Beside
    them are written summary.parquet and parameters.parquet.

    Args:
        manifest: CSV or TOML: serial, date, robot, data, and options of `calibrate`.
        folder: of the results.
        executor: where calibrations run; None: here, one after the other. The results are the same.
        on_row: called with the number of rows done and of all that are to be.

    Raises:
        InputError: with every fault of the manifest, before anything is written.
        ClusterLostError: the scheduler of a cluster is gone; what is done is kept.
    """
    manifest, folder = Path(manifest), Path(folder)
    rows = require_fleet(manifest, folder)
    records = [record_of(row) for row in rows]
    pending = [index for index, row in enumerate(rows) if not is_done(folder / row.folder, records[index])]
    failed: dict[int, str] = {}
    for done, (index, reason) in enumerate(_calibrations(rows, records, pending, folder, executor), start=1):
        if reason:
            failed[index] = reason
        if on_row is not None:
            on_row(done, len(pending))
    anew = set(pending)
    outcomes = [
        FleetOutcome(row, FAILED, failed[index]) if index in failed else _read(row, folder, index not in anew)
        for index, row in enumerate(rows)
    ]
    summary = summarised(outcomes, [record["robot_sha256"] for record in records], executor)
    write_tables(folder, fleet_tables(summary))
    return summary


def _calibrations(
    rows: Sequence[FleetRow],
    records: Sequence[Mapping[str, Any]],
    pending: Sequence[int],
    folder: Path,
    executor: Executor | None,
) -> Iterator[tuple[int, str]]:
    """Each pending row as it is done, its result written, with the reason if it failed."""
    unreadable: list[tuple[int, str]] = []

    def tasks() -> Iterator[FleetTask]:
        for index in pending:
            try:
                yield prepared(index, rows[index], tuple(records[index]["data_sha256"]))
            except InputError as error:
                unreadable.append((index, str(error)))

    def lost(task: FleetTask, error: WorkerLostError) -> FleetFiles:
        return FleetFiles(task.index, {}, str(error))

    for _, found in completed(calibrated, tasks(), executor, lost=lost):
        if not found.reason:
            write_row(folder / rows[found.index].folder, found.contents, records[found.index])
        yield found.index, found.reason
    yield from unreadable


def _read(row: FleetRow, folder: Path, kept: bool) -> FleetOutcome:
    """What a row's folder says."""
    try:
        result = load_result(folder / row.folder, rows=False)
    except InputError as error:
        return FleetOutcome(row, FAILED, str(error), kept)
    return FleetOutcome(row, result.status, "", kept, result)
