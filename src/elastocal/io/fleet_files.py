"""A fleet's folder: one folder for each calibration, written whole, and tables of all of them."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any

import polars as pl

from elastocal.errors import InputError
from elastocal.io.files import require_writable, sha256, write_files
from elastocal.io.manifests import FleetRow
from elastocal.io.results import dump

RECORD = "fleet.json"
"""Beside the files of `calibrate -o`: what the result was made of."""

SUMMARIES = ("summary.parquet", "parameters.parquet", "summary.html")


def record_of(row: FleetRow) -> dict[str, Any]:
    """What a result depends on: files by their hashes, options, version."""
    hashes = {str(path): sha256(path) for path in dict.fromkeys(row.inputs)}
    return {
        "format": "elastocal-fleet-row/1",
        "serial": row.serial,
        "date": row.date,
        "robot_sha256": hashes[str(row.robot)],
        "data_sha256": [hashes[str(path)] for path in row.inputs[1:]],
        "held_out": len(row.held_out),
        "tip": row.tip,
        "options": dict(row.words),
        "version": version("elastocal"),
    }


def is_done(folder: Path, record: Mapping[str, Any]) -> bool:
    """Whether a folder holds the result of these inputs."""
    try:
        found = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return bool(found == json.loads(dump(record)))


def require_fleet_folder(folder: Path, rows: Sequence[FleetRow], manifest: Path) -> None:
    """Check that the results of all rows can be written, before the work.

    Raises:
        InputError: with every fault: a place that is none of a fleet's results, an input among what would be replaced.
    """
    require_writable(folder, SUMMARIES, (manifest, *(path for row in rows for path in row.inputs)))
    faults = list(_place_faults(folder, rows))
    if faults:
        raise InputError(*dict.fromkeys(faults))


def _place_faults(folder: Path, rows: Sequence[FleetRow]) -> Iterator[str]:
    places = {(folder / row.folder).resolve(): row for row in rows}
    for place, row in places.items():
        if place.exists() and not (place / RECORD).is_file():
            yield f"{folder / row.folder} is there, but is no result of a fleet: choose another folder (-o DIR)"
    for row in rows:
        for path in row.inputs:
            inside = [parent for parent in path.resolve().parents if parent in places]
            if inside:
                yield f"{path} is an input, and lies where results go: choose another folder (-o DIR)"


def write_row(folder: Path, files: Mapping[str, bytes], record: Mapping[str, Any]) -> None:
    """Write the folder of one calibration whole: beside its place first, then renamed.

    What else lies in a folder that is replaced stays there.

    Raises:
        InputError: it cannot be written.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        for left in folder.parent.glob(f".{folder.name}.*.new"):  # by a command that was killed
            shutil.rmtree(left, ignore_errors=True)
        temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}.", suffix=".new"))
        for name, content in files.items():
            (temporary / name).write_bytes(content)
        (temporary / RECORD).write_text(dump(record) + "\n", encoding="utf-8")
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o777 & ~umask)
        _put_in_place(temporary, folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written to: {(error.strerror or str(error)).lower()}") from None


def _put_in_place(temporary: Path, folder: Path) -> None:
    if folder.exists():
        old = temporary.with_suffix(".old.new")  # swept away like an unfinished one, should this be the end
        folder.rename(old)
        temporary.rename(folder)
        for path in old.iterdir():
            if not (folder / path.name).exists() and path.name != "report.html":  # which tells of another result
                with suppress(OSError):
                    path.rename(folder / path.name)
        shutil.rmtree(old, ignore_errors=True)
    else:
        temporary.rename(folder)


def write_tables(folder: Path, tables: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Write tables, each a row a line, as Parquet files, all or none.

    Raises:
        InputError: the folder cannot be written to.
    """
    write_files(folder, {name: parquet_bytes(rows) for name, rows in tables.items()})


def parquet_bytes(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Rows, which have the same keys, as a Parquet file."""
    buffer = BytesIO()
    pl.DataFrame(list(rows), infer_schema_length=None).write_parquet(buffer)
    return buffer.getvalue()
