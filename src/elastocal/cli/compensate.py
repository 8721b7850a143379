"""The command `elastocal compensate`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter

from elastocal.cli.options import Json, Output, Tip, parse_quantities
from elastocal.errors import InputError, unknown_name

if TYPE_CHECKING:
    from elastocal.compensation import Calibrated, Job, Rows, Summary
    from elastocal.io.compensation_files import RowWriter
    from elastocal.io.target_files import TargetFile
    from elastocal.robot import Frame, Robot

Signed = Annotated[str | None, Parameter(allow_leading_hyphen=True)]

TARGETS = Group("Targets", sort_key=1)


@Parameter(name="*", group=TARGETS)
@dataclass(frozen=True)
class TargetOptions:
    """What targets mean.

    Attributes:
        frame: Frame of positions and orientations: the robot's base, or the instrument's.
        station: Whose instrument, of a robot with stations.
        load: Payload of targets that name none in a column.
        target: TCP of targets that name none in a column: a target of the robot. The tool's origin if left out.
        tool: TCP in place of the robot's tool: x, y, z, roll, pitch and yaw in the flange frame, as
            0mm,0mm,150mm,0deg,0deg,90deg.
        start: Joint positions whose configuration is preferred, as 0deg,-90deg,90deg,0deg,90deg,0deg. Left out, the
            middle of the limits.
    """

    frame: Literal["base", "instrument"] = "base"
    station: str | None = None
    load: str | None = None
    target: str | None = None
    tool: Signed = None
    start: Signed = None


IN_BASE = TargetOptions()


def compensate(
    robot: Path,
    targets: Path,
    /,
    *,
    nominal: Path | None = None,
    tip: Tip = None,
    output: Output = None,
    json: Json = False,
    meant: TargetOptions = IN_BASE,
) -> int:
    """Joint commands that put the real, loaded robot on its targets.

    One row for each target, in its order. Where a pose cannot be reached, the position comes first, and the note says
    what is left; exit status 1.

    Args:
        robot: Calibrated robot: a robot file (TOML), such as a calibration writes, or a URDF.
        targets: Table (CSV or Parquet) with x, y, z, and qw, qx, qy, qz if the orientation matters; or q1 … qn: then
            the target is where the nominal robot would be. With both, searches start at q1 … qn. Also load, target and
            wrench_fx … wrench_mz, as in measurements.
        nominal: Robot as its controller knows it; tool and targets that its file leaves out are those of ROBOT. Left
            out, it is the nominal one of the calibration whose result.json lies beside ROBOT; else ROBOT without
            compliance and joint maps.
        tip: Link where the chain of a URDF ends.
        output: File for the rows, CSV or Parquet; standard output if left out, and the summary on standard error. A row
            has q1 … qn [rad or m], reached, correction (how far the command is moved), predicted errors before and
            after, fake_x … fake_qz (what to give, in the base frame, to a controller that keeps its nominal
            kinematics), and a note where one is needed.
        json: Print the result object, with up to 1000 rows, and nothing else on standard output.
        meant: What targets mean.
    """
    from elastocal.cli.main import DONE, FAILED
    from elastocal.compensation import Job
    from elastocal.io import load_robot, source_files
    from elastocal.io.target_files import TargetFile

    given = load_robot(robot, tip)
    require_names(given, meant)
    tool, start = chosen_tool(meant), chosen_start(given, meant.start)
    known, calibrated, warnings = what_was_calibrated(robot, given)
    if nominal is not None:
        known = load_robot(nominal, None if nominal.suffix.lower() == ".toml" else tip)
    job = Job.of(given, known, start, meant.frame, meant.station, tool)
    inputs = [robot, *source_files([targets]), *([nominal] if nominal else []), robot.parent / "result.json"]
    file = TargetFile(targets, job.robot, meant.load, meant.target, job.program)
    with destination(output, inputs, json) as writer:
        summary, rows = run(job, file, writer, calibrated, warnings, json)
    tell(summary, rows, output, json)
    return DONE if summary.reached == summary.targets else FAILED


def require_names(robot: Robot, meant: TargetOptions) -> None:
    """Check the names that options give.

    Raises:
        InputError: the robot does not have them, or a tool is given beside a target on another one.
    """
    faults = [
        f"--{kind}: {robot.name} has {unknown_name(kind, name, valid)}"
        for kind, name, valid in (
            ("load", meant.load, robot.loads),
            ("target", meant.target, robot.targets),
            ("station", meant.station, robot.stations),
        )
        if name is not None and name not in valid
    ]
    if meant.tool is not None and meant.target is not None:
        faults.append("--target is a point on the robot's tool, which --tool takes away: choose one")
    if faults:
        raise InputError(*faults)


def chosen_tool(meant: TargetOptions) -> Frame | None:
    """The tool's frame that an option gives."""
    from elastocal.robot import Frame

    if meant.tool is None:
        return None
    x, y, z, roll, pitch, yaw = parse_quantities("--tool", meant.tool, ["length"] * 3 + ["angle"] * 3, signed=True)
    return Frame((x, y, z), (roll, pitch, yaw), known=True)


