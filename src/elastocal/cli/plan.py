"""The command `elastocal plan`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Globs, Json, Output, Seed, Tip, parse_elastic, parse_transition
from elastocal.cli.planning import (
    AroundOptions,
    CandidateOptions,
    MeasuredOptions,
    chosen_candidates,
    chosen_request,
    chosen_surroundings,
    chosen_workspace,
    workspace_file,
)
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.design import Plan

POSITIONS, RANDOM, FREE = MeasuredOptions(), CandidateOptions(), AroundOptions()


def plan(
    robot: Path,
    /,
    *,
    poses: Annotated[int, Parameter(validator=Number(gte=1))],
    elastic: str | None = None,
    criterion: Literal["O1", "O2", "O3", "O4", "O5", "accuracy"] = "O1",
    transition: str = "exact",
    identify: Globs | None = None,
    fix: Globs | None = None,
    tip: Tip = None,
    seed: Seed = 0,
    output: Output = None,
    json: Json = False,
    reading: MeasuredOptions = POSITIONS,
    offered: CandidateOptions = RANDOM,
    around: AroundOptions = FREE,
) -> int:
    """Which poses to measure: a table for calibrate, to be filled in.

    Args:
        robot: Nominal robot: a robot file (TOML) or a URDF. Compliances in it are taken into account.
        poses: How many poses to choose.
        elastic: Elements that give way, and their laws, as for calibrate: 2,3 or 2:step,3:hinge.
        criterion: What is best: an observability index, O1 (determinant) to O5, or accuracy: the least standard
            deviation of the predicted position over the workspace.
        transition: Torques of steps and hinges in N m, as 222,80, if calibrate will be given them; else it searches for
            them, and the plan spreads the loads.
        identify: Only parameters that match these patterns, as for calibrate.
        fix: Parameters that match these patterns are not identified.
        tip: Link where the chain of a URDF ends.
        seed: Of random candidates and of the choice.
        output: CSV file for the poses; standard output if left out, and the report on standard error.
        json: Print the result object and nothing else on standard output.
        reading: How they will be measured.
        offered: Which poses there are to choose from.
        around: What they must keep clear of.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.cli.show import progress
    from elastocal.design import choose
    from elastocal.io import load_measurements, load_robot, source_files

    nominal = load_robot(robot, tip)
    request = chosen_request(nominal, poses, criterion, seed, reading, offered)
    request = replace(
        request,
        elastic=parse_elastic(elastic),
        transition=parse_transition(transition),
        identify=identify,
        fix=tuple(fix or ()),
    )
    files = [offered.candidates, workspace_file(offered)]
    inputs = [robot, *source_files([*(reading.measured or ()), *(path for path in files if path is not None)])]
    _require_place(output, inputs)
    surroundings = chosen_surroundings(around)
    with progress("planning"):
        candidates = chosen_candidates(nominal, poses, seed, surroundings, reading, offered)
        measured = load_measurements(reading.measured, nominal) if reading.measured else None
        workspace = chosen_workspace(nominal, offered, surroundings, candidates, seed)
        found = choose(nominal, candidates, request, measured, workspace)
    _write(found, output, inputs, json)
    return DONE if found.status == "planned" else FAILED


def _require_place(output: Path | None, inputs: Sequence[Path]) -> None:
    """Check that the table can be written, before the work.

    Raises:
        InputError: it is an input, or is to be no CSV.
    """
    from elastocal.io import require_writable

    if output is None:
        return
    if output.suffix.lower() in (".parquet", ".pq", ".toml"):
        raise InputError(f"-o {output}: expected a CSV file, as {output.with_suffix('.csv')}, found {output.suffix}")
    require_writable(output.parent, [output.name], inputs)


def _write(found: Plan, output: Path | None, inputs: Sequence[Path], json: bool) -> None:
    """The table to its place, and the report to where the table is not."""
    from rich.console import Console

    from elastocal.cli.show import show
    from elastocal.io import plan_csv, plan_json, write_files
    from elastocal.report import plan_sections, print_sections

    table = plan_csv(found)
    if output is not None:
        write_files(output.parent, {output.name: table}, inputs)
        print(f"{output}", file=sys.stderr)
    if json:
        print(plan_json(found))
    elif output is not None:
        show(plan_sections(found))
    else:
        print(table.decode(), end="", flush=True)
        print_sections(plan_sections(found), Console(stderr=True, highlight=False))
