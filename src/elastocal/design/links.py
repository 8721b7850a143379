"""A robot's links as capsules: where they are, and how far they stay from boxes and from the floor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, forward, orientations, place, points
from elastocal.robot import Assembly

MOVES = 1e-6
"""A joint origin that moves less than this [m] over the poses stands still."""


class Posture(NamedTuple):
    """Where an undeflected robot is, in the frame that its chain starts from.

    Attributes:
        joints: (joint origins, 3, n) base, rows, tool and target, in this order [m].
        target: (3, n) the last of them.
        axes: (3 components, 3 axes, n) of the target.
    """

    joints: Array
    target: Array
    axes: Array


def posture(assembly: Assembly, q: Array) -> Posture:
    """The robot's origins at the controller's joint positions q (n, joints); deflections are left out."""
    chain = assembly.mechanism.chain
    placement = place(chain, chain.values)
    frames = forward(placement, assembly.motion(np.ascontiguousarray(q.T)))
    marks = zip(chain.mark_frames.tolist(), placement.mark_origins, strict=True)
    last = len(placement.steps)
    target = points(frames, last, placement.tip_origin)
    joints = [points(frames, frame, origin) for frame, origin in marks]
    return Posture(np.stack([*joints, target]), target, orientations(frames, last, placement.tip_rotation))


def moving(joints: Array) -> NDArray[np.bool_]:
    """Which links (joint origins − 1,) move over the poses of joint origins (m, 3, n).

    What stands still, as the pedestal, no choice of poses keeps out of anything.
    """
    moves = np.ptp(joints, axis=2).max(axis=1) > MOVES
    return moves[:-1] | moves[1:]


def distance_to_box(starts: Array, ends: Array, low: Array, high: Array) -> Array:
    """Least distance of segments from a box.

    Half the slope of the squared distance along a segment is piecewise linear and grows, with kinks where the segment
    passes a face's plane: its root is found between the two kinks that it lies between.

    Args:
        starts: (..., 3, n) of the segments [m].
        ends: of the same shape.
        low: (3,) least coordinates of the box.
        high: (3,) greatest ones.

    Returns:
        (..., n) [m]; 0 where a segment meets the box.
    """
    along = ends - starts
    low, high = low[:, None], high[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        kinks = [np.nan_to_num((face - starts) / along, nan=0.0) for face in (low, high)]
    inner = np.clip(np.concatenate(kinks, axis=-2), 0.0, 1.0)
    ends_too = np.concatenate([np.zeros_like(inner[..., :1, :]), inner, np.ones_like(inner[..., :1, :])], axis=-2)
    times = np.sort(ends_too, axis=-2)  # (..., 8, n)
    where = starts[..., None, :, :] + times[..., :, None, :] * along[..., None, :, :]
    outside = where - np.clip(where, low, high)
    slopes = (outside * along[..., None, :, :]).sum(axis=-2)
    after = np.clip((slopes < 0.0).sum(axis=-2), 1, times.shape[-2] - 1)[..., None, :]
    t0, t1 = (np.take_along_axis(times, index, axis=-2)[..., 0, :] for index in (after - 1, after))
    s0, s1 = (np.take_along_axis(slopes, index, axis=-2)[..., 0, :] for index in (after - 1, after))
    rise = s1 - s0
    share = np.clip(np.divide(-s0, rise, out=np.zeros_like(rise), where=rise > 0.0), 0.0, 1.0)
    nearest = starts + (t0 + share * (t1 - t0))[..., None, :] * along
    return np.linalg.norm(nearest - np.clip(nearest, low, high), axis=-2)


def lowest(starts: Array, ends: Array) -> Array:
    """Least height (z) of segments (links, 3, n), all together, (n,); infinite without any."""
    return np.minimum(starts[:, 2], ends[:, 2]).min(axis=0, initial=np.inf)
