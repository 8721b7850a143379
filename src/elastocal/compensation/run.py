"""Compensation: joint commands that put the real, loaded robot on its targets, block by block."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.inverse import NEAR, Tail, solutions, spacing
from elastocal.compensation.loaded import corrected
from elastocal.compensation.machine import HERE, Machine, joint_limits, rigid, slides
from elastocal.compensation.outcome import Compensation, Rows, Summary
from elastocal.compensation.pool import pool_of
from elastocal.compensation.solver import Found, Task, left, turns
from elastocal.compensation.targets import Goals, Targets, goals_of, require_targets
from elastocal.compensation.words import jumps, notes
from elastocal.errors import InputError, unknown_name
from elastocal.identification.threads import one_thread
from elastocal.measurements import Measurements
from elastocal.robot import Frame, Robot

BLOCK = 4000
"""Targets worked through at once."""

FRAMES = ("base", "instrument")


@dataclass(frozen=True)
class Job:
    """What is to be compensated.

    Attributes:
        robot: calibrated and loaded.
        nominal: as the controller knows it, rigid; its TCPs are there.
        program: whether joint positions alone are targets: then the nominal robot was given.
        start: (joints,) preferred joint positions, or None.
        frame: instrument_T_base if targets are in the instrument's frame, else None.
    """

    robot: Robot
    nominal: Robot
    program: bool
    start: Array | None = None
    frame: Frame | None = None

    @classmethod
    def of(
        cls,
        robot: Robot,
        nominal: Robot | None = None,
        start: Sequence[float] | Array | None = None,
        frame: str = "base",
        station: str | None = None,
        tool: Frame | None = None,
    ) -> Job:
        """A job as `compensate` describes it.

        Raises:
            InputError: with every fault: a frame or station that is not known, a start with other joints.
        """
        faults = [] if frame in FRAMES else [unknown_name("frame", frame, FRAMES)]
        faults += list(_frame_faults(robot, frame, station))
        if nominal is not None and nominal.positions != robot.positions:
            faults.append(
                f"expected a nominal robot with {robot.positions} joints as {robot.name}, found {nominal.positions}"
            )
        if start is not None and (np.shape(start) != (robot.positions,) or not np.isfinite(start).all()):
            faults.append(f"start: expected {robot.positions} joint positions, found {np.size(start)}")
        if faults:
            raise InputError(*faults)
        seen = robot.base if station is None else robot.stations[station]
        if tool is not None:
            robot = replace(robot, tool=tool, targets={})  # targets sit on the robot's own tool
            nominal = None if nominal is None else replace(nominal, tool=tool, targets={})
        return cls(
            robot,
            rigid(robot if nominal is None else with_tcps(nominal, robot)),
            nominal is not None,
            None if start is None else np.asarray(start, dtype=float),
            seen if frame == "instrument" else None,
        )


def _frame_faults(robot: Robot, frame: str, station: str | None) -> Iterator[str]:
    if station is not None and frame != "instrument":
        yield "a station is of the instrument's frame: targets are in the base frame (frame instrument: in that one)"
    if station is not None and station not in robot.stations:
        yield f"{robot.name} has {unknown_name('station', station, robot.stations)}"
    elif frame == "instrument":
        if station is None and robot.stations:
            yield f"targets are seen by the instrument: expected a station of {', '.join(robot.stations)}, found none"
        elif (robot.base if station is None else robot.stations[station]).xyz is None:
            yield f"targets are seen by the instrument, but where {robot.name} stands to it is not known: calibrate it"


def with_tcps(nominal: Robot, robot: Robot) -> Robot:
    """The nominal robot with the tool and targets of the calibrated one where its own file gives none."""
    given = {name: frame for name, frame in nominal.targets.items() if frame.xyz is not None}
    return replace(
        nominal,
        tool=robot.tool if nominal.tool.xyz is None else nominal.tool,
        targets={**robot.targets, **given},
        loads={**robot.loads, **nominal.loads},
    )


@one_thread
def compensate(
    robot: Robot,
    targets: Targets | Measurements | tuple[Array, Array] | Array,
    *,
    nominal: Robot | None = None,
    start: Sequence[float] | Array | None = None,
    frame: str = "base",
    station: str | None = None,
    tool: Frame | None = None,
) -> Compensation:
    """Joint commands that put the calibrated, loaded robot on targets.

    Args:
        robot: calibrated.
        targets: positions (n, 3) [m]; positions and rotations (n, 3, 3); or Targets, which may name payloads and TCPs,
            or be a nominal program of joint positions.
        nominal: the robot as its controller knows it, whose joint positions are corrected; tool and targets that it
            does not give are those of `robot`. None: `robot` without compliance and joint maps.
        start: (joints,) joint positions whose configuration is preferred. None: the middle of the limits.
        frame: "base" or "instrument", of positions and rotations.
        station: whose instrument, of a robot with stations.
        tool: flange_T_tool in place of both robots' own.

    Raises:
        InputError: with every fault of targets and request.
        EquilibriumError: the robot does not settle at a target.
    """
    job = Job.of(robot, nominal, start, frame, station, tool)
    given = Targets.of(targets)
    require_targets(given, job.robot, job.nominal if job.program else None)
    summary, parts = Summary(robot.name), []
    blocks = (given.take(slice(first, first + BLOCK)) for first in range(0, max(len(given), 1), BLOCK))
    for rows in compensated(job, blocks):
        parts.append(rows)
        summary = summary.with_rows(rows)
    return Compensation.of(parts, summary)


def compensated(job: Job, blocks: Iterable[Targets]) -> Iterator[Rows]:
    """Compensate block after block; paths go on from one to the next.

    Args:
        job: what is to be done.
        blocks: of BLOCK targets each, but the last, that require_targets has no fault to find with.
    """
    tail, first = None, 0
    for block in blocks:
        goals, found, near = _nominal(job, block, first, tail)
        rows, corrected_q = _loaded(job, block, first, goals, found, near, tail)
        yield rows
        first += len(block)
        if len(block):
            last = np.arange(len(block) - 1, len(block))
            tail = Tail(found.q[:, -1], goals.take(last), corrected_q[:, -1])


def _nominal(job: Job, block: Targets, first: int, tail: Tail | None) -> tuple[Goals, Found, NDArray[np.bool_]]:
    """Goals, the nominal robot's joint positions there, and which rows go on a path."""
    machine = Machine.of(job.nominal, replace(block, load=None, wrench=None), first)
    n = len(block)
    if block.position is None:
        q = np.asarray(block.q, dtype=float).T.copy()
        driven = machine.at(q, np.arange(n), derivatives=False)
        every = np.ones(n, dtype=bool)
        goals = Goals(driven.position, driven.rotation, every, every & (len(q) >= 6))
        return goals, Found(q, np.zeros(n), np.zeros(n)), ~every
    goals = goals_of(block, job.frame)
    if not n:
        return goals, Found(np.empty((job.robot.positions, 0)), np.empty(0), np.empty(0)), np.zeros(0, dtype=bool)
    if block.q is not None:
        pool = pool_of(job.nominal, machine, job.start)
        found = solutions(_task(job.nominal, machine, goals, pool.weight), pool, np.asarray(block.q, dtype=float).T)
        return goals, found, np.zeros(n, dtype=bool)
    pool = pool_of(job.nominal, machine, job.start)
    found = solutions(_task(job.nominal, machine, goals, pool.weight), pool, before=tail)
    return goals, found, spacing(goals, tail, pool.weight) < NEAR * pool.size


