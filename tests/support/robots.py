"""Robots for tests: an ordinary arm, and random ones of every kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.robot import DH_KEYS, Compliance, Frame, Payload, Robot, Row

DEG = np.pi / 180.0

ARM_TABLE = (  # alpha, a, d, lower, upper, mass, com
    (0.0, 0.0, 0.45, -180, 180, 40.0, (0.05, 0.0, -0.1)),
    (-90.0, 0.15, 0.0, -100, 60, 30.0, (0.3, 0.0, 0.05)),
    (0.0, 0.6, 0.0, -70, 150, 22.0, (0.05, -0.02, 0.0)),
    (-90.0, 0.13, 0.64, -180, 180, 10.0, (0.0, 0.0, -0.2)),
    (90.0, 0.0, 0.0, -115, 115, 5.0, (0.0, 0.02, 0.0)),
    (-90.0, 0.0, 0.1, -180, 180, 2.0, (0.0, 0.0, -0.02)),
)

ARM_COMPLIANCE = (1.0e-6, 2.0e-6, 4.0e-6, 1.0e-5, 1.5e-5, 3.0e-5)


def arm(elastic: bool = False, tool_mass: float = 10.0) -> Robot:
    """A rigid or compliant six-joint arm of 1.45 m reach in modified DH; base and tool open."""
    rows = tuple(
        Row(
            name=str(i),
            joint="revolute",
            geometry={"alpha": alpha * DEG, "a": a, "theta": 0.0, "d": d},
            limits=(lower * DEG, upper * DEG),
            mass=mass,
            com=com,
        )
        for i, (alpha, a, d, lower, upper, mass, com) in enumerate(ARM_TABLE, start=1)
    )
    compliance = {f"{i}.theta": Compliance("linear", (c,)) for i, c in enumerate(ARM_COMPLIANCE, start=1)}
    load = Payload(tool_mass, (0.02, 0.01, 0.12))
    return Robot("arm", "modified-dh", rows, tool_load=load, elastic=compliance if elastic else {})


def placed(robot: Robot, rng: np.random.Generator, offset: float = 0.3) -> Robot:
    """The robot seen by an instrument anywhere, its target up to `offset` [m] from the flange along each axis."""
    base = Frame(tuple(rng.uniform(-3.0, 3.0, 3)), tuple(rng.uniform(-np.pi, np.pi, 3)), known=True)
    tool = Frame(tuple(rng.uniform(-offset, offset, 3)), tuple(rng.uniform(-1.0, 1.0, 3)), known=True)
    return replace(robot, base=base, tool=tool)


def random_dh_robot(rng: np.random.Generator, convention: str, joints: int = 6, prismatic: float = 0.0) -> Robot:
    """A robot of random geometry, masses and tool; each joint is prismatic with some probability."""
    rows = []
    for i in range(1, joints + 1):
        geometry = {
            key: float(rng.uniform(-1.5, 1.5) if key in ("alpha", "beta", "theta") else rng.uniform(-0.5, 0.5))
            for key in DH_KEYS
        }
        slides = rng.random() < prismatic
        rows.append(
            Row(
                name=str(i),
                joint="prismatic" if slides else "revolute",
                geometry=geometry,
                sign=int(rng.choice([-1, 1])),
                mass=float(rng.uniform(1.0, 20.0)),
                com=tuple(rng.uniform(-0.2, 0.2, 3)),
            )
        )
    tool = Frame(tuple(rng.uniform(-0.2, 0.2, 3)), tuple(rng.uniform(-1.0, 1.0, 3)), known=True)
    base = Frame(tuple(rng.uniform(-1.0, 1.0, 3)), tuple(rng.uniform(-1.0, 1.0, 3)), known=True)
    load = Payload(float(rng.uniform(1.0, 10.0)), tuple(rng.uniform(-0.1, 0.1, 3)))
    return Robot(
        "random", convention, tuple(rows), gravity=tuple(rng.normal(size=3) * 5.0), base=base, tool=tool, tool_load=load
    )
