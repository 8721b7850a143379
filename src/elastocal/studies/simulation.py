"""What one repeat of a study measures: an actual robot, poses, and an instrument's readings there."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from elastocal.chain import Array
from elastocal.design import select_poses
from elastocal.io.study_values import Actual, Setting, Spring, Study
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.robot import Compliance, Robot
from elastocal.simulation import (
    Instrument,
    as_built,
    random_poses,
    simulate,
    with_frames_drawn,
    with_geometry_errors,
)

CANDIDATES = 500
"""Random poses that a plan chooses from, or four for each wanted if that is more."""


@dataclass(frozen=True)
class Poses:
    """Joint positions with a payload and a target; None: none, and the tool's origin."""

    q: Array
    load: str | None
    target: str | None


def drawn_robot(study: Study, law: str, reach: float, rng: np.random.Generator) -> Robot:
    """An actual robot of a study, whose nominal one has a reach [m].

    All numbers are drawn whatever the law, so that only that differs between laws.
    """
    nominal, length_angle = study.robot, study.actual.geometry_error
    flawed = as_built(with_frames_drawn(with_geometry_errors(nominal, *length_angle, rng), rng, reach))
    names = springs_of(study.actual, nominal)
    drawn = [_drawn_spring(spring, law, rng) for spring in study.actual.springs.values()]
    springs = dict(zip(names, drawn, strict=True))
    if law == "rigid":
        return replace(flawed, elastic={name: one for name, one in flawed.elastic.items() if name not in springs})
    return replace(flawed, elastic={**flawed.elastic, **springs})


def _drawn_spring(spring: Spring, law: str, rng: np.random.Generator) -> Compliance:
    soft = float(rng.uniform(*spring.compliance))
    torque = float(rng.uniform(*(spring.transition_torque or (0.0, 0.0))))
    if law in ("step", "hinge"):
        return Compliance(law, (soft, soft / spring.stiffening), torque)
    if law == "cubic":
        # the slope c1 + 3 c3 τ² is c1 / stiffening at the largest load
        curve = -soft * (1.0 - 1.0 / spring.stiffening) / (3.0 * (spring.largest_load or np.inf) ** 2)
        return Compliance(law, (soft, curve))
    return Compliance("linear", (soft,))


def laws_of(study: Study, law: str) -> dict[str, str]:
    """A law on each element of a study, as `calibrate` takes it."""
    return {} if law == "rigid" else dict.fromkeys(study.elements, law)


def shared_poses(robot: Robot, payload: str, q: Array) -> list[Poses]:
    """Poses shared out evenly among payloads and targets."""
    loads = [None if name == "none" else name for name in payload.split(",")]
    pairs = list(product(loads, robot.targets or [None]))
    return [Poses(part, *pair) for part, pair in zip(np.array_split(q, len(pairs)), pairs, strict=True) if len(part)]


def planned_poses(study: Study, setting: Setting) -> list[Poses]:
    """The poses that a plan for the nominal robot chooses: the same for all repeats."""
    q = random_poses(study.robot, max(CANDIDATES, 4 * setting.poses), np.random.default_rng([study.seed, 4]))
    parts = shared_poses(study.robot, setting.payload, q)
    offered = concatenate([_unmeasured(part) for part in parts])
    plan = select_poses(
        study.robot,
        offered,
        setting.poses,
        elastic=laws_of(study, setting.fitted),
        kinds=setting.kinds.split(","),
        noise=setting.noise or Setting.noise,
        noise_angle=setting.noise_angle or Setting.noise_angle,
        identify=patterns_of(setting.identify),
        fix=patterns_of(setting.fix) or (),
        seed=study.seed,
    )
    numbers = np.repeat(np.arange(len(parts)), [len(part.q) for part in parts])[plan.rows]
    return [
        replace(part, q=offered.q[plan.rows[numbers == number]])
        for number, part in enumerate(parts)
        if (numbers == number).any()
    ]


def _unmeasured(poses: Poses) -> Measurements:
    n = len(poses.q)
    return Measurements(poses.q, target=Labels.same(poses.target, n), load=Labels.same(poses.load, n))


def patterns_of(text: str) -> list[str] | None:
    """Patterns of names; None if there are none."""
    return text.split(";") if text else None


def exactly(actual: Robot, poses: Sequence[Poses], kinds: str) -> list[Measurements]:
    """What an instrument without error reads at each lot of poses; those alike are predicted together."""
    together: dict[tuple[str | None, str | None], list[int]] = defaultdict(list)
    for number, part in enumerate(poses):
        together[part.load, part.target].append(number)
    found: dict[int, Measurements] = {}
    for (load, target), numbers in together.items():
        q = np.concatenate([poses[number].q for number in numbers])
        data = simulate(actual, q, kinds=kinds.split(","), load=load, target=target)
        ends = np.cumsum([len(poses[number].q) for number in numbers])
        rows = np.split(np.arange(len(q)), ends[:-1])
        found |= {number: data.take(some) for number, some in zip(numbers, rows, strict=True)}
    return [found[number] for number in range(len(poses))]


def instrument_of(setting: Setting, outliers: float) -> Instrument:
    """The instrument of a setting."""
    kinds = tuple(setting.kinds.split(","))
    size = setting.outlier_size
    return Instrument(kinds, setting.noise, setting.noise_angle, outliers=outliers, outlier_size=size)


def springs_of(actual: Actual, robot: Robot) -> list[str]:
    """The elements of a robot that a study has springs on, as the robot names them."""
    joints = {row.name: row.joint_element for row in robot.joints}
    return [joints.get(name) or name for name in actual.springs]