def chosen_start(robot: Robot, text: str | None) -> tuple[float, ...] | None:
    """Preferred joint positions, SI."""
    if text is None:
        return None
    slides = [row.joint == "prismatic" for row in robot.joints][: robot.positions]
    slides += [False] * (robot.positions - len(slides))
    return parse_quantities("--start", text, ["length" if slide else "angle" for slide in slides], signed=True)


def what_was_calibrated(path: Path, robot: Robot) -> tuple[Robot | None, Calibrated | None, tuple[str, ...]]:
    """From the calibration that lies beside a robot file: its nominal robot, what it measured, and warnings."""
    from elastocal.compensation import Calibrated
    from elastocal.conversion import nominal_geometry
    from elastocal.io import load_result

    if path.suffix.lower() != ".toml" or not (path.parent / "result.json").is_file():
        return None, None, ()
    try:
        saved = load_result(path.parent, path.name)
    except InputError as error:
        return None, None, (f"{error.faults[0]}: its calibration is left out of account.",)
    return nominal_geometry(robot, saved.parameters), Calibrated.of(saved), ()


@contextmanager
def destination(output: Path | None, inputs: Sequence[Path], json: bool) -> Iterator[RowWriter | None]:
    """Where rows go: the file, or standard output, which gets all of them at the end or none."""
    import tempfile

    from elastocal.io.compensation_files import CsvWriter, compensation_file

    if output is not None:
        with compensation_file(output, inputs) as writer:
            yield writer
        return
    if json:
        yield None
        return
    with tempfile.TemporaryFile() as spool:
        yield CsvWriter(spool)
        spool.seek(0)
        while piece := spool.read(1 << 16):
            sys.stdout.write(piece.decode() if piece[-1] < 128 else (piece + spool.readline()).decode())
        sys.stdout.flush()


def run(
    job: Job,
    file: TargetFile,
    writer: RowWriter | None,
    calibrated: Calibrated | None,
    warnings: tuple[str, ...],
    json: bool,
) -> tuple[Summary, Rows | None]:
    """Compensate a file block by block; what it comes to, and its rows if they are few and asked for."""
    from elastocal.cli.show import progress
    from elastocal.compensation import Asked, Rows, Summary, Targets, compensated, tcp_warnings
    from elastocal.io.compensation_files import MOST_ROWS

    summary, asked, few = Summary(job.robot.name), [Asked()], []
    with progress("compensate") as calls:

        def blocks() -> Iterator[Targets]:
            for block, share in file.blocks():
                asked[0] = asked[0].with_targets(block)
                yield block
                if calls.on_part is not None:
                    calls.on_part(round(100 * share), 100)

        for rows in compensated(job, blocks()):
            if writer is not None:
                writer.write(rows)
            if json and summary.targets + len(rows) <= MOST_ROWS:
                few.append(rows)
            summary = summary.with_rows(rows)
    found = (*warnings, *(() if calibrated is None else tcp_warnings(job.robot, calibrated, asked[0])))
    whole = Rows.joined(few) if few and sum(map(len, few)) == summary.targets else None
    return replace(summary, warnings=found), whole


def tell(summary: Summary, rows: Rows | None, output: Path | None, json: bool) -> None:
    """The summary, where the table is not."""
    from rich.console import Console

    from elastocal.cli.show import show
    from elastocal.io.compensation_files import compensation_json
    from elastocal.report import print_sections
    from elastocal.report.compensation import compensation_sections

    if output is not None:
        print(f"{output}", file=sys.stderr)
    if json:
        print(compensation_json(summary, rows))
    elif output is not None:
        show(compensation_sections(summary))
    else:
        print_sections(compensation_sections(summary), Console(stderr=True, highlight=False))
