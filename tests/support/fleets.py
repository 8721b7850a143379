"""Simulated fleets: robots built after one drawing, each measured, and a manifest of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import elastocal as ec
from elastocal.examples import ROBOT_FILE
from elastocal.robot import Compliance, Frame, Robot
from elastocal.simulation import with_frames_drawn, with_geometry_errors

NOISE = 3e-5
HEADER = "serial,date,robot,data,elastic,holdout,seed"


def built(nominal: Robot, serial: int) -> Robot:
    """A robot of a fleet, with compliances of joints 2 and 3 that scatter by a tenth."""
    rng = np.random.default_rng([17, serial])
    drawn = with_frames_drawn(with_geometry_errors(nominal, 3e-4, 3e-4, rng), rng)
    springs = {f"{joint}.theta": Compliance("linear", (c * (1.0 + 0.1 * rng.standard_normal()),)) for joint, c in SOFT}
    known = {name: replace(frame, known=True) for name, frame in drawn.frames.items()}
    return replace(drawn.with_frames(known), elastic=springs)


SOFT = (("2", 2.0e-6), ("3", 3.5e-6))


def worn(robot: Robot) -> Robot:
    """The same robot later: joint 3 has come loose, and the instrument stands elsewhere."""
    springs = dict(robot.elastic) | {"3.theta": Compliance("linear", (9e-6,))}
    moved = replace(robot, elastic=springs).displaced({"3.theta": 1.5e-3})
    return moved.with_frames({"base": Frame((1.9, 1.2, -0.4), (0.0, 0.01, -1.0), known=True)})


def save_fleet(
    folder: Path, count: int, poses: int = 45, again: Sequence[int] = (), loose: Sequence[int] = (), later: int = 0
) -> Path:
    """Write a fleet's manifest, robot file and measurements.

    Args:
        folder: of all files.
        count: how many robots.
        poses: that each is measured at.
        again: robots measured once more.
        loose: robots whose joint 3 is loose by then.
        later: seed of the poses.

    Returns:
        The manifest.
    """
    nominal = ec.load_robot(ROBOT_FILE)
    (folder / "arm.toml").write_bytes(ROBOT_FILE.read_bytes())
    lines = [HEADER]
    for serial in range(count):
        robot = built(nominal, serial)
        dates = [("2025-03-01", robot)]
        if serial in again or serial in loose:
            dates.append(("2026-03-01", worn(robot) if serial in loose else robot))
        for year, (date, actual) in enumerate(dates):
            rng = np.random.default_rng([serial, year, later])
            data = ec.simulate(actual, ec.random_poses(nominal, poses, rng), noise=NOISE, seed=rng)
            ec.save_measurements(data, nominal, folder / f"{serial}-{date}.csv")
            lines.append(f'S{serial:03d},{date},arm.toml,{serial}-{date}.csv,"2,3",,')
    manifest = folder / "fleet.csv"
    manifest.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return manifest
