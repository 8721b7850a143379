"""The command `elastocal calibrate`."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import (
    Globs,
    Json,
    Output,
    Paths,
    Seed,
    Tip,
    parse_elastic,
    parse_orders,
    parse_transition,
    require_data,
)


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
) -> int:
    """Identify a robot's geometry and compliance from measurements.

    Args:
        robot: Nominal robot: a robot file (TOML) or a URDF.
        data: Measurements: CSV, Parquet, or the TOML descriptor of an instrument's own file.
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
        output: Folder for robot.toml, result.json and residuals.csv.
        json: Print the result object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress, show
    from elastocal.identification import calibrate as identify_robot
    from elastocal.io import (
        data_hashes,
        load_measurements,
        load_robot,
        require_result_folder,
        result_json,
        save_result,
        source_files,
    )
    from elastocal.report import calibration_sections

    require_data(data, held_out or ())
    laws = parse_elastic(elastic)
    search = parse_transition(transition, population, generations)
    orders = parse_orders(transmission)
    nominal = load_robot(robot, tip)
    measured = load_measurements(data, nominal)
    rest = load_measurements(held_out, nominal) if held_out else None
    inputs = (robot, *source_files((*data, *(held_out or ()))))
    if output is not None:
        require_result_folder(output, inputs)
    with progress("calibrating") as calls:
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
        )
    files = {"robot": str(robot), "data": [*map(str, data)], "held_out": [*map(str, held_out or ())]}
    result = replace(result, settings={**files, **result.settings})
    hashes = data_hashes((*data, *(held_out or ())))
    if output is not None:
        written = save_result(result, output, hashes, inputs)
        print(f"{output}: {', '.join(written)}", file=sys.stderr)
    if json:
        print(result_json(result, hashes))
    else:
        show(calibration_sections(result))
    return DONE if result.status == "converged" else FAILED
