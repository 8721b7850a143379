"""The command `elastocal simulate`."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Globs, Output, Seed, Tip, parse_names, parse_quantities
from elastocal.errors import InputError, unknown_name

if TYPE_CHECKING:
    import numpy as np

    from elastocal.measurements import Measurements
    from elastocal.robot import Robot
    from elastocal.simulation import Instrument, Region

Signed = Annotated[str | None, Parameter(allow_leading_hyphen=True)]

ACTUAL = Group(
    "Actual robot",
    help="Its base, tool and targets are where its file says, known or not; those that it leaves out are the identity.",
    sort_key=1,
)
POSES = Group(
    "Poses", help="At random within ROBOT's joint limits, ±180° or ±0.5 m where a joint has none.", sort_key=2
)
INSTRUMENT = Group(
    "Instrument",
    help="Here and above, a length is a number with a unit (m, mm, cm, um, in), and so is an angle (rad, deg, mrad); a "
    "number alone is in m or rad.",
    sort_key=3,
)


@Parameter(name="*", group=ACTUAL)
@dataclass(frozen=True)
class ActualOptions:
    """Which robot is measured.

    Attributes:
        actual: Its robot file, with its own geometry, payloads, transmission errors and compliance: any law, and
            harmonic-drive, which only an actual robot may have. Left out, it is ROBOT.
        geometry_error: Instead, ROBOT with normal random errors on its rows: standard deviations of lengths and of
            angles, as 0.5mm,0.5mrad. Frames that its file leaves out are drawn too: an instrument beside the robot, a
            target beside the flange.
        write_actual: Robot file for the actual robot so drawn, all frames known. Add compliance there, and give it as
            --actual.
    """

    actual: Path | None = None
    geometry_error: str | None = None
    write_actual: Path | None = None


@Parameter(name="*", group=POSES)
@dataclass(frozen=True)
class PoseOptions:
    """Where it is measured.

    Attributes:
        at: Instead of random poses, those of a table, as of plan or compensate, with the targets and payloads it names.
        load: Payloads, as heavy or none,heavy; poses are shared out among them. No payload if left out.
        target: Targets, among which poses are shared out likewise; all of ROBOT if left out.
        station: Station that the instrument stands at.
        floor: Least height of the target over the origin of the robot's base, along z of the base frame, as 0.2m.
        box: Where the target must be in the instrument's frame: lowest and highest x, y and z, as
            0.5m,3m,-1m,1m,-0.5m,1.5m.
        range: Least and greatest distance of the target from the instrument, as 1m,5m.
        cone: What the instrument sees: half angle, as 20deg, about the direction from its origin to the middle of where
            the target goes within the joint limits.
    """

    at: Path | None = None
    load: Globs | None = None
    target: Globs | None = None
    station: str | None = None
    floor: Signed = None
    box: Signed = None
    range: str | None = None
    cone: str | None = None


@Parameter(name="*", group=INSTRUMENT)
@dataclass(frozen=True)
class InstrumentOptions:
    """How it is measured.

    Attributes:
        kinds: What is measured, of position, orientation and distance, as position,orientation.
        noise: Standard deviation of each coordinate, as 0.03mm, or of x, y and z in the instrument's frame, as
            0.02mm,0.02mm,0.05mm. A distance has one.
        noise_angle: Standard deviation of the orientation about each axis, as 0.1mrad.
        rounding: Coordinates and distances are read as multiples of this, as 1um.
        outliers: Fraction of the rows that are grossly wrong, as 0.02. The other rows are the same as without.
        outlier_size: How far off these are, in a random direction; 5mm if left out.
        state_sigma: Write the standard deviations of the noise into the table; of three, their root mean square.
    """

    kinds: Globs | None = None
    noise: str | None = None
    noise_angle: str | None = None
    rounding: str | None = None
    outliers: float = 0.0
    outlier_size: str | None = None
    state_sigma: Annotated[bool, Parameter(negative=())] = False


NO_ACTUAL, ANYWHERE, EXACT = ActualOptions(), PoseOptions(), InstrumentOptions()


def simulate(
    robot: Path,
    /,
    *,
    poses: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    tip: Tip = None,
    seed: Seed = 0,
    output: Output = None,
    actual: ActualOptions = NO_ACTUAL,
    where: PoseOptions = ANYWHERE,
    instrument: InstrumentOptions = EXACT,
) -> int:
    """Measurements of a robot that does not exist: a table for calibrate, with a known truth.

    Args:
        robot: Nominal robot: a robot file (TOML) or a URDF.
        poses: How many poses are measured; not with --at.
        tip: Link where the chain of a URDF ends.
        seed: Of the geometry errors, the poses and the noise, each by itself: other noise leaves the poses as they are.
        output: CSV or Parquet file for the measurements; standard output, as CSV, if left out. Parquet is written in
            blocks of 262,144 poses, so that there may be more than fit in memory.
        actual: Which robot is measured.
        where: Where it is measured.
        instrument: How it is measured.
    """
    import numpy as np

    from elastocal.cli.main import DONE
    from elastocal.io import ROW_GROUP, is_parquet, load_measurements, load_robot, measurements_to_csv, robot_to_toml
    from elastocal.simulation import survey, survey_at, survey_blocks

    reading, region = chosen_instrument(instrument), chosen_region(where)
    require_sense(actual, instrument)
    require_poses(poses, where)
    for_robot, for_survey = np.random.default_rng(seed).spawn(2)
    nominal = load_robot(robot, tip)
    built = actual_robot(nominal, actual, tip, for_robot)
    files = {robot: nominal, actual.actual or robot: built}
    require_same_joints(files)
    loads, targets = chosen_names(where, files)
    inputs = [*files, *([where.at] if where.at is not None else [])]
    require_places(output, actual.write_actual, inputs)
    whole = output is None or not is_parquet(output)
    if where.at is not None:
        given = load_measurements(where.at, nominal, measured=False)
        count, blocks = len(given), iter([survey_at(built, given, reading, for_survey)])
    else:
        count = poses or 0

        def some(number: int, rng: np.random.Generator) -> Measurements:
            station = where.station
            return survey(
                nominal,
                number,
                reading,
                actual=built,
                region=region,
                station=station,
                targets=targets,
                loads=loads,
                seed=rng,
            )

        blocks = survey_blocks(some, count, count if whole else ROW_GROUP, for_survey)
    if output is not None and not whole:
        write_blocks(output, blocks, count, nominal, inputs)
        write({actual.write_actual: robot_to_toml(built)}, inputs)
        return DONE
    table = measurements_to_csv(next(blocks), nominal)
    write({output: table, actual.write_actual: robot_to_toml(built)}, inputs)
    if output is None:
        print(table.decode(), end="")
    return DONE


def write_blocks(path: Path, blocks: Iterator[Measurements], poses: int, robot: Robot, inputs: Sequence[Path]) -> None:
    """Write a survey of so many poses as Parquet, one block in memory at a time, and say so."""
    from elastocal.cli.show import progress
    from elastocal.io import write_parquet

    with progress("simulating") as calls:

        def told() -> Iterator[Measurements]:
            done = 0
            for block in blocks:
                done += len(block)
                yield block
                if calls.on_part is not None:
                    calls.on_part(done, poses)

        write_parquet(path, told(), robot, inputs)
    print(f"{path}", file=sys.stderr)


def require_poses(poses: int | None, where: PoseOptions) -> None:
    """Check that poses are either asked for or given.

    Raises:
        InputError: neither or both, or options that choose poses beside given ones.
    """
    if where.at is None:
        if poses is None:
            raise InputError("expected --poses, how many poses are measured, or --at, a table of them; found neither")
        return
    names = ("load", "target", "station", "floor", "box", "range", "cone")
    used = [f"--{name}" for name in names if getattr(where, name) is not None]
    used += ["--poses"] if poses is not None else []
    if used:
        raise InputError(
            f"--at {where.at} gives the poses, with their targets and payloads: leave out {', '.join(used)}"
        )


def require_sense(actual: ActualOptions, instrument: InstrumentOptions) -> None:
    """Check that no option is without effect.

    Raises:
        InputError: some are.
    """
    faults = []
    if actual.actual is not None:
        drawn = {"--geometry-error": actual.geometry_error, "--write-actual": actual.write_actual}
        faults += [f"{name} draws an actual robot: leave out --actual" for name, given in drawn.items() if given]
    kinds = parse_names(instrument.kinds) or ["position"]
    if instrument.noise_angle is not None and "orientation" not in kinds:
        faults.append("--noise-angle is of orientations, which are not measured: add --kinds position,orientation")
    if not {"position", "distance"} & set(kinds):
        lengths = {"--noise": instrument.noise, "--rounding": instrument.rounding}
        measured = "of positions and distances, which are not measured: add --kinds position,orientation"
        faults += [f"{name} is {measured}" for name, given in lengths.items() if given is not None]
    if instrument.outlier_size is not None and not instrument.outliers:
        faults.append("--outlier-size is of outliers, of which there are none: add --outliers 0.02")
    if faults:
        raise InputError(*faults)


def chosen_instrument(options: InstrumentOptions) -> Instrument:
    """The instrument that options describe, SI.

    Raises:
        InputError: they describe none.
    """
    from elastocal.simulation import Instrument

    def single(name: str, text: str | None, quantity: str, default: float = 0.0) -> float:
        return default if text is None else parse_quantities(name, text, [quantity])[0]

    noise: float | tuple[float, ...] = 0.0
    if options.noise is not None:
        found = parse_quantities("--noise", options.noise, ["length"] * (3 if "," in options.noise else 1))
        noise = found[0] if len(found) == 1 else found
    return Instrument(
        kinds=tuple(dict.fromkeys(parse_names(options.kinds))) or Instrument.kinds,
        noise=noise,
        noise_angle=single("--noise-angle", options.noise_angle, "angle"),
        rounding=single("--rounding", options.rounding, "length"),
        outliers=options.outliers,
        outlier_size=single("--outlier-size", options.outlier_size, "length", Instrument.outlier_size),
        state_sigma=options.state_sigma,
    )


def chosen_region(options: PoseOptions) -> Region | None:
    """Where the target must be, SI; None: anywhere.

    Raises:
        InputError: a bound that is no length or angle, a lowest above its highest.
    """
    from elastocal.simulation import Region

    floor = None if options.floor is None else parse_quantities("--floor", options.floor, ["length"], signed=True)[0]
    cone = None if options.cone is None else parse_quantities("--cone", options.cone, ["angle"])[0]
    box = span = None
    if options.box is not None:
        x, xx, y, yy, z, zz = parse_quantities("--box", options.box, ["length"] * 6, signed=True)
        box = ((x, xx), (y, yy), (z, zz))
    if options.range is not None:
        near, far = parse_quantities("--range", options.range, ["length"] * 2)
        span = (near, far)
    region = Region(floor, box, span, cone)
    return None if region == Region() else region


def actual_robot(nominal: Robot, options: ActualOptions, tip: str | None, rng: np.random.Generator) -> Robot:
    """The robot that is measured: of its own file, or drawn after the nominal one; all its frames known."""
    from elastocal.io import load_robot
    from elastocal.simulation import as_built, with_frames_drawn, with_geometry_errors

    if options.actual is not None:
        return as_built(load_robot(options.actual, None if options.actual.suffix.lower() == ".toml" else tip))
    if options.geometry_error is None:
        return as_built(nominal)
    length, angle = parse_quantities("--geometry-error", options.geometry_error, ["length", "angle"])
    return as_built(with_frames_drawn(with_geometry_errors(nominal, length, angle, rng), rng))


def require_same_joints(robots: Mapping[Path, Robot]) -> None:
    """Check that the actual robot's controller has the nominal one's joints.

    Raises:
        InputError: it has others.
    """
    (first, nominal), (path, actual) = next(iter(robots.items())), list(robots.items())[-1]

    def said(robot: Robot) -> str:
        return f"{robot.positions} ({', '.join(str(row.joint) for row in robot.joints)})"

    if said(nominal) != said(actual):
        raise InputError(f"{path}: expected the joints of {first}, {said(nominal)}, found {said(actual)}")


def chosen_names(options: PoseOptions, robots: Mapping[Path, Robot]) -> tuple[list[str | None], list[str | None]]:
    """Payloads and targets that are measured.

    Raises:
        InputError: with every name, the station's too, that one of the robots does not have.
    """
    nominal = next(iter(robots.values()))
    loads, targets = parse_names(options.load), parse_names(options.target) or list(nominal.targets)
    no_load = "none" if "none" not in nominal.loads else None
    named = {
        "load": [name for name in loads if name != no_load],
        "target": targets,
        "station": [] if options.station is None else [options.station],
    }
    faults = [
        f"{path} has {unknown_name(kind, name, valid)}"
        for path, robot in robots.items()
        for kind, valid in (("load", robot.loads), ("target", robot.targets), ("station", robot.stations))
        for name in named[kind]
        if name not in valid
    ]
    if faults:
        raise InputError(*faults)
    carried: list[str | None] = [None if name == no_load else name for name in dict.fromkeys(loads)]
    return carried or [None], [*dict.fromkeys(targets)] or [None]


def require_places(output: Path | None, write_actual: Path | None, inputs: Sequence[Path]) -> None:
    """Check that the files can be written, before the work.

    Raises:
        InputError: one is an input, both are the same, the table is to be no CSV or Parquet.
    """
    from elastocal.io import require_writable

    if output is not None and output.suffix.lower() == ".toml":
        example = output.with_suffix(".csv")
        raise InputError(f"-o {output}: expected a CSV or Parquet file, as {example}, found {output.suffix}")
    if write_actual is not None and write_actual.suffix.lower() != ".toml":
        found = write_actual.suffix or "no suffix"
        raise InputError(f"--write-actual {write_actual}: expected a robot file (.toml), found {found}")
    for path in (output, write_actual):
        if path is not None:
            require_writable(path.parent, [path.name], inputs)


def write(contents: Mapping[Path | None, str | bytes], inputs: Iterable[Path]) -> None:
    """Write what has a place, and say so."""
    from elastocal.io import write_files

    for path, content in contents.items():
        if path is not None:
            write_files(path.parent, {path.name: content}, inputs)
            print(f"{path}", file=sys.stderr)
