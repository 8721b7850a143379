"""What changed between two calibrations of one robot, in units of its uncertainty: drift, or noise?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification import CalibrationResult, IdentifiedParameter, SavedResult
from elastocal.measurements import Measurements
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.robot import Frame
from elastocal.simulation import random_poses
from elastocal.uncertainty import predicted_positions

LEVEL = 0.01
"""Probability of taking noise for drift."""

POSES = 1000
"""Random poses that a change of the flange's position is told of."""

NAMED = 4
"""So many of the parameters that changed most are named."""

Result = CalibrationResult | SavedResult

SYSTEMATIC = 3.0
"""A model's error, which is not by chance, may move what it predicts elsewhere by so many times its size."""

AT_ORIGIN = Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)


@dataclass(frozen=True)
class Change:
    """One parameter in two calibrations; SI.

    Attributes:
        std: standard deviation of `change` that the two calibrations' noise gives it.
    """

    name: str
    unit: str
    before: float
    after: float
    change: float
    std: float

    @property
    def score(self) -> float:
        """The change in units of its standard deviation."""
        if self.std > 0.0:
            return self.change / self.std
        return float(np.copysign(np.inf, self.change)) if self.change else 0.0


@dataclass(frozen=True)
class Difference:
    """Two calibrations of one robot, side by side.

    Attributes:
        robot: its name.
        changes: of the robot's own parameters that both identified.
        frames: of base, stations, tool and targets, which move with the instrument or the probe and tell no drift.
        only_before, only_after: parameters that one of the two identified.
        tested: how many parameters are tested together.
        chi2: of their changes with both covariances.
        probability: of a change as large by noise alone.
        position: change of the flange's position over random poses, root mean square and largest [m], less a move of
            all together, as if the base had moved.
        noise: root mean square that noise gives it [m].
        drift: whether there is more than noise.
        verdict: one sentence.
        warnings: sentences with a remedy.
    """

    robot: str
    changes: tuple[Change, ...]
    frames: tuple[Change, ...]
    only_before: tuple[str, ...]
    only_after: tuple[str, ...]
    tested: int
    chi2: float
    probability: float
    position: tuple[float, float]
    noise: float
    drift: bool
    verdict: str
    warnings: tuple[str, ...]


def difference(before: Result, after: Result, *, poses: int = POSES, seed: int = 0) -> Difference:
    """Compare two calibrations of one robot.

    Args:
        before: the first, as calibrate returned or load_result read it.
        after: the second.
        poses: how many random poses the change of the flange's position is told of.
        seed: of these.

    Raises:
        InputError: they are not of one robot with the same laws of compliance.
    """
    _require_comparable(before, after)
    kinds = {name: parameter.group for name, parameter in parameters_of(before.robot).items()}
    found = list(_changes(before, after))
    own = tuple(change for change in found if kinds.get(change.name) not in FRAME_GROUPS)
    frames = tuple(change for change in found if kinds.get(change.name) in FRAME_GROUPS)
    tested = [c for c in own if c.name in before.names and c.name in after.names]
    chi2, rank, probability = _tested(tested, before, after)
    moved, noise = _at_the_flange(before, after, poses, seed)
    drift = probability < LEVEL
    return Difference(
        robot=after.robot.name,
        changes=own,
        frames=frames,
        only_before=tuple(name for name in before.names if name not in after.names),
        only_after=tuple(name for name in after.names if name not in before.names),
        tested=rank,
        chi2=chi2,
        probability=probability,
        position=moved,
        noise=noise,
        drift=drift,
        verdict=_verdict(tested, rank, probability, moved, noise),
        warnings=tuple(_warnings(before, after, moved[0] if drift else np.inf)),
    )


def _require_comparable(before: Result, after: Result) -> None:
    laws = [{e: found.law for e, found in result.robot.elastic.items()} for result in (before, after)]
    names = [{p.name for p in result.parameters} for result in (before, after)]
    faults = []
    if laws[0] != laws[1]:
        told = (", ".join(f"{e}: {law}" for e, law in found.items()) or "none" for found in laws)
        one, other = told
        faults.append(
            f"the calibrations have different laws of compliance ({one}; {other}): repeat one with the other's"
        )
    elif names[0] != names[1]:
        odd = sorted(names[0] ^ names[1])
        listed = ", ".join(odd[:6]) + (" …" if len(odd) > 6 else "")
        faults.append(f"the calibrations are of different robots: only one of them has the parameters {listed}")
    if faults:
        raise InputError(*faults)


def _changes(before: Result, after: Result) -> Iterator[Change]:
    """The changes of all parameters that both identified."""
    later = {p.name: p for p in after.parameters}
    for p in before.parameters:
        q = later[p.name]
        if p.std is not None and q.std is not None:
            change = q.identified - p.identified
            if p.unit == "rad":  # roll, pitch and yaw jump by a turn
                change = (change + np.pi) % (2.0 * np.pi) - np.pi
            yield Change(p.name, p.unit, p.identified, q.identified, float(change), float(np.hypot(p.std, q.std)))


def _tested(changes: Sequence[Change], before: Result, after: Result) -> tuple[float, int, float]:
    """Chi-square of the changes, how many directions it is of, and the probability of any such change by noise.

    The lesser of two probabilities, doubled: of all changes together (F test), and of the largest alone (Student's t,
    times their number), so that neither many small changes nor one large one goes unseen.
    """
    from scipy.special import fdtrc, stdtr  # imported late: it takes longer than a calibration

    if not changes:
        return 0.0, 0, 1.0
    names = [change.name for change in changes]
    covariance = _block(before, names) + _block(after, names)
    deviation = np.sqrt(np.diag(covariance))
    if not (deviation > 0.0).all():
        return 0.0, 0, 1.0
    scores = np.array([change.change for change in changes]) / deviation
    values, vectors = np.linalg.eigh(covariance / np.outer(deviation, deviation))
    seen = values > 1e-10 * values[-1]
    chi2, rank = float(((vectors.T @ scores)[seen] ** 2 / values[seen]).sum()), int(seen.sum())
    freedom = max(before.freedom + after.freedom, 1.0)
    together = float(fdtrc(rank, freedom, chi2 / rank))
    alone = len(changes) * 2.0 * float(stdtr(freedom, -np.abs(scores).max()))
    return chi2, rank, min(1.0, 2.0 * min(together, alone))


