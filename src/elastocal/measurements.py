"""Measurements: what was observed, at which joint positions, with which target, payload and station."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array

KINDS = ("position", "orientation", "distance")
"""What an observation can consist of; a row may have several."""

FEW_ROWS = 500
"""Up to so many rows all pairs are compared."""

SAME_POSE = 1e-3
"""Joint positions that agree to this [rad or m] are one pose, measured again."""


@dataclass(frozen=True)
class Labels:
    """A column of names: `codes` (n,) point into `names`; -1 where a row has none."""

    names: tuple[str, ...]
    codes: NDArray[np.int32]

    @classmethod
    def none(cls, n: int) -> Labels:
        """No name in any of n rows."""
        return cls((), np.full(n, -1, dtype=np.int32))

    @classmethod
    def of(cls, values: Sequence[str | None]) -> Labels:
        """The names of rows, one each."""
        names = tuple(dict.fromkeys(value for value in values if value is not None))
        index = {name: code for code, name in enumerate(names)} | {None: -1}
        return cls(names, np.array([index[value] for value in values], dtype=np.int32))

    @classmethod
    def same(cls, name: str | None, n: int) -> Labels | None:
        """One name in all of n rows; nothing for none."""
        return None if name is None else cls((name,), np.zeros(n, dtype=np.int32))

    def name(self, code: int) -> str | None:
        """The name of a code."""
        return self.names[code] if code >= 0 else None

    def take(self, rows: NDArray[np.intp]) -> Labels:
        """The labels of some rows."""
        return replace(self, codes=self.codes[rows])

    @classmethod
    def joined(cls, parts: Sequence[Labels]) -> Labels:
        """Labels one after the other."""
        names = tuple(dict.fromkeys(name for part in parts for name in part.names))
        codes = []
        for part in parts:
            lookup = np.array([names.index(name) for name in part.names] + [-1], dtype=np.int32)
            codes.append(lookup[part.codes])
        return cls(names, np.concatenate(codes))


class Combination(NamedTuple):
    """Rows that observe the same kinds of the same target, from one station, with one payload."""

    rows: NDArray[np.intp]
    kinds: tuple[str, ...]
    station: str | None
    target: str | None
    load: str | None


@dataclass(frozen=True)
class Measurements:
    """Observations, one a row; SI units, instrument frame. NaN where a row lacks what other rows have.

    Attributes:
        q: (n, joints) the controller's joint positions [rad or m].
        position: (n, 3) of the target [m].
        orientation: (n, 3, 3) rotations of the target.
        distance: (n,) of the target from the instrument's origin [m].
        sigma: (n, 3) standard deviations of the position, or of the distance (first column) [m]; NaN: not known.
        sigma_angle: (n,) standard deviation of the orientation about each axis [rad]; NaN: not known.
        target, load, station: names in the robot.
        wrench: (n, 6) external wrench on the tool, force first, in the tool's frame [N, N m].
        pose: (n,) pose numbers, shared by repeats; -1 where none is given.
        temperature: (n,) [degC].
        source: the file of each row, with `row` (n,) its number there, from 1.
    """

    q: Array
    position: Array | None = None
    orientation: Array | None = None
    distance: Array | None = None
    sigma: Array | None = None
    sigma_angle: Array | None = None
    target: Labels | None = None
    load: Labels | None = None
    station: Labels | None = None
    wrench: Array | None = None
    pose: NDArray[np.int64] | None = None
    temperature: Array | None = None
    source: Labels | None = None
    row: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return len(self.q)

    def take(self, rows: NDArray[np.intp]) -> Measurements:
        """The measurements of some rows."""
        chosen: dict[str, Any] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                chosen[field.name] = value.take(rows) if isinstance(value, Labels) else value[rows]
        return Measurements(**chosen)

    def observed(self, kind: str) -> Array:
        """The observations of a kind, which there must be: (n, 3), (n, 3, 3) or (n,)."""
        values: Array = getattr(self, kind)
        return values

    def measures(self, kind: str) -> NDArray[np.bool_]:
        """Which rows have an observation of a kind, (n,)."""
        values = getattr(self, kind)
        if values is None:
            return np.zeros(len(self), dtype=bool)
        return np.isfinite(values.reshape(len(self), -1)[:, 0])

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """The rows by what they observe, with which station, target and payload."""
        labels = {"station": self.station, "target": self.target, "load": self.load}
        measured = {kind: self.measures(kind) for kind in KINDS}
        key = np.zeros(len(self), dtype=np.int64)
        for label in labels.values():
            if label is not None:
                key = key * (len(label.names) + 1) + label.codes + 1
        for present in measured.values():
            key = key * 2 + present
        found = []
        for value in np.unique(key).tolist() if (key != key[:1]).any() else key[:1].tolist():
            rows = np.flatnonzero(key == value)
            names = {
                name: None if label is None else label.name(int(label.codes[rows[0]])) for name, label in labels.items()
            }
            kinds = tuple(kind for kind, present in measured.items() if present[rows[0]])
            found.append(Combination(rows, kinds, **names))
        return tuple(found)

    def origin(self, row: int) -> tuple[str, int]:
        """The file that a row comes from, and its number there; no file and its number here if it is not from one."""
        if self.source is None or self.row is None:
            return "", row + 1
        return self.source.name(int(self.source.codes[row])) or "", int(self.row[row])

    def place(self, row: int) -> str:
        """Where a row comes from: "fit.csv row 12"."""
        file, number = self.origin(row)
        return f"{file} row {number}".lstrip()


def concatenate(parts: Sequence[Measurements]) -> Measurements:
    """Measurements one after the other; what a part lacks is NaN, no name, no wrench. Pose numbers stay apart."""
    if len(parts) == 1:
        return parts[0]
    joined: dict[str, Any] = {}
    for field in fields(Measurements):
        columns = [getattr(part, field.name) for part in parts]
        given = next((column for column in columns if column is not None), None)
        if field.name == "pose" and given is not None:
            joined["pose"] = _joined_poses(parts)
        elif isinstance(given, Labels):
            labels = [Labels.none(len(p)) if c is None else c for p, c in zip(parts, columns, strict=True)]
            joined[field.name] = Labels.joined(labels)
        elif field.name == "row" and given is not None:
            joined["row"] = np.concatenate([np.arange(1, len(p) + 1) if p.row is None else p.row for p in parts])
        elif given is not None:
            lacking = 0.0 if field.name == "wrench" else np.nan
            shape = given.shape[1:]
            whole = [
                np.full((len(p), *shape), lacking) if c is None else c for p, c in zip(parts, columns, strict=True)
            ]
            joined[field.name] = np.concatenate(whole)
    return Measurements(**joined)


def _joined_poses(parts: Sequence[Measurements]) -> NDArray[np.int64]:
    poses, offset = [], 0
    for part in parts:
        pose = np.full(len(part), -1) if part.pose is None else part.pose
        poses.append(np.where(pose >= 0, pose + offset, -1))
        offset += int(pose.max(initial=-1)) + 1
    return np.concatenate(poses)


def repeats(data: Measurements) -> NDArray[np.intp]:
    """A number for each row, the same for rows of one pose: by pose number, or joints that agree to SAME_POSE."""
    if data.pose is None and _all_apart(data.q):
        return np.arange(len(data))
    # imported late: it takes longer than a calibration
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    n = len(data)
    pairs = cKDTree(data.q).query_pairs(SAME_POSE, p=np.inf, output_type="ndarray")
    if data.pose is not None:
        numbered = np.flatnonzero(data.pose >= 0)
        _, first = np.unique(data.pose[numbered], return_index=True)
        leader = numbered[first][np.unique(data.pose[numbered], return_inverse=True)[1]]
        pairs = np.concatenate([pairs, np.stack([numbered, leader], axis=1)])
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return connected_components(graph, directed=False)[1]


def _all_apart(q: Array) -> bool:
    """Whether few joint positions (n, joints) are all different, which is soon seen."""
    if len(q) > FEW_ROWS:
        return False
    apart = (np.abs(q[:, None] - q[None]) > SAME_POSE).any(axis=2)
    return bool(apart.sum() == len(q) * (len(q) - 1))


def split(data: Measurements, fraction: float, seed: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows to fit and rows to hold out, the latter about `fraction` of all; the rows of one pose stay together."""
    pose = repeats(data)
    count = pose.max(initial=-1) + 1
    order = np.random.default_rng(seed).permutation(count)
    sizes = np.bincount(pose, minlength=count)[order]
    held_poses = np.zeros(count, dtype=bool)
    held_poses[order[: np.searchsorted(np.cumsum(sizes), fraction * len(data), side="left") + 1]] = True
    held = held_poses[pose]
    return np.flatnonzero(~held), np.flatnonzero(held)


def folded(data: Measurements, folds: int, seed: int) -> NDArray[np.intp]:
    """A number from 0 to folds - 1 for each row: parts of about equal size; the rows of one pose stay together."""
    pose = repeats(data)
    count = pose.max(initial=-1) + 1
    order = np.random.default_rng(seed).permutation(count)
    ends = np.cumsum(np.bincount(pose, minlength=count)[order])
    part = np.empty(count, dtype=int)
    part[order] = np.minimum((ends - 1) * folds // max(len(data), 1), folds - 1)
    return part[pose]
