"""The command `elastocal fleet`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from elastocal.cli.options import Jobs, Json
from elastocal.cli.workers import workers


def fleet(
    manifest: Path,
    /,
    *,
    output: Annotated[Path, Parameter(name=("--output", "-o"))],
    jobs: Jobs = None,
    scheduler: str | None = None,
    json: Json = False,
) -> int:
    """Calibrate many robots: a folder for each, who differs from its siblings, who drifted.

    A row that fails stops no other. Stopped at any time, the same command goes on where it was: rows whose inputs
    (files, options, version) are those of the result that is there are not run again.

    Args:
        manifest: What to calibrate: a CSV, or a TOML with tables [[calibration]]. Columns: serial, date, robot, data;
            and options of calibrate, where they are needed: held_out, holdout, identify, fix, elastic, transition,
            non_negative, loss, transmission, prior, bootstrap, tip, seed. Files are relative to it; several in a cell
            have ; between them. A row that fails stops no other; run again, only rows whose inputs changed are run.
        output: Folder for the results: SERIAL/DATE/ as calibrate -o writes it, summary.parquet, parameters.parquet and
            summary.html.
        jobs: Local processes; as many as there are cores if left out.
        scheduler: Instead, the scheduler of a Dask cluster, as tcp://192.168.0.10:8786; ELASTOCAL_SCHEDULER in the
            environment if left out.
        json: Print the summary object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress, show
    from elastocal.cli.stopping import told_when_stopped
    from elastocal.fleet import fleet_json, require_fleet, run_fleet
    from elastocal.report.documents import write_sections
    from elastocal.report.fleet import fleet_sections

    require_fleet(manifest, output)
    with (
        told_when_stopped("rows", output) as count,
        workers(jobs, scheduler, "elastocal.fleet") as executor,
        progress("calibrating") as calls,
    ):
        summary = run_fleet(manifest, output, executor=executor, on_row=count.also(calls.on_part))
    write_sections(output / "summary.html", f"Fleet: {manifest.stem}", fleet_sections(summary, most=None))
    print(f"{output}: summary.parquet, parameters.parquet, summary.html", file=sys.stderr)
    if json:
        print(fleet_json(summary))
    else:
        show(fleet_sections(summary))
    return FAILED if summary.failed else DONE