def _block(result: Result, names: Sequence[str]) -> Array:
    index = [result.names.index(name) for name in names]
    return result.covariance[np.ix_(index, index)]


def _at_the_flange(before: Result, after: Result, poses: int, seed: int) -> tuple[tuple[float, float], float]:
    """Change of the flange's position, root mean square and largest, and what noise gives it [m].

    Less a move of all positions together, which the base frame makes up for: where the robot stands and where its first
    axis is are told by the same data, and errors of the one are errors of the other.
    """
    q = random_poses(before.robot, poses, seed)
    found = [_positions(_bare(result), q) for result in (before, after)]
    together = _rigid_moves(found[0][0])
    left = (found[1][0] - found[0][0]).ravel()
    lengths = np.linalg.norm((left - together @ (together.T @ left)).reshape(-1, 3), axis=1)
    noise = 0.0
    for result, (_, columns) in zip((before, after), found, strict=True):
        free = columns - together @ (together.T @ columns)
        noise += float(((free @ _bare(result).covariance) * free).sum()) / len(q)
    return (float(np.sqrt((lengths**2).mean())), float(lengths.max())), float(np.sqrt(noise))


def _positions(result: Result, q: Array) -> tuple[Array, Array]:
    """Positions (poses, 3) and what they change with the parameters (3 poses, names)."""
    position, columns = np.empty((len(q), 3)), np.empty((len(q), 3, len(result.names)))
    for rows, predicted, part in predicted_positions(result, Measurements(q)):
        position[rows], columns[rows] = predicted, part.transpose(2, 0, 1)
    return position, columns.reshape(3 * len(q), -1)


def _rigid_moves(position: Array) -> Array:
    """Small moves of all positions (n, 3) together, orthonormal (3 n, 6 or fewer)."""
    arms = position - position.mean(axis=0)
    moves = [np.broadcast_to(axis, arms.shape) for axis in np.eye(3)] + [np.cross(axis, arms) for axis in np.eye(3)]
    return np.linalg.qr(np.stack([move.ravel() for move in moves], axis=1))[0]


def _bare(result: Result) -> Result:
    """The robot alone: seen from its base, without tool and targets, with what is known of its own parameters."""
    own = [name for name in result.names if name.split(".")[0] not in ("base", "station", "tool", "target")]
    robot = replace(result.robot, base=AT_ORIGIN, tool=AT_ORIGIN, targets={}, stations={})
    return replace(result, robot=robot, names=tuple(own), covariance=_block(result, own))


def _verdict(changes: Sequence[Change], rank: int, probability: float, moved: tuple[float, float], noise: float) -> str:
    rms, largest = (1e3 * value for value in moved)
    if probability >= LEVEL:
        return (
            f"Noise: the calibrations agree within their uncertainty (p = {probability:.2g} over {rank} parameters); "
            f"at the flange they differ by {rms:.3g} mm rms, where noise alone gives {1e3 * noise:.3g} mm."
        )
    most = sorted(changes, key=lambda change: -abs(change.score))[:NAMED]
    named = ", ".join(f"{change.name} ({change.score:+.1f} std)" for change in most)
    return (
        f"Drift: more changed than noise explains (p = {probability:.1g}), most of all {named}; at the flange "
        f"{rms:.3g} mm rms and {largest:.3g} mm at most, where noise alone gives {1e3 * noise:.3g} mm rms."
    )


def _warnings(before: Result, after: Result, drift: float) -> Iterator[str]:
    unexplained = max(np.sqrt(3.0) * result.model_sigma.get("position", 0.0) for result in (before, after))
    if drift < SYSTEMATIC * unexplained:
        yield (
            f"the calibrations leave {1e3 * unexplained:.3g} mm rms unexplained: unless that is the instrument's "
            "noise, it may look like drift where the two were measured at different poses; measure the same ones to be "
            "sure"
        )
    for when, result in (("first", before), ("second", after)):
        if result.status != "converged":
            yield f"the {when} calibration is {result.status.replace('_', ' ')}: what it says is not to be relied on"
    if before.robot.name != after.robot.name:
        yield f"the robots have different names, {before.robot.name} and {after.robot.name}: are they one?"
    if set(before.names) != set(after.names):
        yield (
            "they did not identify the same parameters, so that the common ones need not mean the same: repeat one "
            "with the request of the other"
        )
    kept = _kept(before)
    moved = [p.name for p in after.parameters if p.name in kept and _differs(kept[p.name], p)]
    if moved:
        listed = ", ".join(moved[:6]) + (f" and {len(moved) - 6} more" if len(moved) > 6 else "")
        yield (
            f"values that neither identified differ ({listed}): the calibrations began from different nominal robots, "
            "and what was identified differs with them"
        )


def _kept(result: Result) -> Mapping[str, IdentifiedParameter]:
    return {p.name: p for p in result.parameters if p.name not in result.names and p.std is None}


def _differs(p: IdentifiedParameter, q: IdentifiedParameter) -> bool:
    return q.std is None and abs(p.identified - q.identified) > 1e-9 * max(1.0, abs(p.identified))
