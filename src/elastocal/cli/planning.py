"""What `elastocal plan` takes: options, and what they say in SI units."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Globs, Paths, parse_names, parse_quantities
from elastocal.errors import InputError, unknown_name

if TYPE_CHECKING:
    from elastocal.design import Box, Request, Surroundings
    from elastocal.measurements import Measurements
    from elastocal.robot import Robot

Signed = Annotated[str | None, Parameter(allow_leading_hyphen=True)]
Boxes = Annotated[list[str] | None, Parameter(allow_leading_hyphen=True, negative=())]

MEASURED = Group("Measurement", help="How the poses will be measured.", sort_key=1)
CANDIDATES = Group(
    "Candidates",
    help="Poses to choose from: a file's, or random ones within ROBOT's joint limits, ±180° or ±0.5 m where a joint "
    "has none.",
    sort_key=2,
)
AROUND = Group(
    "Surroundings",
    help="Here and above, a length is a number with a unit (m, mm, cm, um, in), and so is an angle (rad, deg, mrad); a "
    "number alone is in m or rad.",
    sort_key=3,
)

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
AXES |= {f"-{name}": (-x, -y, -z) for name, (x, y, z) in AXES.items()}
"""Axes of the target by name."""


@Parameter(name="*", group=MEASURED)
@dataclass(frozen=True)
class MeasuredOptions:
    """How the poses will be measured.

    Attributes:
        kinds: What is measured, of position, orientation and distance, as position,orientation.
        noise: Standard deviation of each coordinate, and of a distance, as 0.03mm.
        noise_angle: Standard deviation of the orientation about each axis, as 0.1mrad.
        load: Payloads, as heavy or none,heavy; the candidates are shared out among them. No payload if left out.
        target: Targets, among which candidates are shared out likewise; all of ROBOT if left out.
        station: Station that the instrument stands at.
        measured: Measurements that were made already, files as for calibrate: the plan adds to them.
    """

    kinds: Globs | None = None
    noise: str = "0.03mm"
    noise_angle: str = "0.1mrad"
    load: Globs | None = None
    target: Globs | None = None
    station: str | None = None
    measured: Paths | None = None


@Parameter(name="*", group=CANDIDATES)
@dataclass(frozen=True)
class CandidateOptions:
    """Which poses there are to choose from.

    Attributes:
        candidates: Table of joint positions q1 …, in rad or with units in the headers; with columns target, load and
            station, where there are several.
        pool: How many random ones; 10000 if left out.
        apart: Two poses differ by at least this in one joint, as 10deg; with a second number, as 10deg,50mm, in a
            sliding joint by that.
        start: Joint positions of the robot before the first pose, as 0,-90deg,0,0,0,0.
        workspace: Where positions are to be predicted: lowest and highest x, y and z of the target in the base frame,
            as 0.5m,1.5m,-1m,1m,0m,1m, or a table of joint positions. All that the joint limits allow if left out.
    """

    candidates: Path | None = None
    pool: Annotated[int | None, Parameter(validator=Number(gte=1))] = None
    apart: str | None = None
    start: Signed = None
    workspace: Signed = None


@Parameter(name="*", group=AROUND)
@dataclass(frozen=True)
class AroundOptions:
    """What the poses must keep clear of, and what the instrument sees.

    Attributes:
        floor: Least height of target and links over the origin of the robot's base, along z of the base frame.
        keep_out: Lowest and highest x, y and z of a box in the base frame that no link may enter; may be repeated.
        link_radius: Links are this thick about the lines from joint origin to joint origin, tool and target.
        instrument: Where the instrument stands in the base frame, as 3m,0m,1m; where the robot file puts it if left
            out.
        box: Where the target must be in the instrument's frame: lowest and highest x, y and z.
        range: Least and greatest distance of the target from the instrument, as 1m,5m.
        cone: What the instrument sees: half angle, as 20deg, about the direction to the middle of where the target
            goes.
        aim: Instead of this middle, a point in the base frame.
        facing: Greatest angle between the target's axis and the direction to the instrument, as 60deg.
        facing_axis: That axis, of the target's frame.
    """

    floor: Signed = None
    keep_out: Boxes = None
    link_radius: str | None = None
    instrument: Signed = None
    box: Signed = None
    range: str | None = None
    cone: str | None = None
    aim: Signed = None
    facing: str | None = None
    facing_axis: Annotated[Literal["x", "y", "z", "-x", "-y", "-z"], Parameter(allow_leading_hyphen=True)] = "z"


def chosen_request(
    robot: Robot, poses: int, criterion: str, seed: int, reading: MeasuredOptions, offered: CandidateOptions
) -> Request:
    """What is asked for, SI.

    Raises:
        InputError: a number is none, or a kind does not exist.
    """
    from elastocal.design import Reading, Request
    from elastocal.io.tidy import sliding
    from elastocal.measurements import SAME_POSE

    slides = sliding(robot)
    (noise,) = parse_quantities("--noise", reading.noise, ["length"])
    (noise_angle,) = parse_quantities("--noise-angle", reading.noise_angle, ["angle"])
    apart = [SAME_POSE] * len(slides)
    if offered.apart is not None:
        both = parse_quantities("--apart", offered.apart, ["angle", "length"][: 1 + offered.apart.count(",")])
        apart = [(both[1] if len(both) > 1 else SAME_POSE) if slide else both[0] for slide in slides]
    start = None
    if offered.start is not None:
        quantities = ["length" if slide else "angle" for slide in slides]
        start = parse_quantities("--start", offered.start, quantities, signed=True)
    kinds = tuple(dict.fromkeys(parse_names(reading.kinds))) or ("position",)
    return Request(poses, criterion, Reading(kinds, noise, noise_angle), apart=apart, start=start, seed=seed)


def chosen_surroundings(options: AroundOptions) -> Surroundings:
    """What rejects a pose, SI.

    Raises:
        InputError: a bound that is no length or angle, a lowest above its highest.
    """
    from elastocal.cli.simulate import PoseOptions, chosen_region
    from elastocal.design import Surroundings
    from elastocal.simulation import Region

    def place(name: str, text: str | None) -> tuple[float, float, float] | None:
        if text is None:
            return None
        x, y, z = parse_quantities(name, text, ["length"] * 3, signed=True)
        return (x, y, z)

    seen = PoseOptions(floor=options.floor, box=options.box, range=options.range, cone=options.cone)
    radius, facing = options.link_radius, options.facing
    return Surroundings(
        region=chosen_region(seen) or Region(),
        instrument=place("--instrument", options.instrument),
        aim=place("--aim", options.aim),
        facing=None if facing is None else parse_quantities("--facing", facing, ["angle"])[0],
        axis=AXES[options.facing_axis],
        keep_out=tuple(_box("--keep-out", text) for text in options.keep_out or ()),
        link_radius=0.0 if radius is None else parse_quantities("--link-radius", radius, ["length"])[0],
    )


def _box(name: str, text: str) -> Box:
    x, xx, y, yy, z, zz = parse_quantities(name, text, ["length"] * 6, signed=True)
    return (x, xx), (y, yy), (z, zz)


def chosen_candidates(
    robot: Robot,
    poses: int,
    seed: int,
    surroundings: Surroundings,
    reading: MeasuredOptions,
    offered: CandidateOptions,
) -> Measurements:
    """Poses to choose from.

    Raises:
        InputError: names that the robot does not have, too few candidates.
    """
    from elastocal.design import draw_candidates, kept_candidates
    from elastocal.io import load_measurements

    if offered.candidates is not None:
        given: dict[str, object] = {"--pool": offered.pool, "--load": reading.load}
        given |= {"--target": reading.target, "--station": reading.station}
        faults = [f"{name} is of random candidates: leave it or --candidates out" for name, v in given.items() if v]
        if faults:
            raise InputError(*faults)
        table = load_measurements(offered.candidates, robot, measured=False)
        return kept_candidates(robot, table, poses, surroundings).poses
    loads, targets = _names(robot, reading)
    wanted = offered.pool or POOL
    if wanted < poses:
        raise InputError(f"--pool {wanted}: expected at least {poses} candidates for {poses} poses")
    drawn = draw_candidates(
        robot, wanted, poses, surroundings, station=reading.station, targets=targets, loads=loads, seed=seed
    )
    if len(drawn.poses) < wanted:
        print(
            f"{len(drawn.poses)} candidates instead of {wanted}: the others of {drawn.tried} drawn are rejected",
            file=sys.stderr,
        )
    return drawn.poses


POOL = 10_000
"""Random candidates, if nothing else is said."""


def _names(robot: Robot, reading: MeasuredOptions) -> tuple[list[str | None], list[str | None]]:
    """Payloads and targets of the candidates.

    Raises:
        InputError: with every name that the robot does not have.
    """
    loads, targets = parse_names(reading.load), parse_names(reading.target) or list(robot.targets)
    nothing = "none" if "none" not in robot.loads else None
    named = {
        "load": ([name for name in loads if name != nothing], robot.loads),
        "target": (targets, robot.targets),
        "station": ([] if reading.station is None else [reading.station], robot.stations),
    }
    faults = [
        f"--{kind}: {unknown_name(kind, name, valid)}"
        for kind, (names, valid) in named.items()
        for name in names
        if name not in valid
    ]
    if faults:
        raise InputError(*faults)
    carried: list[str | None] = [None if name == nothing else name for name in dict.fromkeys(loads)]
    return carried or [None], [*dict.fromkeys(targets)] or [None]


def workspace_file(offered: CandidateOptions) -> Path | None:
    """The file that the workspace is given by, if it is no box."""
    text = offered.workspace
    return Path(text) if text is not None and text.count(",") != 5 else None


def chosen_workspace(
    robot: Robot, offered: CandidateOptions, surroundings: Surroundings, candidates: Measurements, seed: int
) -> Measurements:
    """Where positions are to be predicted.

    Raises:
        InputError: no box, or one that is out of reach; a file that is none.
    """
    from elastocal.design import draw_workspace
    from elastocal.io import load_measurements

    path = workspace_file(offered)
    if path is not None:
        return load_measurements(path, robot, measured=False)
    box = None if offered.workspace is None else _box("--workspace", offered.workspace)
    for axis, (low, high) in zip("xyz", box or (), strict=False):
        if not low < high:
            order = f"expected the lowest {axis} and then the highest, found {low:g} m and {high:g} m"
            raise InputError(f"--workspace {offered.workspace}: {order}")
    return draw_workspace(robot, box, surroundings, candidates, seed)
