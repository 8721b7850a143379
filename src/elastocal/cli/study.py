"""The command `elastocal study`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from elastocal.cli.options import Jobs, Json
from elastocal.cli.workers import workers


def study(
    study: Path,
    /,
    *,
    output: Annotated[Path, Parameter(name=("--output", "-o"))],
    jobs: Jobs = None,
    scheduler: str | None = None,
    json: Json = False,
) -> int:
    """Many simulated calibrations over a grid: errors against poses, coverage, whether the right law is found.

    Stopped at any time, the same command goes on where it was: calibrations that are there are not repeated, and more
    repeats or points of the grid add to them. The results are a Parquet data set, DIR/parts, one row a calibration.

    Args:
        study: What to simulate: a TOML with [actual], [setting] and [grid], as those in studies/ of the project,
            explained in docs/studies.md. Run again, it goes on where it was; more repeats or another grid add to it.
        output: Folder for the results: parts/, study.json, summary.parquet and summary.html.
        jobs: Local processes; as many as there are cores if left out.
        scheduler: Instead, the scheduler of a Dask cluster, as tcp://192.168.0.10:8786; ELASTOCAL_SCHEDULER in the
            environment if left out.
        json: Print the summary object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress, show
    from elastocal.cli.stopping import told_when_stopped
    from elastocal.report.documents import write_sections
    from elastocal.report.study import study_sections
    from elastocal.studies import require_study, run_study, study_json

    wanted = require_study(study, output)
    with (
        told_when_stopped("calibrations", output) as count,
        workers(jobs, scheduler, "elastocal.studies") as executor,
        progress("calibrating") as calls,
    ):
        summary = run_study(wanted, output, executor=executor, on_item=count.also(calls.on_part))
    write_sections(output / "summary.html", f"Study: {wanted.name}", study_sections(summary))
    print(f"{output}: parts, summary.parquet, summary.html", file=sys.stderr)
    if json:
        print(study_json(summary))
    else:
        show(study_sections(summary))
    return DONE if summary.sound else FAILED
