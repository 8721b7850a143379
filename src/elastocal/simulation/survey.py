"""Measuring an actual robot: at given poses, or all over its workspace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from elastocal.chain import Array
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.prediction import predict
from elastocal.robot import Robot
from elastocal.simulation.instrument import Instrument, read
from elastocal.simulation.poses import random_poses
from elastocal.simulation.region import Region


def simulate(
    robot: Robot,
    q: Array,
    *,
    kinds: Sequence[str] = ("position",),
    noise: float | Sequence[float] = 0.0,
    noise_angle: float = 0.0,
    rounding: float = 0.0,
    outliers: float = 0.0,
    outlier_size: float = 5e-3,
    state_sigma: bool = False,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
    wrench: Array | None = None,
    seed: int | np.random.Generator = 0,
) -> Measurements:
    """Measure an actual robot at joint positions q (poses, joints).

    Args:
        robot: the actual robot.
        q: the controller's joint positions [rad or m].
        kinds: what is measured, of "position", "orientation", "distance".
        noise: standard deviation of each coordinate of the position, and of the distance [m]; or three, for x, y and z
            of the instrument's frame.
        noise_angle: standard deviation of the orientation about each axis [rad].
        rounding: the instrument shows coordinates and distances as multiples of this [m]; 0: as they are.
        outliers: fraction of the rows that are grossly wrong, to the nearest row.
        outlier_size: how far off these are, in a random direction [m].
        state_sigma: whether the measurements state the standard deviations of the noise.
        station: name in the robot; None: its base.
        target: name in the robot; None: the tool's origin.
        load: name of a payload in the robot.
        wrench: (poses, 6) on the tool.
        seed: of noise and outliers.

    Raises:
        InputError: a kind of observation that does not exist, a negative standard deviation.
    """
    each = np.atleast_1d(noise).tolist()
    size = each[0] if len(each) == 1 else tuple(each)
    instrument = Instrument(tuple(kinds), size, noise_angle, rounding, outliers, outlier_size, state_sigma)
    return read(instrument, _exact(robot, q, instrument.kinds, station, target, load, wrench), seed)


def survey(
    robot: Robot,
    count: int,
    instrument: Instrument,
    *,
    actual: Robot | None = None,
    region: Region | None = None,
    station: str | None = None,
    targets: Sequence[str | None] = (None,),
    loads: Sequence[str | None] = (None,),
    seed: int | np.random.Generator = 0,
) -> Measurements:
    """Measure an actual robot at random poses, shared out evenly among payloads and targets, one after the other.

    Poses and noise have streams of chance of their own: another noise does not change the poses.

    Args:
        robot: whose joint limits the poses keep to.
        count: how many poses.
        instrument: how it measures.
        actual: the robot that is measured; None: `robot`.
        region: where the target must be; None: anywhere.
        station: the instrument's station; None: the robot's base.
        targets: which are measured; None: the tool's origin.
        loads: which payloads are carried; None: no payload.
        seed: of poses, noise and outliers.

    Raises:
        InputError: too few poses put the target into the region.
    """
    moved = actual or robot
    for_poses, for_noise = np.random.default_rng(seed).spawn(2)
    settings = list(product(loads, targets))
    parts = []
    for number, (load, target) in enumerate(settings):
        share = len(range(number, count, len(settings)))
        if not share:
            break
        q = random_poses(
            robot, share, for_poses, region=region, actual=moved, station=station, target=target, load=load
        )
        parts.append(_exact(moved, q, instrument.kinds, station, target, load))
    return read(instrument, concatenate(parts), for_noise)


def survey_at(
    robot: Robot, poses: Measurements, instrument: Instrument, seed: int | np.random.Generator = 0
) -> Measurements:
    """Measure an actual robot at given poses, with the targets, payloads, stations and wrenches that they name.

    Args:
        robot: the actual robot.
        poses: whatever was measured there.
        instrument: how it measures.
        seed: of noise and outliers.
    """
    position, orientation = np.empty((len(poses), 3)), np.empty((len(poses), 3, 3))
    for part in poses.combinations:
        wrench = None if poses.wrench is None else poses.wrench[part.rows]
        position[part.rows], orientation[part.rows] = predict(
            robot, poses.q[part.rows], station=part.station, target=part.target, load=part.load, wrench=wrench
        )
    exact = replace(
        poses,
        position=position if "position" in instrument.kinds else None,
        orientation=orientation if "orientation" in instrument.kinds else None,
        distance=np.linalg.norm(position, axis=1) if "distance" in instrument.kinds else None,
    )
    return read(instrument, exact, seed)


def survey_blocks(
    survey_some: Callable[[int, np.random.Generator], Measurements], count: int, rows: int, seed: np.random.Generator
) -> Iterator[Measurements]:
    """A survey in blocks, each with a stream of chance of its own; one block is the survey with the same seed.

    Args:
        survey_some: makes a survey of so many poses.
        count: how many poses there are in all.
        rows: how many a block has at most.
        seed: of all blocks.
    """
    blocks = -(-count // rows)
    streams = [seed] if blocks == 1 else seed.spawn(blocks)
    for number, stream in enumerate(streams):
        yield survey_some(min(rows, count - number * rows), stream)


def _exact(
    robot: Robot,
    q: Array,
    kinds: Sequence[str],
    station: str | None,
    target: str | None,
    load: str | None,
    wrench: Array | None = None,
) -> Measurements:
    """Observations without error."""
    position, rotation = predict(robot, q, station=station, target=target, load=load, wrench=wrench)
    n = len(position)
    return Measurements(
        q=np.asarray(q, dtype=float),
        position=position if "position" in kinds else None,
        orientation=rotation if "orientation" in kinds else None,
        distance=np.linalg.norm(position, axis=1) if "distance" in kinds else None,
        target=Labels.same(target, n),
        load=Labels.same(load, n),
        station=Labels.same(station, n),
        wrench=wrench,
    )
