"""The command `elastocal calibrate`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import (
    Globs,
    Jobs,
    Json,
    Output,
    Paths,
    Seed,
    Tip,
    command_line,
    parse_elastic,
    parse_orders,
    parse_transition,
    require_data,
)

if TYPE_CHECKING:
    from elastocal.identification import CalibrationResult


def calibrate(
    robot: Path,
    /,
    *data: Path,
    held_out: Paths | None = None,
    holdout: float | None = None,
    identify: Globs | None = None,
    fix: Globs | None = None,
    elastic: str | None = None,
    transition: str = "exact",
    population: Annotated[int | None, Parameter(validator=Number(gte=2))] = None,
    generations: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    non_negative: Annotated[bool, Parameter(negative=())] = False,
    loss: Literal["linear", "huber", "cauchy"] = "linear",
    transmission: str = "0",
    prior: Annotated[bool, Parameter(negative=())] = False,
    bootstrap: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    tip: Tip = None,
    seed: Seed = 0,
    output: Output = None,
    json: Json = False,
    jobs: Jobs = None,
    scheduler: str | None = None,
) -> int:
    """Identify a robot's geometry and compliance from measurements.

    Args:
        robot: Nominal robot: a robot file (TOML) or a URDF.
        data: Measurements: CSV, Parquet, the TOML descriptor of an instrument's own file, or a folder of Parquet files.
            Parquet of more than 2 million rows is read part by part, so that it may be larger than memory.
        held_out: Measurements to judge the calibration by, which the fit does not see.
        holdout: Instead, the fraction of the rows to hold out, as 0.3; repeats of a pose stay together.
        identify: Only parameters that match these patterns, as `*.theta` or `2.*`; all geometry if left out. Frames
            that the robot file does not call known are always identified.
        fix: Parameters that match these patterns stay as they are.
        elastic: Elements that give way, and their laws: 2,3 for the joints of rows 2 and 3, 3.alpha for any element;
            2:step,3:hinge for a law other than linear (step, hinge, cubic).
        transition: How the transition torques of steps and hinges are found: exact, ga (genetic algorithm), or the
            torques themselves in N m, as 222,80, in the order of --elastic.
        population: Combinations in each generation of the genetic algorithm; 40 if left out.
        generations: How many generations there are; 50 if left out.
        non_negative: Keep compliances from becoming negative.
        loss: huber or cauchy: find outliers by a robust fit and leave them out; linear: only name them.
        transmission: Orders of the joints' maps of transmission error, as 60, or auto: as many as the data favour. What
            geometry and compliance leave of many robots is such an error, 10 to 30 waves a turn.
        prior: Identify all geometry at once, each number about its nominal value, with the tolerances of the robot file
            or such as the data favour: for few poses.
        bootstrap: Standard deviations and intervals by so many fits to data that might have been measured at the same
            poses, 200 or more, instead of by the linear covariance.
        tip: Link where the chain of a URDF ends.
        seed: Of the choice of rows to hold out, of the genetic algorithm, and of the bootstrap.
        output: Folder for robot.toml, result.json, residuals.csv and report.html, which opens offline.
        json: Print the result object and nothing else on standard output.
        jobs: Local processes for a bootstrap, a genetic algorithm, or data in parts; as many as there are cores if left
            out.
        scheduler: Instead, a Dask cluster, as tcp://HOST:PORT; its workers read the data from the same paths.
    """
    given = dict(locals())  # the options as they are given: the report tells the command
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress
    from elastocal.cli.workers import workers
    from elastocal.identification import calibrate as identify_robot
    from elastocal.io import (
        data_files,
        data_hashes,
        load_robot,
        open_measurements,
        require_result_folder,
        source_files,
        too_large,
    )

    fitted, held = data_files(data), data_files(held_out or ())
    require_data(fitted, held)
    laws = parse_elastic(elastic)
    search = parse_transition(transition, population, generations)
    orders = parse_orders(transmission)
    nominal = load_robot(robot, tip)
    inputs = (robot, *source_files((*fitted, *held)))
    if output is not None:
        require_result_folder(output, inputs)
    spread = bool(bootstrap) or transition == "ga" or too_large(fitted) or too_large(held)
    with workers(jobs, scheduler, spread=spread) as executor, progress("calibrating") as calls:
        measured = open_measurements(fitted, nominal, executor=executor, on_part=calls.on_part)
        rest = open_measurements(held, nominal, executor=executor, on_part=calls.on_part) if held else None
        result = identify_robot(
            nominal,
            measured,
            held_out=rest,
            holdout=holdout,
            identify=identify,
            fix=fix or (),
            elastic=laws,
            transition=search,
            non_negative=non_negative,
            loss=loss,
            transmission=orders,
            prior=prior,
            bootstrap=bootstrap,
            seed=seed,
            on_step=calls.on_step,
            on_generation=calls.on_part,
            on_sample=calls.on_part,
            executor=executor,
        )
    files = {"robot": str(robot), "data": [*map(str, data)], "held_out": [*map(str, held_out or ())]}
    result = replace(result, settings={"command": _command(given), **files, **result.settings})
    _tell(result, data_hashes((*fitted, *held)), output, inputs, json)
    return DONE if result.status == "converged" else FAILED


def _command(given: Mapping[str, Any]) -> str:
    """The command line that makes the result again: all options that are not as usual and change it."""
    options = {
        name: given[name]
        for name, usual in signature(calibrate).parameters.items()
        if name not in ("robot", "data", "json", "jobs", "scheduler") and given[name] != usual.default
    }
    return command_line("calibrate", (given["robot"], *given["data"]), **options)


def _tell(
    result: CalibrationResult, hashes: Sequence[str], output: Path | None, inputs: Sequence[Path], json: bool
) -> None:
    """Save the result if there is a place for it, and print it."""
    from elastocal.cli.show import show
    from elastocal.io import result_json, save_result
    from elastocal.report import calibration_sections
    from elastocal.report.documents import calibration_report

    if output is not None:
        written = save_result(result, output, hashes, inputs, calibration_report)
        print(f"{output}: {', '.join(written)}", file=sys.stderr)
    if json:
        print(result_json(result, hashes))
    else:
        show(calibration_sections(result))
