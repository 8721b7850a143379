"""Which poses to measure: from candidates to a plan."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.design.advice import notes, warnings
from elastocal.design.criteria import Averaged, Criterion, criterion_of
from elastocal.design.exchange import Pool, best_choice
from elastocal.design.ordering import short_order, travel
from elastocal.design.precision import (
    Precision,
    accuracy_curve,
    accuracy_of,
    enough,
    gram_of,
    planned_parameters,
)
from elastocal.design.request import AVERAGED, Request, poses_of
from elastocal.design.result import Plan, PlannedTransition
from elastocal.design.rules import Chosen, rules_of
from elastocal.design.task import Reading, Task, task_of, views_of, with_deviations
from elastocal.errors import InputError
from elastocal.identification import Observability
from elastocal.identification.observability import observability
from elastocal.identification.threads import one_thread
from elastocal.identification.transition import Transition
from elastocal.measurements import SAME_POSE, Measurements, concatenate
from elastocal.prediction import Model, predict
from elastocal.robot import Robot

STARTS, STARTS_OF_OTHERS = 4, 12
"""Exchanges from so many starts; more for O2 to O4, which hang on the smallest singular value alone and have more local
optima."""

WORKSPACE_POSES = 2000
"""Candidates that stand for the workspace where none is named."""


def select_poses(
    robot: Robot,
    candidates: Array | Measurements,
    count: int = 45,
    *,
    elastic: Mapping[str, str] | None = None,
    criterion: str = "O1",
    kinds: Sequence[str] = ("position",),
    noise: float = 3e-5,
    noise_angle: float = 1e-4,
    identify: Sequence[str] | None = None,
    fix: Sequence[str] = (),
    transition: Transition = "exact",
    measured: Measurements | None = None,
    workspace: Array | Measurements | None = None,
    apart: float | Sequence[float] = SAME_POSE,
    start: Sequence[float] | None = None,
    seed: int = 0,
    executor: Executor | None = None,
) -> Plan:
    """Choose the poses that tell a robot's parameters best, in an order with short travel.

    Args:
        robot: nominal. Compliances in it are taken into account, rigid elements by their first effect.
        candidates: (n, joints) joint positions [rad or m]; or Measurements, for their target, payload and station.
        count: how many to choose.
        elastic: laws by element, as for `calibrate`.
        criterion: "O1" (determinant), "O2" … "O5", or "accuracy": the standard deviation of the predicted position over
            the workspace.
        kinds: what will be measured, of "position", "orientation", "distance".
        noise: standard deviation of each coordinate, and of a distance [m].
        noise_angle: standard deviation of the orientation about each axis [rad].
        identify: patterns of parameter names; None: all geometry.
        fix: patterns of parameter names that are not identified.
        transition: transition torques [N m or N] in the order of `elastic`, if `calibrate` will be given them; else it
            searches for them, and loads are chosen all over their range.
        measured: what was measured already, and stays.
        workspace: (m, joints) poses, or Measurements, where the position is to be predicted; None: the candidates.
        apart: least difference of two poses in at least one joint, of all or of each [rad or m].
        start: (joints,) where the robot is before the first pose; None: anywhere.
        seed: of the exchange's starts.
        executor: where the exchanges from several starts run; None: here. The plan is the same.

    Raises:
        InputError: fewer candidates than poses, names or patterns that make no sense, poses that cannot keep their
            distance.
        EquilibriumError: a candidate does not settle under its load.
    """
    reading = Reading(tuple(dict.fromkeys(kinds)), noise, noise_angle)
    request = Request(count, criterion, reading, elastic or {}, transition, identify, fix, apart, start, seed)
    given = None if workspace is None else poses_of(robot, workspace, "workspace")
    return choose(robot, poses_of(robot, candidates, "candidates"), request, measured, given, executor)


@one_thread
def choose(
    robot: Robot,
    candidates: Measurements,
    request: Request,
    measured: Measurements | None = None,
    workspace: Measurements | None = None,
    executor: Executor | None = None,
) -> Plan:
    """The same for a request.

    Raises:
        InputError: as `select_poses` raises it.
        EquilibriumError: a candidate does not settle under its load.
    """
    began = time.perf_counter()
    limits, begin = request.distances(robot), request.position(robot)
    if request.count > len(candidates):
        raise InputError(
            f"expected at least {request.count} candidates to choose {request.count} poses from, found "
            f"{len(candidates)}: offer more, or ask for fewer poses"
        )
    for_choice, for_curve, for_workspace = np.random.default_rng(request.seed).spawn(3)
    if workspace is None:
        workspace = candidates.take(for_workspace.permutation(len(candidates))[:WORKSPACE_POSES])
    problem = _problem(robot, candidates, request, measured, workspace, limits)
    starts = STARTS_OF_OTHERS if request.criterion in ("O2", "O3", "O4") else STARTS
    chosen = np.sort(best_choice(problem.pool, problem.criterion, request.count, starts, for_choice, executor))
    curve = accuracy_curve(problem.pool, problem.criterion, problem.wanted, chosen, for_curve)
    poses = candidates.take(chosen)
    order = short_order(poses, begin)
    ordered = poses.take(order)
    precision = Precision.of(gram_of(problem.pool, chosen))
    told = warnings(problem.task, problem.pool, precision, request, robot)
    return Plan(
        robot=robot,
        rows=chosen[order],
        poses=ordered,
        expected=_expected_positions(robot, ordered),
        criterion=request.criterion,
        status="not_identifiable" if precision.unseen.any() else "planned",
        parameters=planned_parameters(robot, problem.task, precision),
        gauge=problem.task.gauge,
        observability=_observability(problem.task, ordered, measured, request.reading),
        accuracy=accuracy_of(problem.pool, problem.wanted, chosen),
        curve=curve,
        enough=enough(curve),
        transitions=_transitions(problem, chosen),
        travel={"before": travel(poses.q, begin), "after": travel(ordered.q, begin)},
        reading=request.reading,
        candidates=len(candidates),
        measured=0 if measured is None else len(measured),
        settings=request.settings,
        warnings=told,
        notes=notes(problem.task, request, robot),
        seconds=time.perf_counter() - began,
    )


@dataclass(frozen=True)
class _Problem:
    """What is to be told, by which candidates, judged how.

    Attributes:
        wanted: (views, p, p) mean of JᵀJ over the workspace.
        loads: (n,) on each element with a transition torque, at the candidates.
    """

    task: Task
    pool: Pool
    criterion: Criterion
    wanted: Array
    loads: Mapping[str, Array]


def _problem(
    robot: Robot,
    candidates: Measurements,
    request: Request,
    measured: Measurements | None,
    workspace: Measurements,
    limits: Array,
) -> _Problem:
    reading = request.reading
    task = task_of(
        robot,
        reading.of(candidates),
        measured,
        request.elastic,
        request.transition,
        request.identify,
        request.fix,
    )
    if not task.names:
        raise InputError("expected parameters to identify, found none: leave out --fix, or name some with --identify")
    views = views_of(robot, task, reading.of(candidates)) if request.criterion in AVERAGED else (task,)
    task = views[0]
    wanted = np.stack([_wanted(view, workspace) for view in views])
    known = np.zeros((len(views), *(len(task.names),) * 2))
    if measured is not None:
        known += np.stack([view.told(measured, reading) for view in views])
    taken = np.empty((0, robot.positions)) if measured is None else measured.q
    model = Model(task.robot, (), reading.of(candidates))
    sides = {*task.searched, *task.given}
    loads = {name: found for name, found in model.undeflected_loads(np.zeros(0)).items() if name in sides}
    rules = rules_of(candidates.q, limits, taken, loads, task.given, request.count)
    rows = np.stack([view.informed(candidates, reading) for view in views])
    criteria = tuple(criterion_of(request.criterion, each) for each in wanted)
    if len(views) == 1:
        return _Problem(task, Pool(rows[0], known[0], rules), criteria[0], wanted, loads)
    return _Problem(task, Pool(rows, known, rules), Averaged(criteria), wanted, loads)


def _wanted(task: Task, workspace: Measurements) -> Array:
    """(p, p) mean of JᵀJ over the workspace."""
    columns = task.predicted(workspace)
    return np.einsum("cpn,cqn->pq", columns, columns, optimize=True) / len(workspace)


def _observability(task: Task, poses: Measurements, measured: Measurements | None, reading: Reading) -> Observability:
    """What `calibrate` will say of the poses and of what was measured before."""
    data = reading.of(poses)
    if measured is not None:
        data = with_deviations(concatenate([data, measured]), reading)
    names = task.gauge.kept
    return observability(task.sums(data, reading, names), task.scale[: len(names)], len(data), names)


def _transitions(problem: _Problem, chosen: Chosen) -> tuple[PlannedTransition, ...]:
    task, found = problem.task, []
    for element, loads in problem.loads.items():
        sizes = np.sort(np.abs(loads[chosen]))
        torque, source = task.assumed.get(element, (task.given.get(element, 0.0), "given"))
        found.append(
            PlannedTransition(
                element=element,
                law=task.robot.elastic[element].law,
                torque=torque,
                source=source,
                below=int((sizes < torque).sum()),
                above=int((sizes >= torque).sum()),
                lowest=float(sizes[0]),
                highest=float(sizes[-1]),
                widest_gap=float(np.diff(sizes).max(initial=0.0)),
            )
        )
    return tuple(found)


def _expected_positions(robot: Robot, poses: Measurements) -> Array | None:
    """Where the nominal robot has the target at each pose, (n, 3); None where a frame on the way is not known."""
    found = np.empty((len(poses), 3))
    for part in poses.combinations:
        frames = [robot.base if part.station is None else robot.stations[part.station], robot.tool]
        frames += [robot.targets[part.target]] if part.target is not None else []
        if any(frame.xyz is None and not frame.known for frame in frames):
            return None
        q = poses.q[part.rows]
        wrench = None if poses.wrench is None else poses.wrench[part.rows]
        found[part.rows] = predict(robot, q, station=part.station, target=part.target, load=part.load, wrench=wrench)[0]
    return found
