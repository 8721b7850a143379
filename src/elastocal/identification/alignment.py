"""First alignment in closed form: where the instrument stands and what the flange carries, from no first guess.

With the flange's pose (R, t) in the base frame from the nominal robot, a target at y in the flange frame is seen at m:
A m + c = R y + t, where A and c are base_T_instrument. That is linear in A, c and y; A is then made a rotation and the
rest solved for again. Where orientations M are measured, A M = R B with the target's rotation B in the flange frame is
solved first (the robot-world and hand-eye equation). Where only distances d are, |R y + t - s|^2 = d^2 is linear in y,
in the instrument's place s, in the products s y^T and in |y|^2 + |s|^2; where s is known, in y and |y|^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.chain import Array
from elastocal.measurements import Combination, Measurements
from elastocal.prediction import predict
from elastocal.robot import Frame, Robot

SAMPLE = 500
"""Rows of one combination that suffice for a first alignment."""


@dataclass(frozen=True)
class _Sample:
    """Some rows of one combination: flange poses in the base frame, and the observations of the target by kind."""

    station: str
    target: str
    rotation: Array
    translation: Array
    observed: Mapping[str, Array]


@dataclass
class _Placed:
    """What is known so far, rotations apart: base_T_instrument by station, flange_T_target by target."""

    turned: dict[str, Array] = field(default_factory=dict)
    shifted: dict[str, Array] = field(default_factory=dict)


def align(robot: Robot, data: Measurements) -> Robot:
    """Put the frames that are not known where the data have them, the rest of the robot as it is.

    What the data do not place (the orientation of a point) stays as the robot has it.
    """
    samples = [_sample(robot, data, found) for found in data.combinations]
    placed = _what_is_known(robot, samples)
    _solve_rotations(placed, [s for s in samples if "orientation" in s.observed])
    _solve_positions(placed, [s for s in samples if "position" in s.observed])
    for sample in samples:
        if "distance" in sample.observed and not {sample.station, sample.target} <= placed.shifted.keys():
            _solve_distances(placed, sample)
    return _with_placed(robot, placed, samples)


def _sample(robot: Robot, data: Measurements, found: Combination) -> _Sample:
    rows = found.rows[:: max(1, len(found.rows) // SAMPLE)]
    bare = replace(robot, base=Frame(known=True), tool=Frame(known=True))
    wrench = None if data.wrench is None else data.wrench[rows]
    translation, rotation = predict(bare, data.q[rows], load=found.load, wrench=wrench)
    return _Sample(
        station="base" if found.station is None else f"station.{found.station}",
        target="tool" if found.target is None else f"target.{found.target}",
        rotation=rotation,
        translation=translation,
        observed={kind: data.observed(kind)[rows] for kind in found.kinds},
    )


def _what_is_known(robot: Robot, samples: Sequence[_Sample]) -> _Placed:
    placed = _Placed()
    for sample in samples:
        station, target = robot.frames[sample.station], robot.frames[sample.target]
        if station.known:
            placed.turned[sample.station] = station.rotation.T
            placed.shifted[sample.station] = -station.rotation.T @ station.translation
        if robot.tool.known and target.known:
            local = Frame() if sample.target == "tool" else target
            placed.turned[sample.target] = robot.tool.rotation @ local.rotation
            placed.shifted[sample.target] = robot.tool.rotation @ local.translation + robot.tool.translation
    return placed


class _Linear:
    """Linear least squares with named blocks of unknowns."""

    def __init__(self) -> None:
        self._terms: list[tuple[dict[str, Array], Array]] = []

    @property
    def unknowns(self) -> bool:
        """Whether there is anything to solve for."""
        return any(blocks for blocks, _ in self._terms)

    def add(self, blocks: dict[str, Array], right: Array, known: Mapping[str, Array]) -> None:
        """Add equations sum(block (m, k) @ value (k,)) = right (m,), where some values are known already."""
        for name in blocks.keys() & known.keys():
            right = right - blocks[name] @ known[name].ravel()
        self._terms.append(({name: block for name, block in blocks.items() if name not in known}, right))

    def solve(self) -> tuple[dict[str, Array], bool]:
        """The unknowns by name, and whether the equations determine them.

        Homogeneous equations are solved up to a common factor.
        """
        widths = {name: block.shape[1] for blocks, _ in self._terms for name, block in blocks.items()}
        starts = dict(zip(widths, np.cumsum([0, *widths.values()])[:-1].tolist(), strict=True))
        right = np.concatenate([right for _, right in self._terms])
        matrix = np.zeros((len(right), sum(widths.values())))
        row = 0
        for blocks, part in self._terms:
            for name, block in blocks.items():
                matrix[row : row + len(part), starts[name] : starts[name] + widths[name]] = block
            row += len(part)
        left, sizes, rows = np.linalg.svd(matrix, full_matrices=False)
        if right.any():
            determined = len(right) >= matrix.shape[1] and sizes[-1] > 1e-6 * sizes[0]
            inverse = np.where(sizes > 1e-9 * sizes[0], 1.0 / np.maximum(sizes, 1e-300), 0.0)
            values = rows.T @ (inverse * (left.T @ right))
        else:
            determined = len(sizes) > 1 and sizes[-2] > 1e-6 * sizes[0]
            values = rows[-1]
        return {name: values[start : start + widths[name]] for name, start in starts.items()}, bool(determined)


def _solve_rotations(placed: _Placed, samples: Sequence[_Sample]) -> None:
    """Solve A M = R B for the stations' A and the targets' B."""
    system = _Linear()
    for s in samples:
        n = len(s.rotation)
        seen = np.einsum("ac,nbd->nabcd", np.eye(3), s.observed["orientation"].transpose(0, 2, 1)).reshape(9 * n, 9)
        carried = np.einsum("nac,bd->nabcd", s.rotation, np.eye(3)).reshape(9 * n, 9)
        system.add({s.station: seen, s.target: -carried}, np.zeros(9 * n), placed.turned)
    if not system.unknowns:
        return
    found, _ = system.solve()
    matrices = {name: values.reshape(3, 3) for name, values in found.items()}
    sign = np.sign(np.linalg.det(next(iter(matrices.values())))) or 1.0
    placed.turned |= {name: _nearest_rotation(sign * matrix) for name, matrix in matrices.items()}


def _solve_positions(placed: _Placed, samples: Sequence[_Sample]) -> None:
    """Solve A m + c = R y + t for the stations' A and c and the targets' y."""
    if not samples:
        return
    turning = {s.station for s in samples} - placed.turned.keys()
    found, determined = _linear_positions(placed, samples)
    if turning and determined:
        placed.turned |= {name: _nearest_rotation(found[f"{name} turn"].reshape(3, 3)) for name in turning}
        found, _ = _linear_positions(placed, samples)
    elif turning:  # too few poses, or too much alike: from targets at the flange, rotation and translation in turn
        found = {s.target: np.zeros(3) for s in samples}
        for _ in range(ALTERNATIONS):
            carried = placed.shifted | found
            for name in turning:
                mine = [s for s in samples if s.station == name]
                there = np.concatenate([s.rotation @ carried[s.target] + s.translation for s in mine])
                placed.turned[name] = _rotation_between(np.concatenate([s.observed["position"] for s in mine]), there)
            found, _ = _linear_positions(placed, samples)
    placed.shifted |= {name: value for name, value in found.items() if not name.endswith(" turn")}


ALTERNATIONS = 50


def _linear_positions(placed: _Placed, samples: Sequence[_Sample]) -> tuple[dict[str, Array], bool]:
    system = _Linear()
    for s in samples:
        n = len(s.rotation)
        seen = (np.eye(3)[:, :, None] * s.observed["position"][:, None, None]).reshape(3 * n, 9)
        blocks = {
            s.station: np.tile(np.eye(3), (n, 1)),
            s.target: -s.rotation.reshape(3 * n, 3),
            f"{s.station} turn": seen,
        }
        known = placed.shifted | {f"{name} turn": turn for name, turn in placed.turned.items()}
        system.add(blocks, s.translation.ravel(), known)
    return system.solve() if system.unknowns else ({}, True)


def _solve_distances(placed: _Placed, s: _Sample) -> None:
    """Solve |R y + t - p|^2 = d^2 for the instrument's place p in the base frame and y, or for one of the two."""
    squares = s.observed["distance"] ** 2
    n = len(squares)
    system = _Linear()
    if s.station in placed.shifted:
        away = s.translation - placed.shifted[s.station]
        blocks = {s.target: 2.0 * np.einsum("na,nab->nb", away, s.rotation), "square": np.ones((n, 1))}
        system.add(blocks, squares - (away**2).sum(axis=1), {})
    elif s.target in placed.shifted:
        point = s.rotation @ placed.shifted[s.target] + s.translation
        system.add({"place": -2.0 * point, "square": np.ones((n, 1))}, squares - (point**2).sum(axis=1), {})
    else:
        blocks = {
            "place": -2.0 * s.translation,
            s.target: 2.0 * np.einsum("na,nab->nb", s.translation, s.rotation),
            "product": -2.0 * s.rotation.reshape(n, 9),
            "square": np.ones((n, 1)),
        }
        system.add(blocks, squares - (s.translation**2).sum(axis=1), {})
    found, _ = system.solve()
    placed.turned.setdefault(s.station, np.eye(3))  # distances do not tell how the instrument is turned
    if "place" in found:
        placed.shifted[s.station] = found["place"]
    if s.target in found:
        placed.shifted[s.target] = found[s.target]


