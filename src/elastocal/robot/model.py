"""The robot: a value. What a calibration changes is a new robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastocal.chain import Array, Element, Vector
from elastocal.elasticity import CURVES, LAWS, Spring
from elastocal.robot.frames import FRAME_KEYS, Frame
from elastocal.robot.rows import CONVENTIONS, Row


@dataclass(frozen=True)
class Payload:
    """A mass [kg] with its centre `com` [m] in the flange frame."""

    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Compliance:
    """How an element gives way: a law's name, its coefficients (SI) and, where it has one, its transition torque."""

    law: str = "linear"
    coefficients: tuple[float, ...] = (0.0,)
    transition_torque: float | None = None

    @property
    def spring(self) -> Spring:
        """The compliance as the equilibrium takes it."""
        return Spring(CURVES[self.law], self.coefficients, self.transition_torque)

    @classmethod
    def rigid(cls, law: str, transition_torque: float | None = None) -> Compliance:
        """The law with all coefficients zero."""
        return cls(law, (0.0,) * len(LAWS[law].coefficients), transition_torque)


def harmonics(q: Array, orders: int) -> Array:
    """The waves sin q, cos q, sin 2q, cos 2q, … at joint positions (n,), (2 orders, n)."""
    powers = np.cumprod(np.broadcast_to(np.exp(1j * q), (orders, len(q))), axis=0)
    return np.stack([powers.imag, powers.real], axis=1).reshape(2 * orders, len(q))


@dataclass(frozen=True)
class JointMap:
    """A drive's transmission error, sum_h sin[h-1] sin(h q) + cos[h-1] cos(h q) [rad or m] at joint position q."""

    sin: tuple[float, ...] = ()
    cos: tuple[float, ...] = ()

    @property
    def coefficients(self) -> dict[str, float]:
        """By name: "sin1", "cos1", "sin2", …."""
        pairs = enumerate(zip(self.sin, self.cos, strict=True), start=1)
        return {f"{key}{h}": value for h, pair in pairs for key, value in zip(("sin", "cos"), pair, strict=True)}

    def at(self, q: Array) -> Array:
        """The error at joint positions (n,) of the model, after coupling and before sign."""
        return np.array(list(self.coefficients.values())) @ harmonics(q, len(self.sin))

    def changed(self, deltas: Mapping[str, float]) -> JointMap:
        """The map with something added to coefficients, by name."""
        values = [value + deltas.get(name, 0.0) for name, value in self.coefficients.items()]
        return JointMap(tuple(values[::2]), tuple(values[1::2]))


@dataclass(frozen=True)
class Robot:
    """A robot on its base with a tool, targets and payloads; SI units.

    Attributes:
        convention: a key of CONVENTIONS.
        gravity: (3,) [m/s2] in the base frame.
        base: instrument_T_base.
        tool: flange_T_tool, with the tool's mass in `tool_load`.
        targets: tool_T_target by name; without any the tool's origin is measured.
        loads: payloads that a measurement may name.
        coupling: (model joints, controller joints) positions of the model = matrix . controller's; None: the identity.
        elastic: compliance by element name.
        transmission: joint maps by the names of driven elements.
        stations: instrument_T_base by the name of the instrument's station.
        tolerance: standard deviation of what rows are built to, by kind: "length" [m], "angle" and "offset" [rad].
    """

    name: str
    convention: str
    rows: tuple[Row, ...]
    gravity: Vector = (0.0, 0.0, -9.81)
    base: Frame = field(default_factory=Frame)
    tool: Frame = field(default_factory=Frame)
    tool_load: Payload = field(default_factory=Payload)
    targets: Mapping[str, Frame] = field(default_factory=dict)
    loads: Mapping[str, Payload] = field(default_factory=dict)
    coupling: tuple[tuple[float, ...], ...] | None = None
    elastic: Mapping[str, Compliance] = field(default_factory=dict)
    transmission: Mapping[str, JointMap] = field(default_factory=dict)
    stations: Mapping[str, Frame] = field(default_factory=dict)
    tolerance: Mapping[str, float] = field(default_factory=dict)

    @property
    def joints(self) -> tuple[Row, ...]:
        """The rows that a joint moves."""
        return tuple(row for row in self.rows if row.joint)

    @property
    def positions(self) -> int:
        """How many joint positions the controller reports."""
        return len(self.coupling[0]) if self.coupling else len(self.joints)

    @property
    def frames(self) -> dict[str, Frame]:
        """All frames by the prefix of their parameters: "base", "station.north", "tool", "target.nest1"."""
        return {
            "base": self.base,
            **{f"station.{name}": frame for name, frame in self.stations.items()},
            "tool": self.tool,
            **{f"target.{name}": frame for name, frame in self.targets.items()},
        }

    @cached_property
    def row_elements(self) -> tuple[tuple[Element, ...], ...]:
        """The elements of each row."""
        return tuple(CONVENTIONS[self.convention].elements(row) for row in self.rows)

    @property
    def compliant_elements(self) -> tuple[str, ...]:
        """Names of the elements that may give way: those of the rows.

        Rotations of frames and of a URDF joint's origin are not among them: their axes do not last, since turns about
        them become part of the frame.
        """
        return tuple(
            element.name
            for row, elements in zip(self.rows, self.row_elements, strict=True)
            for element in elements
            if element.name and (self.convention != "urdf" or element.name == row.joint_element or not element.rotation)
        )

    def with_frames(self, frames: Mapping[str, Frame]) -> Robot:
        """Replace frames by the prefix of their parameters."""
        return replace(
            self,
            base=frames.get("base", self.base),
            tool=frames.get("tool", self.tool),
            targets={name: frames.get(f"target.{name}", frame) for name, frame in self.targets.items()},
            stations={name: frames.get(f"station.{name}", frame) for name, frame in self.stations.items()},
        )

    def displaced(self, deltas: Mapping[str, float]) -> Robot:
        """A robot whose parameters differ by `deltas` [rad, m, SI], by parameter name.

        Rotations rx, ry, rz of a frame, and of a URDF joint's origin, are small turns about the frame's own axes.

        Raises:
            KeyError: a name that is no parameter of the robot.
        """
        remaining = dict(deltas)

        def take(prefix: str, keys: tuple[str, ...]) -> dict[str, float]:
            return {key: remaining.pop(f"{prefix}.{key}") for key in keys if f"{prefix}.{key}" in remaining}

        frames = {prefix: frame.displaced(take(prefix, FRAME_KEYS)) for prefix, frame in self.frames.items()}
        displace = CONVENTIONS[self.convention].displaced
        rows = []
        for row, elements in zip(self.rows, self.row_elements, strict=True):
            keys = tuple(element.name.removeprefix(f"{row.name}.") for element in elements if element.name)
            changed = take(row.name, keys)
            rows.append(displace(row, changed) if changed else row)
        elastic = {}
        for element, compliance in self.elastic.items():
            names = CURVES[compliance.law].coefficients
            changed = take(element, (*names, "transition_torque"))
            values = [c + changed.get(name, 0.0) for name, c in zip(names, compliance.coefficients, strict=True)]
            torque = compliance.transition_torque
            if "transition_torque" in changed:
                torque = (torque or 0.0) + changed["transition_torque"]
            elastic[element] = Compliance(compliance.law, tuple(values), torque)
        maps = {
            element: found.changed(take(element, tuple(found.coefficients)))
            for element, found in self.transmission.items()
        }
        if remaining:
            raise KeyError(f"no parameters of {self.name}: {', '.join(remaining)}")
        return replace(self.with_frames(frames), rows=tuple(rows), elastic=elastic, transmission=maps)
