"""A robot by slow plain matrices, one pose at a time, and written out as URDF: nothing of elastocal's chain is used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from elastocal.robot import Compliance, Frame, Payload, Robot, Row

Array = NDArray[np.float64]

DH_ORDERS = {
    "modified-dh": ("alpha", "a", "beta", "b", "theta", "d"),
    "standard-dh": ("theta", "d", "a", "alpha", "beta", "b"),
}
DH_AXES = {"alpha": 0, "a": 0, "beta": 1, "b": 1, "theta": 2, "d": 2}
DH_TURNS = ("alpha", "beta", "theta")


class Step(NamedTuple):
    """One elementary transform; a constant has a matrix instead of an axis."""

    name: str
    turns: bool
    axis: Array
    value: float
    constant: Array | None = None

    def matrix(self) -> Array:
        """The transform, (4, 4)."""
        if self.constant is not None:
            return self.constant
        if self.turns:
            return transform(Rotation.from_rotvec(self.axis * self.value).as_matrix(), np.zeros(3))
        return transform(np.eye(3), self.axis * self.value)


@dataclass(frozen=True)
class Pose:
    """A robot in one pose, everything in the instrument's frame.

    Attributes:
        frames: (4, 4) after the base, after each row, after the tool and, if there is one, after the target.
        screws: of each element whether it turns, its axis and origin, and the number of the frame it leads to.
        masses: of each mass its weight [kg], its place and the number of the frame that carries it.
        gravity: (3,) [m/s2].
        tool: number of the tool's frame.
    """

    frames: list[Array]
    screws: dict[str, tuple[bool, Array, Array, int]]
    masses: list[tuple[float, Array, int]]
    gravity: Array
    tool: int

    @property
    def potential(self) -> float:
        """Potential energy of all masses [J]."""
        return -sum(mass * float(self.gravity @ place) for mass, place, _ in self.masses)

    def load(self, name: str, wrench: Array | None = None) -> float:
        """What gravity and a wrench (6,) on the tool, in its frame, press on an element beyond the base."""
        turns, axis, origin, number = self.screws[name]
        carried = [(mass * self.gravity, place) for mass, place, carrier in self.masses if carrier >= number]
        moment = np.zeros(3)
        if wrench is not None and number <= self.tool:
            frame = self.frames[self.tool]
            carried.append((frame[:3, :3] @ wrench[:3], frame[:3, 3]))
            moment = frame[:3, :3] @ wrench[3:]
        if turns:
            return float(axis @ (moment + sum(np.cross(place - origin, force) for force, place in carried)))
        return float(axis @ sum((force for force, _ in carried), np.zeros(3)))


def posed(
    robot: Robot,
    q: Sequence[float] | Array,
    deltas: Mapping[str, float] | None = None,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
) -> Pose:
    """The rigid robot at the controller's joint positions, `deltas` added to the values of the named elements."""
    deltas = deltas or {}
    base = robot.base if station is None else robot.stations[station]
    groups = [frame_steps(base, "base" if station is None else f"station.{station}")]
    model = iter(q if robot.coupling is None else np.array(robot.coupling) @ q)
    groups += [row_steps(robot, row, next(model) * row.sign if row.joint else 0.0) for row in robot.rows]
    groups.append(frame_steps(robot.tool, "tool"))
    if target is not None:
        groups.append(frame_steps(robot.targets[target], f"target.{target}"))

    running, frames, screws = np.eye(4), [], {}
    for number, group in enumerate(groups):
        for step in group:
            moved = step._replace(value=step.value + deltas.get(step.name, 0.0))
            screws[step.name] = (step.turns, running[:3, :3] @ step.axis, running[:3, 3], number)
            running = running @ moved.matrix()
        frames.append(running)

    flange = len(robot.rows)
    pieces = [(row.mass, row.com, number) for number, row in enumerate(robot.rows, start=1)]
    payloads = [robot.tool_load, *([robot.loads[load]] if load is not None else [])]
    pieces += [(piece.mass, piece.com, flange) for piece in payloads]
    masses = [(mass, (frames[number] @ [*com, 1.0])[:3], number) for mass, com, number in pieces]
    return Pose(frames, screws, masses, frames[0][:3, :3] @ robot.gravity, flange + 1)


def transform(rotation: Array, translation: Array) -> Array:
    """A homogeneous matrix (4, 4)."""
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = rotation, translation
    return whole


def frame_matrix(frame: Frame) -> Array:
    """A frame as a matrix (4, 4)."""
    return transform(Rotation.from_euler("xyz", frame.rpy or np.zeros(3)).as_matrix(), np.array(frame.xyz or (0, 0, 0)))


def frame_steps(frame: Frame, name: str) -> list[Step]:
    """Tx Ty Tz, the rotation as it stands, and small turns about its axes."""
    whole = frame_matrix(frame)
    shifts = [Step(f"{name}.t{k}", False, np.eye(3)[i], whole[i, 3]) for i, k in enumerate("xyz")]
    turns = [Step(f"{name}.r{k}", True, np.eye(3)[i], 0.0) for i, k in enumerate("xyz")]
    return [*shifts, Step("", False, np.zeros(3), 0.0, transform(whole[:3, :3], np.zeros(3))), *turns]


def row_steps(robot: Robot, row: Row, position: float) -> list[Step]:
    """The transforms of a row, the model's joint position (with its sign) added to the driven one."""
    driven = {"revolute": "theta", "prismatic": "d", None: ""}[row.joint]
    if robot.convention == "urdf":
        joint = Step(f"{row.name}.{driven}", row.joint == "revolute", np.array(row.axis), position)
        return frame_steps(row.origin, row.name) + ([joint] if driven else [])
    return [
        Step(
            f"{row.name}.{key}",
            key in DH_TURNS,
            np.eye(3)[DH_AXES[key]],
            row.geometry.get(key, 0.0) + (position if key == driven else 0.0),
        )
        for key in DH_ORDERS[robot.convention]
    ]


