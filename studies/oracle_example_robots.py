"""Forward kinematics and gravity torques of the robots of `example-robot-data` against pinocchio.

Every URDF of that package, to every one of its tips: positions and rotations at random poses, and the loads on all
joints of the chain, with what hangs beside it. The package takes half a gigabyte, so no extra of elastocal asks for it:

    pip install elastocal pin example-robot-data
    python studies/oracle_example_robots.py [DIRECTORY WITH URDF FILES] [--poses N] [--seed N]

Prints a line per robot and exits 1 if any error exceeds 1e-10: of a position relative to the chain's length (or 1 m),
of a rotation absolute, of a torque relative to the chain's largest (or to a thousandth of its weight times its length:
where all axes are vertical, the largest is rounding). A tip whose chain elastocal does not model
(a mimic, floating or planar joint, or none that moves) is refused with a reason, not tested. What it last printed is in
`oracle_example_robots.txt`.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio

from elastocal.chain import forward, place
from elastocal.errors import InputError
from elastocal.io.urdf import read_urdf
from elastocal.prediction import predict
from elastocal.robot import Compliance, Robot, assemble
from elastocal.statics import load

LARGEST = 1e-10


@dataclass
class Line:
    """What is found for one URDF."""

    name: str
    joints: int = 0
    tested: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    position: float = 0.0
    rotation: float = 0.0
    torque: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether no error is too large."""
        return max(self.position, self.rotation, self.torque) <= LARGEST

    def __str__(self) -> str:
        why = "; ".join(f"{reason} ({count})" for reason, count in self.refused.items())
        errors = " ".join(f"{error:9.1e}" for error in (self.position, self.rotation, self.torque))
        return f"{self.name:54} {self.joints:6d} {self.tested:6d} {errors}  {why}".rstrip()


def compare(path: Path, name: str, poses: int, rng: np.random.Generator) -> Line:
    """A URDF to all of its tips."""
    line = Line(name)
    try:
        model = pinocchio.buildModelFromUrdf(str(path))
    except ValueError as error:
        line.refused[f"pinocchio: {str(error).strip().splitlines()[0].replace(str(path), path.name)}"] += 1
        return line
    line.joints = model.nv
    for tip in tips(path):
        try:
            robot = read_urdf(path, tip)
        except InputError as error:
            line.refused.update({reason(fault, path) for fault in error.faults})
            continue
        q = rng.uniform(-np.pi, np.pi, (poses, robot.positions))
        positions, rotations, torques = pinocchio_at(model, tip, robot, q)
        position, rotation = predict(robot, q)
        length = max(1.0, sum(float(np.linalg.norm(row.origin.translation)) for row in robot.rows))
        line.position = max(line.position, np.abs(position - positions).max() / length)
        line.rotation = max(line.rotation, np.abs(rotation - rotations).max())
        weight = 9.81 * sum(row.mass for row in robot.rows)
        largest = max(np.abs(torques).max(), 1e-3 * weight * length) or 1.0
        line.torque = max(line.torque, np.abs(loads(robot, q) + torques).max() / largest)
        line.tested += 1
    return line


def tips(path: Path) -> Iterator[str]:
    """The links that carry nothing."""
    root = ElementTree.parse(path).getroot()
    parents = {joint.find("parent").get("link") for joint in root.findall("joint")}
    yield from (link.get("name") for link in root.findall("link") if link.get("name") not in parents)


def reason(fault: str, path: Path) -> str:
    """A fault without the names in it."""
    for text in ("no joint moves", "mimics another", "expected type"):
        if text in fault:
            return {"no joint moves": "nothing moves", "mimics another": "mimic"}.get(text, "joint type")
    return fault.removeprefix(f"{path}: ")


def pinocchio_at(
    model: pinocchio.Model, tip: str, robot: Robot, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions and rotations of the tip, and generalized gravity of the robot's joints; all other joints at zero."""
    model.gravity.linear = np.array(robot.gravity)
    data, frame = model.createData(), model.getFrameId(tip, pinocchio.FrameType.BODY)
    rows = [model.joints[joint_id(model, row.name)].idx_v for row in robot.joints]
    positions, rotations, torques = [], [], []
    for pose in q:
        step = np.zeros(model.nv)
        step[rows] = pose
        configuration = pinocchio.integrate(model, pinocchio.neutral(model), step)
        pinocchio.framesForwardKinematics(model, data, configuration)
        positions.append(data.oMf[frame].translation.copy())
        rotations.append(data.oMf[frame].rotation.copy())
        torques.append(pinocchio.computeGeneralizedGravity(model, data, configuration)[rows])
    return np.array(positions), np.array(rotations), np.array(torques)


def joint_id(model: pinocchio.Model, row: str) -> int:
    """The joint of a row, whose name elastocal lengthens where the joint is called base or tool."""
    return model.getJointId(row if model.existJointName(row) else row.removesuffix("_joint"))


def loads(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Loads (poses, joints) on the driven elements: minus the generalized gravity."""
    assembly = assemble(replace(robot, elastic={row.joint_element: Compliance() for row in robot.joints}))
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    return load(mechanism, placement, forward(placement, assembly.motion(q.T))).loads.T


def installed() -> Path | None:
    """The robots of the package, if it is installed beside elastocal."""
    try:
        found = distribution("example-robot-data").locate_file("cmeel.prefix/share/example-robot-data/robots")
    except PackageNotFoundError:
        return None
    return Path(str(found))


def main() -> int:
    """Compare all robots; 1 if any disagrees, 2 if there are none."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", nargs="?", type=Path, default=installed(), help="where the URDF files are")
    parser.add_argument("--poses", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    paths = sorted(options.directory.rglob("*.urdf")) if options.directory else []
    if not paths:
        sys.stderr.write("no URDF files: pip install example-robot-data, or name the directory where they are\n")
        return 2
    say = sys.stdout.write
    say(f"elastocal {version('elastocal')}, pin {pinocchio.__version__}, numpy {np.__version__}, ")
    say(f"{options.poses} poses of each chain, seed {options.seed}\n\n")
    say(f"{'robot':54} {'joints':>6} {'tips':>6} {'position':>9} {'rotation':>9} {'torque':>9}  refused\n")
    rng = np.random.default_rng(options.seed)
    lines = []
    for path in paths:
        line = compare(path, str(path.relative_to(options.directory).with_suffix("")), options.poses, rng)
        say(f"{line}{'' if line.passed else '  <-- DISAGREES'}\n")
        lines.append(line)
    worst = [max(getattr(line, kind) for line in lines) for kind in ("position", "rotation", "torque")]
    say(f"\n{sum(line.tested > 0 for line in lines)} of {len(lines)} robots, {sum(x.tested for x in lines)} chains; ")
    say(f"largest errors: position {worst[0]:.1e}, rotation {worst[1]:.1e}, torque {worst[2]:.1e}\n")
    return 0 if all(line.passed for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
