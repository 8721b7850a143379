"""What poses are to tell: the parameters that `calibrate` would identify, and how much each pose says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import HINGE
from elastocal.identification import Gauge, choose_gauge
from elastocal.identification.generic import generic_robot, reach, with_middle_torques
from elastocal.identification.request import requested, with_laws
from elastocal.identification.sums import Sums, normal_sums
from elastocal.identification.transition import (
    Transition,
    given_torques,
    searched_laws,
    with_known_torques,
    with_transition,
)
from elastocal.measurements import KINDS, Measurements, concatenate
from elastocal.prediction import Model
from elastocal.robot import Frame, Robot

CHANNELS = {"position": 3, "orientation": 3, "distance": 1}
"""Coordinates of an observation, by kind."""

SOFTER = 1e-9
"""By so much [rad/(N m) or m/N] a hinge whose two coefficients are the same is taken to be softer below its torque. How
much does not matter: a parameter's scale changes neither the determinant nor the predicted position."""


@dataclass(frozen=True)
class Reading:
    """How poses will be measured.

    Attributes:
        kinds: what is measured, of "position", "orientation", "distance".
        noise: standard deviation of each coordinate, and of a distance [m].
        noise_angle: standard deviation of the orientation about each axis [rad].
    """

    kinds: tuple[str, ...] = ("position",)
    noise: float = 3e-5
    noise_angle: float = 1e-4

    @property
    def channels(self) -> int:
        """Coordinates of one pose."""
        return sum(CHANNELS[kind] for kind in self.kinds)

    @property
    def variances(self) -> dict[str, float]:
        """Of the observations, by kind [m2 or rad2]."""
        return {kind: (self.noise_angle if kind == "orientation" else self.noise) ** 2 for kind in KINDS}

    def of(self, data: Measurements) -> Measurements:
        """Observations of these kinds at the poses of data; what was observed does not matter."""
        n = len(data)
        return replace(
            data,
            position=np.zeros((n, 3)) if "position" in self.kinds else None,
            orientation=np.tile(np.eye(3), (n, 1, 1)) if "orientation" in self.kinds else None,
            distance=np.ones(n) if "distance" in self.kinds else None,
            sigma=None,
            sigma_angle=None,
        )


@dataclass(frozen=True)
class Task:
    """The parameters that poses are to tell.

    Attributes:
        robot: with laws and transition torques; frames that nobody knows are anywhere.
        names: of the parameters: those that the gauge keeps, then transition torques of hinges that are to be found.
        scale: (names,) how far a unit of each moves the target, root mean square [m per unit].
        gauge: which parameters are identified, which not and why.
        given: transition torques that the user gives.
        searched: elements whose transition torque the calibration will search for, and their laws.
        assumed: transition torques that stand for those to be found, and where they come from.
        unmeant: of the names, torques of hinges that are straight as yet: that the search has to find them takes
            accuracy, but how well it will depends on how much they bend.
    """

    robot: Robot
    names: tuple[str, ...]
    scale: Array
    gauge: Gauge
    given: Mapping[str, float]
    searched: Mapping[str, str]
    assumed: Mapping[str, tuple[float, str]]
    unmeant: frozenset[str]

    def informed(self, data: Measurements, reading: Reading) -> Array:
        """What each pose tells: (channels, names, n), derivatives in metres per metre over the standard deviation."""
        rows = np.empty((reading.channels, len(self.names), len(data)))
        starts = dict(zip(reading.kinds, np.cumsum([0, *(CHANNELS[kind] for kind in reading.kinds)]), strict=False))
        for part in Model(self.robot, self.names, reading.of(data)).parts(np.zeros(len(self.names))):
            first, sigma = starts[part.kind], np.sqrt(reading.variances[part.kind])
            rows[first : first + CHANNELS[part.kind], :, part.rows] = part.jacobian[:, :-1] / sigma
        return rows / self.scale[:, None]

    def told(self, data: Measurements, reading: Reading) -> Array:
        """Normal matrix (names, names) of measurements that were made, with their stated deviations."""
        known = with_deviations(data, reading)
        sums = self.sums(known, reading, self.names)
        return np.sum([found.gram[:-1, :-1] for found in sums.values()], axis=0) / np.outer(self.scale, self.scale)

    def sums(self, data: Measurements, reading: Reading, names: Sequence[str]) -> Sums:
        """Sums of data for some of the names, as a calibration has them."""
        variances = {kind: 0.0 if stated(data, kind) else value for kind, value in reading.variances.items()}
        return normal_sums(Model(self.robot, tuple(names), data), np.zeros(len(names)), variances)

    def predicted(self, data: Measurements) -> Array:
        """Derivatives of the target's position at the poses of data, (3, names, n), in metres per metre."""
        return self.informed(data, Reading(noise=1.0))


def stated(data: Measurements, kind: str) -> bool:
    """Whether the data have standard deviations of their own."""
    return (data.sigma_angle if kind == "orientation" else data.sigma) is not None


def with_deviations(data: Measurements, reading: Reading) -> Measurements:
    """The data with the instrument's noise where some rows state a deviation and others do not."""
    sigma, angle = data.sigma, data.sigma_angle
    return replace(
        data,
        sigma=None if sigma is None else np.where(np.isfinite(sigma), sigma, reading.noise),
        sigma_angle=None if angle is None else np.where(np.isfinite(angle), angle, reading.noise_angle),
    )