@dataclass(frozen=True)
class Link:
    """A link of a URDF; `com` is its centre of mass in its frame [m]."""

    name: str
    mass: float = 0.0
    com: Sequence[float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF: where it sits on its parent (4, 4), and its axis there."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Array
    axis: Sequence[float] = (1.0, 0.0, 0.0)


def urdf_text(links: Sequence[Link], joints: Sequence[Joint]) -> str:
    """Links and joints as the text of a URDF."""
    lines = ['<robot name="written">']
    for link in links:
        inertial = (
            f'<inertial><origin xyz="{_words(link.com)}" rpy="0.1 0.2 0.3"/><mass value="{float(link.mass)!r}"/>'
            '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
        )
        lines.append(f'  <link name="{link.name}">{inertial if link.mass else ""}</link>')
    for joint in joints:
        rpy = Rotation.from_matrix(joint.origin[:3, :3]).as_euler("xyz")
        lines += [
            f'  <joint name="{joint.name}" type="{joint.kind}">',
            f'    <parent link="{joint.parent}"/><child link="{joint.child}"/>',
            f'    <origin xyz="{_words(joint.origin[:3, 3])}" rpy="{_words(rpy)}"/>',
            f'    <axis xyz="{_words(joint.axis)}"/><limit lower="-3" upper="3" effort="1" velocity="1"/>',
            "  </joint>",
        ]
    return "\n".join([*lines, "</robot>"])


def _words(values: Sequence[float] | Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def robot_urdf(robot: Robot) -> str:
    """A robot with base, tool and tool's mass (link "tool" at its tip); its joints are named as its rows.

    A row that goes on behind its joint becomes two links; the model's joint positions drive it, after coupling.
    """
    links, joints = [Link("root"), Link("base")], [Joint("to-base", "fixed", "root", "base", frame_matrix(robot.base))]
    carrier = "base"
    for row in robot.rows:
        steps = row_steps(robot, row, 0.0)
        end = next((i for i, step in enumerate(steps, 1) if step.name == row.joint_element), len(steps))
        origin, rest = _product(steps[:end]), _product(steps[end:])
        links += [Link(f"{row.name}-joint"), Link(row.name, row.mass, row.com)]
        axis = row.sign * steps[end - 1].axis
        joints += [
            Joint(row.name, row.joint or "fixed", carrier, f"{row.name}-joint", origin, axis),
            Joint(f"{row.name}-rest", "fixed", f"{row.name}-joint", row.name, rest),
        ]
        carrier = row.name
    links += [Link("tool"), Link("payload", robot.tool_load.mass, robot.tool_load.com)]
    joints += [
        Joint("to-tool", "fixed", carrier, "tool", frame_matrix(robot.tool)),
        Joint("to-payload", "fixed", carrier, "payload", np.eye(4)),
    ]
    return urdf_text(links, joints)


def _product(steps: Sequence[Step]) -> Array:
    whole = np.eye(4)
    for step in steps:
        whole = whole @ step.matrix()
    return whole


KINDS = ("revolute", "continuous", "prismatic", "fixed")


def random_tree(rng: np.random.Generator, joints: int, branching: float) -> tuple[list[Link], list[Joint]]:
    """A random tree of links 0, 1, …: tilted axes of any length, all kinds of joints, branches with a probability."""
    links, found = [Link("0", 3.0, tuple(rng.uniform(-0.1, 0.1, 3)))], []
    for i in range(1, joints + 1):
        parent = int(rng.integers(0, i)) if rng.random() < branching else i - 1
        origin = transform(Rotation.random(rng=rng).as_matrix(), rng.uniform(-0.5, 0.5, 3))
        axis = rng.normal(size=3)
        kind = "revolute" if i == 1 else str(rng.choice(KINDS))
        found.append(Joint(f"j{i}", kind, str(parent), str(i), origin, tuple(axis)))
        links.append(Link(str(i), float(rng.choice([0.0, rng.uniform(0.5, 10.0)])), tuple(rng.uniform(-0.2, 0.2, 3))))
    return links, found


def equipped(robot: Robot, rng: np.random.Generator) -> Robot:
    """The robot with a second station, two targets, a heavy payload and a coupling; everything stands tilted."""

    def frame(reach: float) -> Frame:
        return Frame(tuple(rng.uniform(-reach, reach, 3)), tuple(rng.uniform(-1.2, 1.2, 3)))

    count = len(robot.joints)
    coupling = np.eye(count) + np.tril(rng.uniform(-0.5, 0.5, (count, count)), -1)
    return replace(
        robot,
        base=frame(2.0),
        tool=frame(0.3),
        stations={"north": frame(2.0)},
        targets={"near": frame(0.1), "far": frame(0.4)},
        loads={"heavy": Payload(25.0, tuple(rng.uniform(-0.2, 0.2, 3)))},
        coupling=tuple(map(tuple, coupling.tolist())),
    )


def compliant(robot: Robot, others: Sequence[str], turn: float, slide: float) -> Robot:
    """The robot with linear compliance on all joints and on other elements [rad/(N m)] and [m/N]."""
    names = [*(row.joint_element for row in robot.joints), *others]
    turning = (*DH_TURNS, "rx", "ry", "rz")
    springs = {name: Compliance("linear", (turn if name.split(".")[-1] in turning else slide,)) for name in names}
    return replace(robot, elastic=springs)
