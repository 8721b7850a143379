"""The forward pass: every frame of the chain, for a block of poses at once.

Components come first and poses last: an array over frames is (3 components, frames, ..., n).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.chain.placement import Placement
from elastocal.chain.rotations import Array


class Frames(NamedTuple):
    """The chain's frames in the instrument's: `axes` (3, frames, 3 axes, n) and `origins` (3, frames, n)."""

    axes: Array
    origins: Array


def forward(placement: Placement, motion: Array) -> Frames:
    """The frames at the moving elements' motion (moving, n): joint positions and deflections, without own values."""
    moving, n = motion.shape
    axes = np.empty((3, moving + 1, 3, n))
    origins = np.empty((3, moving + 1, n))
    axes[:, 0] = np.eye(3)[:, :, None]
    origins[:, 0] = 0.0
    positions = motion + placement.own_values[:, None]
    sines, cosines = _sines_and_cosines(positions)
    step = np.empty((3, 4, n))
    for m in range(moving):
        np.matmul(placement.steps[m], axes[:, m], out=step)
        np.add(origins[:, m], step[:, 3], out=origins[:, m + 1])
        x, y, z = axes[:, m + 1].swapaxes(0, 1)
        z[...] = step[:, 2]
        if placement.rotates[m]:
            xy = axes[:, m + 1, :2]
            np.multiply(step[:, :2], cosines[m], out=xy)
            step[:, :2] *= sines[m]
            x += step[:, 1]
            y -= step[:, 0]
        else:
            axes[:, m + 1, :2] = step[:, :2]
            origins[:, m + 1] += z * positions[m]
    return Frames(axes, origins)


def _sines_and_cosines(angles: Array) -> tuple[Array, Array]:
    """By the tangent of the half angle: NumPy vectorises it, but not sine and cosine: four times as fast."""
    tangent = np.tan(0.5 * angles)
    square = tangent * tangent
    inverse = 1.0 / (1.0 + square)
    tangent *= 2.0
    tangent *= inverse
    np.subtract(1.0, square, out=square)
    square *= inverse
    return tangent, square


def points(frames: Frames, frame: int, local: Array) -> Array:
    """A point (3,) fixed in a frame, in the instrument's, (3, n)."""
    return local @ frames.axes[:, frame] + frames.origins[:, frame]


def orientations(frames: Frames, frame: int, local: Array) -> Array:
    """A rotation (3, 3) fixed in a frame, in the instrument's: (3 components, 3 axes, n)."""
    return local.T @ frames.axes[:, frame]
