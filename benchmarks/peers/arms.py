"""The simulated arms, and the files that the tools read: `python arms.py FOLDER SEEDS MARK`."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from urdf import urdf_of

import elastocal as ec
from elastocal.examples import ROBOT_FILE
from elastocal.robot import Compliance, Robot
from elastocal.simulation import random_poses, simulate, with_frames_drawn, with_geometry_errors

LAWS = ("rigid", "linear", "step", "hinge")
FITTED, HELD_OUT = 60, 200
NOISE = 3e-5
"""Standard deviation of each measured coordinate [m]."""
LENGTH_ERROR, ANGLE_ERROR = 5e-4, 5e-4
"""Standard deviations of the errors of every length [m] and angle [rad] of the rows."""

JOINTS = {"2": (250.0, 450.0, 1.5e-6, 3e-6), "3": (60.0, 120.0, 3e-6, 6e-6)}
"""By joint that gives way: range of transition torques [N m], and of the compliance above them [rad/(N m)]."""
SOFTENING = 2.5
"""So many times more compliant is a step's or hinge's joint below its transition torque; a linear one is throughout."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Arm:
    """An actual arm: its law of compliance, and the seed of its errors, frames, compliance, poses and noise."""

    law: str
    seed: int

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.law}-{self.seed:02d}"


def actual_robot(arm: Arm) -> Robot:
    """The nominal example arm with errors, an instrument and a target somewhere, and joints that give way."""
    rng = np.random.default_rng(arm.seed)
    robot = with_frames_drawn(with_geometry_errors(ec.load_robot(ROBOT_FILE), LENGTH_ERROR, ANGLE_ERROR, rng), rng)
    springs = {}
    for joint, (lowest, highest, stiff, soft) in JOINTS.items():
        above, torque = rng.uniform(stiff, soft), rng.uniform(lowest, highest)
        coefficients = (SOFTENING * above, above)
        springs[f"{joint}.theta"] = (
            Compliance("linear", coefficients[:1]) if arm.law == "linear" else Compliance(arm.law, coefficients, torque)
        )
    return robot if arm.law == "rigid" else replace(robot, elastic=springs)


def write_arm(arm: Arm, folder: Path) -> None:
    """Write what the tools get, and truth.csv: where the target is at the held-out poses, without noise."""
    actual, nominal = actual_robot(arm), ec.load_robot(ROBOT_FILE)
    q = random_poses(actual, FITTED + HELD_OUT, arm.seed)
    fitted = simulate(actual, q[:FITTED], noise=NOISE, seed=arm.seed)
    aligned = ec.calibrate(nominal, fitted, identify=["base.*", "tool.*"]).robot
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROBOT_FILE, folder / "robot.toml")
    (folder / "robot.urdf").write_text(urdf_of(nominal, aligned.tool.translation), encoding="utf-8")
    _table(folder / "mdh.csv", ["alpha", "a", "theta", "d"], modified_dh(nominal))
    observed = np.hstack([fitted.q, fitted.position])
    joints = [f"q{i}" for i in range(1, 7)]
    _table(folder / "fit.csv", [*joints, "x", "y", "z"], observed)
    _table(folder / "figaroh.csv", [*(f"joint_{i}" for i in range(1, 7)), "x1", "y1", "z1"], observed)
    _table(folder / "held_out.csv", joints, q[FITTED:])
    _table(folder / "truth.csv", ["x", "y", "z"], ec.predict(actual, q[FITTED:])[0])
    _table(folder / "nominal.csv", ["x", "y", "z"], ec.predict(aligned, q[FITTED:])[0])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = aligned.base.rotation, aligned.base.translation
    frames = {"instrument_T_base": matrix.tolist(), "flange_p_target": aligned.tool.translation.tolist()}
    (folder / "aligned.json").write_text(json.dumps(frames), encoding="utf-8")


def modified_dh(robot: Robot) -> Array:
    """The robot's table, (rows, 4): alpha, a, theta, d [rad, m]; raises ValueError where it has a beta or b."""
    if any(row.geometry.get(key) for row in robot.rows for key in ("beta", "b")):
        raise ValueError("a row has beta or b, for which a modified-DH table of four columns has no place")
    return np.array([[row.geometry.get(key, 0.0) for key in ("alpha", "a", "theta", "d")] for row in robot.rows])


def _table(path: Path, header: list[str], values: Array) -> None:
    lines = [",".join(header), *(",".join(map(repr, row)) for row in values.tolist())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    """Write the arms that are not there yet; MARK says what they are made from."""
    folder, seeds, mark = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    for arm in (Arm(law, seed) for law in LAWS for seed in range(seeds)):
        marked, part = folder / f"{arm.name}.mark", folder / f"{arm.name}.part"
        if marked.exists() and marked.read_text(encoding="utf-8") == mark:
            continue
        shutil.rmtree(part, ignore_errors=True)
        write_arm(arm, part)
        shutil.rmtree(folder / arm.name, ignore_errors=True)
        part.rename(folder / arm.name)
        marked.write_text(mark, encoding="utf-8")


if __name__ == "__main__":
    main()
