"""The command `elastocal reproduce`."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Json, Output, Seed

AtLeastTwo = Annotated[int, Parameter(validator=Number(gte=2))]
AtLeastOne = Annotated[int, Parameter(validator=Number(gte=1))]


def reproduce(
    *cases: str,
    non_negative: Annotated[bool, Parameter(negative=())] = False,
    population: AtLeastTwo = 30,
    generations: AtLeastOne = 20,
    seed: Seed = 0,
    output: Output = None,
    json: Json = False,
) -> int:
    """Run the two papers and print their tables beside ours.

    Every run simulates the measurements and calibrates from them: nothing is stored but the inputs. Those that the
    papers do not give are listed as chosen, with the reason, and so are the slips of the print.

    Args:
        cases: A-1, a-1 … a-5, B-1, b-1, b-2 (A-1 and a-1 are two cases; the dash may be left out), stiffness for all of
            them; rigid, linear, step-ga, step-exact, hinge of the HA006, nonlinear for all of these. All if left out.
        non_negative: Keep compliances from going below zero.
        population: Of the genetic algorithm: combinations of transition torques in a generation.
        generations: Of the genetic algorithm: how many.
        seed: Of the simulated HA006, its poses and noise, and of the genetic algorithm.
        output: Folder for the robots and measurements as files, to calibrate from them yourself.
        json: Print all figures (SI) and nothing else on standard output.
    """
    import json as js

    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress, show
    from elastocal.identification import GeneticSearch
    from elastocal.io import require_writable, write_files
    from elastocal.report.reproduction import reproduction_sections
    from elastocal.reproduction import figures, select
    from elastocal.reproduction import reproduce as run

    selection = select(cases)
    files = {} if output is None else _files(seed)
    if output is not None:
        require_writable(output, files)
    with progress("reproducing"):
        found = run(selection, non_negative=non_negative, genetic=GeneticSearch(population, generations), seed=seed)
    if output is not None:
        write_files(output, files)
        print(f"{output}: {', '.join(files)}", file=sys.stderr)
    if json:
        print(js.dumps(figures(found), indent=1, ensure_ascii=False, allow_nan=False))
    else:
        show(reproduction_sections(found))
    return DONE if found.converged else FAILED


def _files(seed: int) -> dict[str, str | bytes]:
    """The robots and measurements of both papers as files, by name."""
    from elastocal.io import measurements_to_csv, robot_to_toml
    from elastocal.reproduction import ha006, stiffness_analysis

    nominal = stiffness_analysis.nominal_robot()
    files: dict[str, str | bytes] = {"stiffness-nominal.toml": robot_to_toml(nominal)}
    for data in stiffness_analysis.DEFLECTING:
        files[f"stiffness-actual-{data}.toml"] = robot_to_toml(stiffness_analysis.actual_robot(data))
        files[f"stiffness-{data}.csv"] = measurements_to_csv(stiffness_analysis.measured(data), nominal)
    drawn = ha006.experiment(seed)
    return files | {
        "ha006-nominal.toml": robot_to_toml(drawn.nominal),
        "ha006-actual.toml": robot_to_toml(drawn.actual),
        "ha006-calibration.csv": measurements_to_csv(drawn.calibration, drawn.nominal),
        "ha006-evaluation.csv": measurements_to_csv(drawn.evaluation, drawn.nominal),
    }
