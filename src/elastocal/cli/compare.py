"""The command `elastocal compare`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Globs, Jobs, Json, Page, Seed, Tip, parse_names, require_data
from elastocal.errors import InputError


def compare(
    robot: Path,
    /,
    *data: Path,
    elastic: Globs,
    models: Globs | None = None,
    folds: Annotated[int, Parameter(validator=Number(gte=0))] = 10,
    identify: Globs | None = None,
    fix: Globs | None = None,
    tip: Tip = None,
    seed: Seed = 0,
    html: Page = None,
    json: Json = False,
    jobs: Jobs = None,
    scheduler: str | None = None,
) -> int:
    """The laws of compliance side by side on the same data, and which of them to believe.

    Args:
        robot: Nominal robot: a robot file (TOML) or a URDF.
        data: Measurements: CSV, Parquet, or the TOML descriptor of an instrument's own file.
        elastic: Elements that the laws are tried on: 2,3 for the joints of rows 2 and 3, 3.alpha for any element.
        models: Which models: rigid,linear,step,hinge,cubic, or some of them.
        folds: Parts of the cross-validation, which tells the error on poses that a fit has not seen; 0: without it.
        identify: Only parameters that match these patterns, as `*.theta` or `2.*`; all geometry if left out.
        fix: Parameters that match these patterns stay as they are.
        tip: Link where the chain of a URDF ends.
        seed: Of the division into parts.
        html: HTML file to write too.
        json: Print the result object and nothing else on standard output.
        jobs: Local processes; as many as there are cores if left out.
        scheduler: Instead, a Dask cluster, as tcp://HOST:PORT.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress, show
    from elastocal.cli.workers import workers
    from elastocal.comparison import MODELS
    from elastocal.comparison import compare as compare_models
    from elastocal.io import (
        comparison_json,
        data_hashes,
        load_measurements,
        load_robot,
        require_writable,
        source_files,
    )
    from elastocal.report import comparison_sections
    from elastocal.report.documents import write_sections

    require_data(data)
    elements = parse_names(elastic)
    named = [name for name in elements if ":" in name]
    if named:
        raise InputError(f"--elastic {','.join(elements)}: compare tries the laws itself: name elements only, as 2,3")
    inputs = (robot, *source_files(data))
    if html is not None:
        require_writable(html.parent, [html.name], inputs)
    nominal = load_robot(robot, tip)
    measured = load_measurements(data, nominal)
    with workers(jobs, scheduler, spread=folds > 0) as executor, progress("comparing") as calls:
        result = compare_models(
            nominal,
            measured,
            elastic=elements,
            models=parse_names(models) or MODELS,
            folds=folds or None,
            identify=identify,
            fix=fix or (),
            seed=seed,
            on_fit=calls.on_part,
            executor=executor,
        )
    sections = comparison_sections(result)
    if html is not None:
        write_sections(html, sections[0].title, sections, inputs)
        print(f"{html}", file=sys.stderr)
    if json:
        print(comparison_json(result, data_hashes(data)))
    else:
        show(sections)
    return DONE if result.recommended else FAILED
