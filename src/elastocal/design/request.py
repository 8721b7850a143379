"""What is asked of a plan, checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.chain import Array
from elastocal.design.criteria import CRITERIA
from elastocal.design.task import Reading
from elastocal.errors import InputError, unknown_name
from elastocal.identification.transition import GeneticSearch, Transition
from elastocal.measurements import KINDS, SAME_POSE, Labels, Measurements
from elastocal.robot import Robot

AVERAGED = ("O1", "accuracy")
"""Criteria that are averaged over places of a target of which nobody knows where it sits, and over torques."""


@dataclass(frozen=True)
class Request:
    """What is asked of a plan.

    Attributes:
        count: how many poses.
        criterion: of CRITERIA.
        reading: how they will be measured.
        elastic, transition, identify, fix: as for `calibrate`.
        apart: least difference of two poses in at least one joint, of all or of each [rad or m].
        start: (joints,) where the robot is at first; None: anywhere.
        seed: of all chance.

    Raises:
        InputError: with every fault.
    """

    count: int
    criterion: str = "O1"
    reading: Reading = field(default_factory=Reading)
    elastic: Mapping[str, str] = field(default_factory=dict)
    transition: Transition = "exact"
    identify: Sequence[str] | None = None
    fix: Sequence[str] = ()
    apart: float | Sequence[float] = SAME_POSE
    start: Sequence[float] | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise InputError(*faults)

    def _faults(self) -> Iterator[str]:
        if self.count < 1:
            yield f"expected 1 pose or more to choose, found {self.count}"
        if self.criterion not in CRITERIA:
            yield unknown_name("criterion", self.criterion, CRITERIA)
        if not self.reading.kinds:
            yield f"expected something to measure, found no kind (valid: {', '.join(KINDS)})"
        yield from (unknown_name("kind", kind, KINDS) for kind in self.reading.kinds if kind not in KINDS)
        for name, value in (("noise", self.reading.noise), ("noise_angle", self.reading.noise_angle)):
            if not (np.isfinite(value) and value > 0.0):
                yield f"{name}: expected a positive number, found {value:g}"

    def distances(self, robot: Robot) -> Array:
        """Least differences (joints,).

        Raises:
            InputError: they are not positive, or not one or as many as joints.
        """
        found = np.atleast_1d(np.asarray(self.apart, dtype=float))
        if found.shape not in ((1,), (robot.positions,)) or not (found > 0.0).all():
            raise InputError(f"apart: expected one positive number or {robot.positions}, found {self.apart}")
        return np.broadcast_to(found, (robot.positions,)).copy()

    def position(self, robot: Robot) -> Array | None:
        """Where the robot is at first, (joints,).

        Raises:
            InputError: not a number for each joint.
        """
        if self.start is None:
            return None
        found = np.asarray(self.start, dtype=float)
        if found.shape != (robot.positions,) or not np.isfinite(found).all():
            raise InputError(f"start: expected {robot.positions} joint positions, found {found.tolist()}")
        return found

    @property
    def settings(self) -> dict[str, object]:
        """All of it, as the plan keeps it."""
        how: object = self.transition
        if isinstance(how, GeneticSearch):
            how = {"method": "ga", "population": how.population, "generations": how.generations}
        return {
            "count": self.count,
            "criterion": self.criterion,
            "kinds": list(self.reading.kinds),
            "noise": self.reading.noise,
            "noise_angle": self.reading.noise_angle,
            "elastic": dict(self.elastic),
            "transition": how if isinstance(how, (str, dict)) else list(self.transition),  # type: ignore[arg-type]
            "identify": None if self.identify is None else list(self.identify),
            "fix": list(self.fix),
            "apart": np.atleast_1d(self.apart).tolist(),
            "start": None if self.start is None else list(self.start),
            "seed": self.seed,
        }


def poses_of(robot: Robot, given: Array | Measurements, what: str) -> Measurements:
    """Poses as Measurements, whose target is the robot's if it has one; what was observed there is left out.

    Args:
        robot: whose joints they are of.
        given: (n, joints) joint positions, or Measurements.
        what: they are, for the message.

    Raises:
        InputError: other numbers of joints, a position that is no number, a target that is not said.
    """
    data = given if isinstance(given, Measurements) else Measurements(np.atleast_2d(np.asarray(given, dtype=float)))
    if data.q.ndim != 2 or data.q.shape[1] != robot.positions:
        raise InputError(f"{what}: expected (poses, {robot.positions}) joint positions, found {data.q.shape}")
    bad = np.flatnonzero(~np.isfinite(data.q).all(axis=1))
    if len(bad):
        raise InputError(f"{what}: expected numbers, found {data.q[bad[0]].tolist()} in pose {bad[0] + 1}")
    target = data.target
    if target is None and len(robot.targets) == 1:
        target = Labels.same(next(iter(robot.targets)), len(data))
    if len(robot.targets) > 1 and (target is None or (target.codes < 0).any()):
        raise InputError(f"{what}: expected each pose to name one of the targets {', '.join(robot.targets)}")
    faults = []
    for kind, labels, valid in (
        ("target", target, robot.targets),
        ("load", data.load, robot.loads),
        ("station", data.station, robot.stations),
    ):
        names = labels.names if labels is not None else ()
        faults += [f"{what}: {unknown_name(kind, name, valid)}" for name in names if name not in valid]
    if faults:
        raise InputError(*faults)
    return replace(Measurements(data.q), target=target, load=data.load, station=data.station, wrench=data.wrench)
