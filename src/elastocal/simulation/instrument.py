"""The instrument: what it makes of where a target really is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.measurements import KINDS, Measurements


@dataclass(frozen=True)
class Instrument:
    """How an instrument measures.

    Attributes:
        kinds: what is measured, of "position", "orientation", "distance".
        noise: standard deviation of each coordinate of the position, and of the distance [m]; or three, for x, y and z
            of the instrument's frame.
        noise_angle: standard deviation of the orientation about each axis [rad].
        rounding: coordinates and distances are read as multiples of this [m]; 0: as they are.
        outliers: fraction of the rows that are grossly wrong, to the nearest row.
        outlier_size: how far off these are, in a random direction [m]; orientations are left as they are.
        state_sigma: whether the measurements state the standard deviations of the noise.

    Raises:
        InputError: with every fault: a kind that does not exist, a negative number, noise by axis of a distance.
    """

    kinds: tuple[str, ...] = ("position",)
    noise: float | tuple[float, ...] = 0.0
    noise_angle: float = 0.0
    rounding: float = 0.0
    outliers: float = 0.0
    outlier_size: float = 5e-3
    state_sigma: bool = False

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise InputError(*faults)

    def _faults(self) -> Iterator[str]:
        if not self.kinds:
            yield f"expected something to measure, found no kind (valid: {', '.join(KINDS)})"
        yield from (unknown_name("kind", kind, KINDS) for kind in self.kinds if kind not in KINDS)
        for name in ("noise", "noise_angle", "rounding", "outlier_size"):
            value = getattr(self, name)
            if not (np.isfinite(value).all() and np.min(value) >= 0.0):
                yield f"{name}: expected 0 or a positive number, found {value}"
        if np.shape(self.noise) not in ((), (3,)):
            yield f"noise: expected one number, or three for x, y and z, found {np.size(self.noise)}"
        elif "distance" in self.kinds and np.ptp(self.noise) > 0.0:
            yield "noise: a distance has one standard deviation, found three: leave out the distance, or give one"
        if not 0.0 <= self.outliers <= 1.0:
            yield f"outliers: expected a fraction of the rows, 0 to 1, found {self.outliers}"
        elif self.outliers and not {"position", "distance"} & set(self.kinds):
            yield "outliers are wrong positions or distances, of which neither is measured: add one to the kinds"


def read(instrument: Instrument, exact: Measurements, seed: int | np.random.Generator = 0) -> Measurements:
    """What an instrument reads where observations without error would be.

    Outliers are drawn last: without them the same seed gives the same readings of all other rows.

    Args:
        instrument: how it measures; its kinds are those of `exact`.
        exact: observations without error.
        seed: of noise and outliers.
    """
    rng = np.random.default_rng(seed)
    n = len(exact)
    turns = Rotation.from_rotvec(instrument.noise_angle * rng.standard_normal((n, 3))).as_matrix()
    scatter = rng.standard_normal((n, 4))
    noise = np.broadcast_to(instrument.noise, (3,))
    jumps = _jumps(instrument, n, rng)
    position, distance, step = exact.position, exact.distance, instrument.rounding
    return replace(
        exact,
        position=None if position is None else _rounded(position + noise * scatter[:, :3] + jumps[:, :3], step),
        orientation=None if exact.orientation is None else turns @ exact.orientation,
        distance=None if distance is None else _rounded(distance + noise[0] * scatter[:, 3] + jumps[:, 3], step),
        sigma=np.tile(noise, (n, 1)) if instrument.state_sigma and noise.any() else None,
        sigma_angle=np.full(n, instrument.noise_angle) if instrument.state_sigma and instrument.noise_angle else None,
    )


def _jumps(instrument: Instrument, n: int, rng: np.random.Generator) -> Array:
    """What outliers add to x, y, z and the distance, (n, 4)."""
    jumps = np.zeros((n, 4))
    rows = rng.choice(n, round(instrument.outliers * n), replace=False)
    directions = rng.standard_normal((len(rows), 3))
    jumps[rows, :3] = instrument.outlier_size * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    jumps[rows, 3] = instrument.outlier_size * rng.choice([-1.0, 1.0], len(rows))
    return jumps


def _rounded(values: Array, step: float) -> Array:
    """Values as multiples of a step; 0: as they are."""
    return step * np.round(values / step) if step else values