def _task(robot: Robot, machine: Machine, goals: Goals, weight: float) -> Task:
    n = goals.position.shape[1]
    low, high = (np.repeat(bound[:, None], n, axis=1) for bound in joint_limits(robot))
    return Task(machine, goals, low, high, slides(robot), weight)


def _loaded(
    job: Job,
    block: Targets,
    first: int,
    goals: Goals,
    nominal: Found,
    near: NDArray[np.bool_],
    tail: Tail | None,
) -> tuple[Rows, Array]:
    """The rows of a block, and their joint positions (joints, n)."""
    machine, every = Machine.of(job.robot, block, first), np.arange(len(block))
    size = float(np.sqrt((goals.position**2).sum(axis=0).mean())) if len(block) else 1.0
    task = _task(job.robot, machine, goals, 0.5 * max(size, 1e-3))
    before = left(task, every, nominal.q)
    done = corrected(task, nominal)
    q = done.found.q
    after = left(task, every, q)
    fake = Machine.of(job.nominal, replace(block, load=None, wrench=None)).at(q, every, derivatives=False)
    shift = np.linalg.norm(fake.position - goals.position, axis=0)
    angles = [np.linalg.norm(turns(goals, fake.rotation), axis=0), before[1], after[1]]
    turned, angle_before, angle_after = (np.where(goals.oriented, angle, np.nan) for angle in angles)
    reached = Found(q, after[0], np.where(goals.strict, after[1], 0.0)).reached
    previous = np.column_stack([q[:, :1] if tail is None else tail.corrected[:, None], q[:, :-1]])
    return Rows(
        q=q.T.copy(),
        reached=reached,
        correction=shift,
        correction_angle=turned,
        error_before=before[0],
        error_after=after[0],
        angle_before=angle_before,
        angle_after=angle_after,
        nominal_q=nominal.q.T.copy(),
        fake_position=fake.position.T.copy(),
        fake_rotation=np.moveaxis(fake.rotation, -1, 0).copy(),
        notes=notes(task, done, after[0], after[1], jumps(near, q, previous)),
    ), q


@one_thread
def inverse_kinematics(
    robot: Robot,
    targets: Targets | tuple[Array, Array] | Array,
    *,
    start: Sequence[float] | Array | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Joint positions of a rigid robot at targets in its base frame.

    Compliance and joint maps of the robot are left out. Targets near one another are reached in one configuration.

    Args:
        robot: of any chain; of a redundant one, steps are the shortest ones.
        targets: as for `compensate`.
        start: (joints,) joint positions whose configuration is preferred.

    Returns:
        Joint positions (n, joints) [rad or m], and whether they are at the targets to 1e-9 m and rad, (n,); where not,
        they are as near as possible, in position first.

    Raises:
        InputError: with every fault of the targets.
    """
    job = Job.of(replace(robot, base=HERE), start=start)
    given = Targets.of(targets)
    require_targets(given, robot, None)
    tail, q, reached = None, [], []
    for first in range(0, max(len(given), 1), BLOCK):
        block = given.take(slice(first, first + BLOCK))
        goals, found, _ = _nominal(job, block, first, tail)
        q.append(found.q.T)
        reached.append(found.reached)
        if len(block):
            tail = Tail(found.q[:, -1], goals.take(slice(len(block) - 1, None)), found.q[:, -1])
    return np.concatenate(q), np.concatenate(reached)
