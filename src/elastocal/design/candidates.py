"""Candidates to choose from: drawn within the joint limits, or given, and kept where the surroundings allow them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.design.links import posture
from elastocal.design.surroundings import Box, Scene, Surroundings, scene
from elastocal.errors import InputError
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.robot import Robot, assemble
from elastocal.simulation import draw

TRIES_PER_POSE = 20
"""Poses drawn for each that is wanted, before there are no more to be had."""

WORKSPACE_POSES = 1000
"""Poses that stand for a workspace."""

WORKSPACE_TRIES = 400_000
"""Poses drawn to find them."""


class Candidates(NamedTuple):
    """Poses to choose from, and how many were looked at for them."""

    poses: Measurements
    tried: int


Labelled = tuple[str | None, str | None]
"""A payload and a target."""


def draw_candidates(
    robot: Robot,
    pool: int,
    needed: int,
    surroundings: Surroundings,
    *,
    station: str | None = None,
    targets: Sequence[str | None] = (None,),
    loads: Sequence[str | None] = (None,),
    seed: int | np.random.Generator = 0,
) -> Candidates:
    """Poses at random within the joint limits that the surroundings allow, shared out among payloads and targets.

    Args:
        robot: whose joint limits they keep to.
        pool: how many are wanted.
        needed: how many there must be.
        surroundings: what rejects a pose.
        station: the instrument's station; None: the robot's base.
        targets: which are measured; None: the tool's origin.
        loads: which payloads are carried; None: no payload.
        seed: of the poses.

    Raises:
        InputError: too few are found; says which constraint rejects how many.
    """
    rng, settings = np.random.default_rng(seed), list(product(loads, targets))
    parts, tried, rejected = [], 0, Counter[str]()
    for number, (load, target) in enumerate(settings):
        share = len(range(number, pool, len(settings)))
        found = draw(robot, share, rng, scene(robot, surroundings, station, target).rejected, TRIES_PER_POSE * share)
        parts.append(_labelled(found.q, station, target, load))
        tried, rejected = tried + found.tried, rejected + found.rejected
    poses = concatenate(parts)
    if len(poses) < needed:
        raise InputError(_too_few(len(poses), needed, tried, rejected, "drawn within the joint limits"))
    return Candidates(poses, tried)


def kept_candidates(robot: Robot, given: Measurements, needed: int, surroundings: Surroundings) -> Candidates:
    """Those of the given poses that the surroundings allow.

    Raises:
        InputError: too few are left; says which constraint rejects how many.
    """
    allowed, rejected = np.ones(len(given), dtype=bool), Counter[str]()
    for part in given.combinations:
        for name, miss in scene(robot, surroundings, part.station, part.target).rejected(given.q[part.rows]).items():
            rejected[name] += int(miss.sum())
            allowed[part.rows[miss]] = False
    if allowed.sum() < needed:
        raise InputError(_too_few(int(allowed.sum()), needed, len(given), rejected, "candidates given"))
    return Candidates(given.take(np.flatnonzero(allowed)), len(given))


def _too_few(found: int, needed: int, tried: int, rejected: Counter[str], what: str) -> str:
    told = f"found {found} candidates, expected at least {needed}: of {tried} {what}"
    shares = [f"{name} rejects {number}" for name, number in rejected.most_common() if number]
    return f"{told}, {', '.join(shares)}; widen what rejects most" if shares else f"{told}; offer more"


def draw_workspace(
    robot: Robot,
    box: Box | None,
    surroundings: Surroundings,
    like: Measurements,
    seed: int | np.random.Generator = 0,
) -> Measurements:
    """Poses that stand for the workspace: within the joint limits, clear of floor and boxes, the target within a box.

    Args:
        robot: whose workspace it is.
        box: lowest and highest x, y and z in the base frame [m]; None: wherever the robot reaches.
        surroundings: floor and boxes; what the instrument sees does not matter.
        like: poses whose targets, payloads and stations are those of the workspace.
        seed: of the poses.

    Raises:
        InputError: no pose is within the box.
    """
    rng, parts, tried = np.random.default_rng(seed), [], 0
    rejected = Counter[str]()
    combinations = like.combinations
    for found in combinations:
        share = -(-WORKSPACE_POSES // len(combinations))
        misses = partial(_misses, scene(robot, surroundings.unseen(), found.station, found.target), box)
        drawn = draw(robot, share, rng, misses, WORKSPACE_TRIES // len(combinations))
        tried, rejected = tried + drawn.tried, rejected + drawn.rejected
        parts.append(_labelled(drawn.q, found.station, found.target, found.load))
    poses = concatenate(parts)
    if not len(poses):
        raise InputError(_too_few(0, 1, tried, rejected, "drawn for the workspace"))
    return poses


def _misses(at: Scene, box: Box | None, q: Array) -> dict[str, NDArray[np.bool_]]:
    """Which poses (n, joints) are not of the workspace, (n,) by reason."""
    if box is None:
        return at.rejected(q)
    low, high = np.array(box)[..., None].swapaxes(0, 1)
    position = posture(assemble(at.robot, None, at.target, None), q).target
    return {"the workspace": ((position < low) | (position > high)).any(axis=0)} | at.rejected(q)


def _labelled(q: Array, station: str | None, target: str | None, load: str | None) -> Measurements:
    n = len(q)
    return Measurements(q, target=Labels.same(target, n), load=Labels.same(load, n), station=Labels.same(station, n))
