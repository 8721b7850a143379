"""Measurements with rows that are grossly wrong, and faults of whole data sets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastocal.measurements import Measurements
from elastocal.robot import Compliance, Robot
from support.robots import arm, placed

NOISE = 3e-5

HINGES = {"2.theta": Compliance("hinge", (7e-6, 2.5e-6), 300.0), "3.theta": Compliance("hinge", (1.2e-5, 5e-6), 90.0)}
SPRINGS = {
    "rigid": {},
    "linear": {"2.theta": Compliance("linear", (3e-6,)), "3.theta": Compliance("linear", (5e-6,))},
    "hinge": HINGES,
    "step": {name: replace(spring, law="step") for name, spring in HINGES.items()},
}
"""What gives way, by the law of joints 2 and 3."""


def laws(law: str) -> dict[str, str]:
    """What to ask for."""
    return {} if law == "rigid" else {"2": law, "3": law}


def as_built(seed: int, law: str = "linear", length: float = 1e-3, angle: float = 1e-3) -> Robot:
    """An arm off by so much everywhere, seen from anywhere, with any tool."""
    rng = np.random.default_rng(seed)
    deltas = {e.name: (angle if e.rotation else length) * rng.standard_normal() for r in arm().row_elements for e in r}
    return placed(replace(arm().displaced(deltas), elastic=SPRINGS[law]), rng)


def spoiled(
    data: Measurements, seed: int, share: float = 0.1, smallest: float = 5e-3, largest: float = 50e-3
) -> tuple[Measurements, NDArray[np.intp]]:
    """The data with some rows' positions wrong in any direction, and which rows these are."""
    rng = np.random.default_rng(seed)
    rows = np.sort(rng.choice(len(data), round(share * len(data)), replace=False))
    directions = rng.standard_normal((len(rows), 3))
    sizes = rng.uniform(smallest, largest, (len(rows), 1)) / np.linalg.norm(directions, axis=1, keepdims=True)
    position = data.position.copy()
    position[rows] += sizes * directions
    return replace(data, position=position), rows