def _with_placed(robot: Robot, placed: _Placed, samples: Sequence[_Sample]) -> Robot:
    """Frames from transforms: base_T_instrument inverted; flange_T_target shared between the tool and the targets."""
    frames = {}
    for station in {s.station for s in samples}:
        frame = robot.frames[station]
        if not frame.known:
            turn = placed.turned.get(station, frame.rotation.T)
            shift = placed.shifted.get(station, -turn @ frame.translation)
            frames[station] = frame.at(-turn.T @ shift, turn.T)
    targets = {s.target for s in samples}
    held = {name: Frame() if name == "tool" else robot.frames[name] for name in targets}
    tool = robot.tool
    if not tool.known:
        known = sorted(name for name in targets if name == "tool" or held[name].known)
        tool = frames["tool"] = _tool_from_targets(tool, placed, {name: held[name] for name in known})
    for name in targets - {"tool"}:
        if not held[name].known:
            turn = placed.turned.get(name, tool.rotation @ held[name].rotation)
            shift = placed.shifted.get(name, tool.rotation @ held[name].translation + tool.translation)
            frames[name] = held[name].at(tool.rotation.T @ (shift - tool.translation), tool.rotation.T @ turn)
    return robot.with_frames(frames)


def _tool_from_targets(tool: Frame, placed: _Placed, known: dict[str, Frame]) -> Frame:
    """The tool that puts known targets where they were found in the flange frame."""
    turns = [placed.turned[name] @ frame.rotation.T for name, frame in known.items() if name in placed.turned]
    shifted = [name for name in known if name in placed.shifted]
    local = np.array([known[name].translation for name in shifted]).reshape(-1, 3)
    there = np.array([placed.shifted[name] for name in shifted]).reshape(-1, 3)
    rotation = tool.rotation
    if turns:
        rotation = _nearest_rotation(np.sum(turns, axis=0))
    elif len(shifted) >= 3:
        rotation = _rotation_between(local, there)
    translation = (there - local @ rotation.T).mean(axis=0) if shifted else tool.translation
    return tool.at(translation, rotation)


def _nearest_rotation(matrix: Array) -> Array:
    left, _, right = np.linalg.svd(matrix)
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right


def _rotation_between(points: Array, there: Array) -> Array:
    """The rotation that takes points (n, 3), less their mean, nearest to others (Kabsch, 1976)."""
    return _nearest_rotation((there - there.mean(axis=0)).T @ (points - points.mean(axis=0)))
