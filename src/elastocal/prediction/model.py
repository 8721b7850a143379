"""Where model meets data: predicted, residual and Jacobian, block by block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, place, rotation_vectors
from elastocal.elasticity import Equilibrium, Spring, at_deflections, settle
from elastocal.errors import EquilibriumError
from elastocal.measurements import Combination, Measurements
from elastocal.prediction.columns import fill_jacobian, target_position, target_rotation
from elastocal.robot import Assembly, Robot, assemble, harmonics

BLOCK, LEAST_BLOCK, COLUMNS = 4000, 250, 40
"""Poses worked through at once: enough that NumPy's overhead does not count, few enough that a block stays in cache;
fewer where there are more columns than COLUMNS."""

np.empty(2**20)
# The allocator of Linux gives freed blocks back to the system and faults them in again, which takes as long as the
# whole prediction. Freeing one large array raises the size from which it does so; hence the line above.


def kind_of(channel: str) -> str:
    """The kind of observation, of KINDS, of a channel: "position" of "position north"."""
    return channel.partition(" ")[0]


class MapColumns(NamedTuple):
    """The coefficients of one joint map among the parameters.

    Attributes:
        element: index of the driven element in the chain.
        row: of the element among the moving ones.
        joint: of the model.
        orders: how many the map has.
        chosen: which of its harmonics, (k,).
        columns: the parameters that these are, (k,).
    """

    element: int
    row: int
    joint: int
    orders: int
    chosen: NDArray[np.intp]
    columns: NDArray[np.intp]


class Block(NamedTuple):
    """Some rows at rest, with the harmonics (k, n) of each joint map that is identified."""

    rows: NDArray[np.intp]
    state: Equilibrium
    harmonics: list[Array]


@dataclass(frozen=True)
class Setup:
    """The rows of the data that one assembly predicts.

    Attributes:
        rows: (n,) in the data.
        kinds: what these rows observe, of KINDS.
        elements: indices of the identified elements in the chain, ascending.
        coefficients: (spring, number of coefficient) of the identified coefficients; after a law's last one, its
            transition torque.
        columns: the parameters that elements and coefficients are, in this order.
        maps: the identified joint maps.
        station: from which they are observed; "" where all data are from one.
    """

    assembly: Assembly
    rows: NDArray[np.intp]
    kinds: tuple[str, ...]
    elements: NDArray[np.intp]
    coefficients: list[tuple[int, int]]
    columns: NDArray[np.intp]
    maps: list[MapColumns]
    station: str

    @property
    def springs(self) -> tuple[str, ...]:
        """Names of the elements that give way, in chain order."""
        mechanism = self.assembly.mechanism
        return tuple(mechanism.chain.elements[i].name for i in mechanism.elastic)


class Part(NamedTuple):
    """One kind of observation in one block of rows.

    Attributes:
        kind: of KINDS.
        rows: (n,) in the data.
        residual: (3 or 1, n) measured - predicted [m or rad], in the instrument's frame.
        jacobian: (3 or 1, parameters + 1, n) d(predicted)/d(parameter), the residual as its last row; empty without
            derivatives.
        channel: the kind, and where the data come from several stations the station: "position north". What a model
            leaves unexplained may differ between channels.
    """

    kind: str
    rows: NDArray[np.intp]
    residual: Array
    jacobian: Array
    channel: str


@dataclass(frozen=True)
class Model:
    """A robot that predicts data, as a function of displacements of named parameters.

    Attributes:
        robot: where all displacements are zero.
        names: the parameters that are displaced, in the order of `robot.displaced`.
        data: what is predicted.
        sides: by element, loads (n,) over the data's rows that decide the sides of its law whatever the displacements;
            for the elements that are not in it, the loads of the undeflected configuration do.
        weights: (n,) how much each row counts, as so many rows like it; a row of weight 0 is left out. None: all one.
    """

    robot: Robot
    names: tuple[str, ...]
    data: Measurements
    sides: Mapping[str, Array] = field(default_factory=dict)
    weights: Array | None = None

    @cached_property
    def setups(self) -> tuple[Setup, ...]:
        """The assemblies that the data need, with their rows."""
        return tuple(self._setup(found) for found in self.data.combinations)

    def _setup(self, found: Combination) -> Setup:
        assembly = assemble(self.robot, found.station, found.target, found.load)
        chain, elastic = assembly.mechanism.chain, assembly.mechanism.elastic
        columns = {name: column for column, name in enumerate(self.names)}
        elements = sorted(chain.index[name] for name in columns if name in chain.index)
        used = [columns[chain.elements[i].name] for i in elements]
        coefficients = []
        for spring, element in enumerate(elastic):
            for k, coefficient in enumerate((*assembly.springs[spring].law.coefficients, "transition_torque")):
                name = f"{chain.elements[element].name}.{coefficient}"
                if name in columns:
                    coefficients.append((spring, k))
                    used.append(columns[name])
        index, maps = np.array(elements, dtype=int), self._maps(assembly, columns)
        several = len({each.station for each in self.data.combinations}) > 1
        station = (found.station or "base") if several else ""
        return Setup(assembly, found.rows, found.kinds, index, coefficients, np.array(used, dtype=int), maps, station)

    def _maps(self, assembly: Assembly, columns: Mapping[str, int]) -> list[MapColumns]:
        chain, found = assembly.mechanism.chain, []
        for row, (element, drive) in enumerate(zip(chain.moving, assembly.drives, strict=True)):
            if drive.joint is None or drive.error is None:
                continue
            names = [f"{chain.elements[element].name}.{key}" for key in drive.error.coefficients]
            chosen = [i for i, name in enumerate(names) if name in columns]
            if chosen:
                used = np.array([columns[names[i]] for i in chosen])
                orders = len(drive.error.sin)
                found.append(MapColumns(element, row, drive.joint, orders, np.array(chosen), used))
        return found

    def displaced(self, displacements: Array) -> Robot:
        """The robot at displacements (parameters,)."""
        return self.robot.displaced(dict(zip(self.names, displacements.tolist(), strict=True)))

    def parts(self, displacements: Array, derivatives: bool = True, held: bool = False) -> Iterator[Part]:
        """Predict the data at displacements (parameters,), block by block.

        Args:
            displacements: from `robot`.
            derivatives: whether to fill in the Jacobian.
            held: whether deflections are held at zero, as if nothing gave way; the columns of law coefficients are
                then their first effect.

        Raises:
            EquilibriumError: a pose does not settle under its load.
        """
        for setup in self.setups:
            for block in self._at_rest(setup, displacements, held):
                yield from self._observed(setup, block, derivatives, coupled=not held)

    def undeflected_loads(self, displacements: Array) -> dict[str, Array]:
        """Generalised loads [N m or N] of the undeflected configuration, (n,) over the data's rows, by element."""
        loads: dict[str, Array] = {}
        for setup in self.setups:
            for rows, state, _ in self._at_rest(setup, displacements, held=True):
                for name, values in zip(setup.springs, state.statics.loads, strict=True):
                    loads.setdefault(name, np.zeros(len(self.data)))[rows] = values
        return loads

    def _at_rest(self, setup: Setup, displacements: Array, held: bool) -> Iterator[Block]:
        """The rows of a setup, block by block, at rest or with their deflections held at zero."""
        values, springs = _displaced(setup, displacements)
        mechanism = setup.assembly.mechanism
        placement = place(mechanism.chain, values)
        size = max(LEAST_BLOCK, min(BLOCK, BLOCK * COLUMNS // (len(self.names) + 1)))
        for start in range(0, len(setup.rows), size):
            rows = setup.rows[start : start + size]
            wrench = None if self.data.wrench is None else self.data.wrench[rows].T
            q = np.ascontiguousarray(self.data.q[rows].T)
            motion, turns = setup.assembly.motion(q), setup.assembly.model_positions(q)
            basis = [harmonics(turns[found.joint], found.orders)[found.chosen] for found in setup.maps]
            for found, waves in zip(setup.maps, basis, strict=True):
                motion[found.row] += displacements[found.columns] @ waves
            if held:
                none = np.zeros((len(springs), len(rows)))
                yield Block(rows, at_deflections(mechanism, placement, springs, motion, none, wrench), basis)
                continue
            try:
                state = settle(mechanism, placement, springs, motion, wrench, self._sides(setup, rows))
                yield Block(rows, state, basis)
            except EquilibriumError as error:
                row = int(rows[error.pose])
                raise EquilibriumError(error.element, row, self.data.place(row)) from None

    def _sides(self, setup: Setup, rows: NDArray[np.intp]) -> Array | None:
        """Loads (elastic, rows) that decide the sides, NaN where those of the undeflected configuration do."""
        if not self.sides:
            return None
        undecided = np.full(len(self.data), np.nan)
        return np.array([self.sides.get(name, undecided)[rows] for name in setup.springs])

    def _observed(self, setup: Setup, block: Block, derivatives: bool, coupled: bool) -> Iterator[Part]:
        rows, state, _ = block
        position = target_position(state)
        columns = self._columns(setup, block, coupled) if derivatives else None
        for kind in setup.kinds:
            residual = _residual(self.data.observed(kind)[rows], kind, position, state)
            jacobian = np.empty((0, 0, 0))
            if columns is not None:
                jacobian = _of_kind(kind, columns, position)
                jacobian[:, -1] = residual
            yield Part(kind, rows, residual, jacobian, f"{kind} {setup.station}".strip())

    def _columns(self, setup: Setup, block: Block, coupled: bool) -> Array:
        """(3 or 6, parameters + 1, n), the last row not filled in."""
        state, count, n = block.state, len(self.names), len(block.rows)
        channels = 6 if "orientation" in setup.kinds else 3
        if np.array_equal(setup.columns, np.arange(count)):
            columns = np.empty((channels, count + 1, n))
            fill_jacobian(state, setup.elements, setup.coefficients, coupled, columns[:, :-1])
            return columns
        found = np.empty((channels, len(setup.columns), n))
        fill_jacobian(state, setup.elements, setup.coefficients, coupled, found)
        columns = np.zeros((channels, count + 1, n))
        columns[:, setup.columns] = found
        if setup.maps:
            turned = np.empty((channels, len(setup.maps), n))
            fill_jacobian(state, np.array([each.element for each in setup.maps]), [], coupled, turned)
            for i, (each, waves) in enumerate(zip(setup.maps, block.harmonics, strict=True)):
                columns[:, each.columns] = turned[:, i, None] * waves
        return columns


def _displaced(setup: Setup, displacements: Array) -> tuple[Array, tuple[Spring, ...]]:
    """Element values and springs of a setup at displacements (parameters,)."""
    count = len(setup.elements)
    values = setup.assembly.mechanism.chain.values.copy()
    values[setup.elements] += displacements[setup.columns[:count]]
    springs = list(setup.assembly.springs)
    for (spring, k), column in zip(setup.coefficients, setup.columns[count:], strict=True):
        springs[spring] = springs[spring].displaced(k, float(displacements[column]))
    return values, tuple(springs)


def _residual(observed: Array, kind: str, position: Array, state: Equilibrium) -> Array:
    if kind == "position":
        return observed.T - position
    if kind == "orientation":
        return rotation_vectors(np.einsum("nik,jkn->ijn", observed, target_rotation(state)))
    return (observed - np.linalg.norm(position, axis=0))[None]


def _of_kind(kind: str, columns: Array, position: Array) -> Array:
    if kind == "position":
        return columns[:3]
    if kind == "orientation":
        return columns[3:]
    towards = position / np.linalg.norm(position, axis=0)
    return np.einsum("cn,cpn->pn", towards, columns[:3])[None]


def predict(
    robot: Robot,
    q: Array,
    *,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
    wrench: Array | None = None,
) -> tuple[Array, Array]:
    """Where the loaded robot puts a target.

    Args:
        robot: nominal or identified.
        q: (poses, joints) the controller's joint positions [rad or m].
        station: the instrument's station; None: the robot's base.
        target: a target of the robot; None: the tool's origin.
        load: a payload of the robot.
        wrench: (poses, 6) on the tool, force first, in the tool's frame [N, N m].

    Returns:
        Positions (poses, 3) [m] and rotations (poses, 3, 3) in the instrument's frame.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    assembly = assemble(robot, station, target, load)
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    q = np.atleast_2d(np.asarray(q, dtype=float))
    positions, rotations = np.empty((len(q), 3)), np.empty((len(q), 3, 3))
    for start in range(0, len(q), BLOCK):
        rows = slice(start, start + BLOCK)
        external = None if wrench is None else np.asarray(wrench, dtype=float)[rows].T
        try:
            state = settle(mechanism, placement, assembly.springs, assembly.motion(q[rows].T), external)
        except EquilibriumError as error:
            raise EquilibriumError(error.element, start + error.pose) from None
        positions[rows], rotations[rows] = target_position(state).T, target_rotation(state).transpose(2, 0, 1)
    return positions, rotations