def task_of(
    robot: Robot,
    candidates: Measurements,
    measured: Measurements | None,
    elastic: Mapping[str, str],
    transition: Transition,
    identify: Sequence[str] | None,
    fix: Sequence[str],
) -> Task:
    """The task of telling what `calibrate` would identify from candidates and what was measured before.

    Args:
        robot: nominal.
        candidates: with the kinds that will be observed.
        measured: poses that were measured already; None: none.
        elastic: laws by element.
        transition: transition torques, if they will be given.
        identify: patterns of parameter names; None: all geometry.
        fix: patterns of parameter names that are not identified.

    Raises:
        InputError: as `calibrate` raises it.
    """
    data = candidates if measured is None else concatenate([candidates, measured])
    wished, springs = with_laws(robot, elastic)
    torqued = with_transition(springs, wished)
    given = given_torques(transition, torqued)
    gauge = choose_gauge(wished, data, requested(wished, springs, identify, fix))
    laws = searched_laws(torqued, wished, gauge)
    placed = _placed(with_known_torques(wished, given))
    searched = {element: law for element, law in laws.items() if element not in given}
    assumed = _assumed_torques(wished, placed, candidates, searched)
    hinges = [element for element, law in searched.items() if law == HINGE.name]
    alike = [element for element in hinges if len(set(placed.elastic[element].coefficients)) == 1]
    elastics = dict(placed.elastic)
    for element, (torque, _) in assumed.items():
        low, high = elastics[element].coefficients
        coefficients = (low + SOFTER if element in alike else low, high)
        elastics[element] = replace(elastics[element], coefficients=coefficients, transition_torque=torque)
    placed = replace(placed, elastic=elastics)
    torques = [f"{element}.transition_torque" for element in hinges]
    effects = [*gauge.effects.values(), *_effects(placed, torques, candidates)]
    unmeant = frozenset(f"{element}.transition_torque" for element in alike)
    return Task(placed, (*gauge.kept, *torques), np.array(effects), gauge, given, searched, assumed, unmeant)


def _placed(robot: Robot) -> Robot:
    """The robot with frames of which nothing is known anywhere."""
    anywhere = generic_robot(robot).frames
    return robot.with_frames({name: anywhere[name] for name in unknown_frames(robot)})


def unknown_frames(robot: Robot) -> list[str]:
    """Frames to be identified without a first guess of where they are."""
    return [name for name, frame in robot.frames.items() if frame.xyz is None and not frame.known]


def views_of(robot: Robot, task: Task, candidates: Measurements) -> tuple[Task, ...]:
    """The task with all that nobody knows at several places; as it is where nothing is unknown.

    Poses that suit one place of a target on the tool may suit another badly, and so with transition torques. Where the
    instrument stands does not matter to positions.

    Args:
        robot: nominal.
        task: with every frame and torque somewhere.
        candidates: whose loads the torques lie among.
    """
    named = {name.rpartition(".")[0] for name in task.names}
    carried = [n for n in unknown_frames(robot) if n.startswith(("tool", "target")) and n in named]
    sought = [element for element, (_, source) in task.assumed.items() if source == MEDIAN]
    if not carried and not sought:
        return (task,)
    size, found = reach(robot), []
    loads = Model(task.robot, (), candidates).undeflected_loads(np.zeros(0)) if sought else {}
    for number, ((side, beyond), share) in enumerate(zip(PLACES, SHARES, strict=True)):
        around = 2.0 * np.pi * number / len(PLACES)
        xyz = (side * size * float(np.cos(around)), side * size * float(np.sin(around)), beyond * size)
        placed = task.robot.with_frames({n: Frame(xyz, (0.3, 0.4, 0.5)) for n in carried})
        torques = {element: float(np.quantile(np.abs(loads[element]), share)) for element in sought}
        elastic = {e: replace(placed.elastic[e], transition_torque=torque) for e, torque in torques.items()}
        found.append(replace(task, robot=replace(placed, elastic={**placed.elastic, **elastic})))
    return tuple(found)


SHARES = (0.5, 0.3, 0.7)
"""Transition torques that are to be found, as the share of loads below them."""

PLACES = ((0.07, 0.07), (0.04, 0.14), (0.10, 0.10))
"""Places of a target of which nobody knows where it sits: to the side of the last axis, one third of a turn from one to
the next, and beyond the flange, in units of the robot's reach."""


MEDIAN = "the median of the candidates' loads"


def _assumed_torques(
    wished: Robot, placed: Robot, candidates: Measurements, searched: Mapping[str, str]
) -> dict[str, tuple[float, str]]:
    """Torques in place of those that will be searched: of the robot file, or half of the loads on either side."""
    if not searched:
        return {}
    middle = with_middle_torques(Model(placed, (), candidates)).robot.elastic
    found = {}
    for element in searched:
        own = wished.elastic[element].transition_torque
        if own is not None:
            found[element] = (own, "of the robot file")
        else:
            found[element] = (middle[element].transition_torque or 1.0, MEDIAN)
    return found


def _effects(robot: Robot, names: Sequence[str], candidates: Measurements) -> list[float]:
    """How far a unit of each parameter moves the target at the candidates, root mean square."""
    if not names:
        return []
    at = Reading(noise=1.0).of(candidates)
    sums = normal_sums(Model(robot, tuple(names), at), np.zeros(len(names)), {"position": 1.0})
    moved = np.sqrt(np.diag(sums["position"].gram)[:-1] / len(at))
    return np.where(moved > 0.0, moved, 1.0).tolist()
