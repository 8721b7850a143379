"""Screws into Jacobian columns: how the target moves with each coordinate of a twist in a frame."""

from __future__ import annotations

import numpy as np

from elastocal.chain.frames import Frames
from elastocal.chain.rotations import Array


def twist_columns(frames: Frames, target: Array, orientation: bool) -> Array:
    """What unit twists about the axes and origins of all frames do to a target (3, n).

    A twist is (v, w), the linear part first, so that an element's column is its screw times these six.

    Returns:
        (3, frames, 6, n), or (6, frames, 6, n) with the target's rotation vector below its displacement.
    """
    axes = frames.axes
    columns = np.empty((6 if orientation else 3, axes.shape[1], 6, axes.shape[3]))
    columns[:3, :, :3] = axes
    cross(axes, (target[:, None] - frames.origins)[:, :, None], out=columns[:3, :, 3:])
    if orientation:
        columns[3:, :, :3] = 0.0
        columns[3:, :, 3:] = axes
    return columns


def cross(left: Array, right: Array, out: Array | None = None) -> Array:
    """Cross product, components in the first axis; several times as fast as numpy.cross on such arrays."""
    if out is None:
        out = np.empty(np.broadcast_shapes(left.shape, right.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(left[j], right[k], out=out[i])
        out[i] -= left[k] * right[j]
    return out
