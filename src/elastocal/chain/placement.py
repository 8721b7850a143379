"""What of a chain does not change from pose to pose: where every element sits in its frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.chain.elements import Chain
from elastocal.chain.rotations import Array, skew


@dataclass(frozen=True)
class Placement:
    """The chain's constants at given element values.

    Attributes:
        steps: (moving, 4, 3). Rows 0-2: the axes of the next frame, its z axis along the moving element, in the
            previous frame; row 3: its origin.
        own_values: (moving,) the moving elements' own constant values, to which joint position and deflection add.
        rotates: (moving,) whether the moving element rotates.
        screws: (elements, 6) the twist of each element per unit of its value, in its frame about its origin:
            linear part first.
        mark_rotations: (marks, 3, 3) and mark_origins: (marks, 3) the running frame at each mark, in its frame.
        tip_rotation: (3, 3) and tip_origin: (3,) the end of the chain, in the last frame.
    """

    steps: Array
    own_values: Array
    rotates: np.ndarray
    screws: Array
    mark_rotations: Array
    mark_origins: Array
    tip_rotation: Array
    tip_origin: Array


def place(chain: Chain, values: Array) -> Placement:
    """Place every element of the chain in its frame, for element values (elements,)."""
    moving = chain.moving_index
    transforms = _transforms(chain, values)
    starts = dict(zip(chain.moving, chain.alignments, strict=True))

    steps = np.empty((len(starts), 4, 3))
    before = np.empty_like(transforms)  # the running frame at each element, in that element's frame
    after = np.empty_like(transforms)
    running = _IDENTITY
    following = 0
    for i, value in enumerate(values.tolist()):
        align = starts.get(i)
        if align is not None:  # its motion is the step from frame to frame
            steps[following, :3] = (running[:3, :3] @ align[:3, :3]).T
            steps[following, 3] = running[:3, 3]
            following += 1
            before[i] = running = align.T
        else:
            before[i] = running
            if value != 0.0:
                running = running @ transforms[i]
        after[i] = running

    marked = after[np.array(chain.marks, dtype=int) - 1]
    return Placement(
        steps=steps,
        own_values=values[moving],
        rotates=chain.rotates[moving],
        screws=_screws(chain, before),
        mark_rotations=marked[:, :3, :3],
        mark_origins=marked[:, :3, 3],
        tip_rotation=running[:3, :3],
        tip_origin=running[:3, 3],
    )


_IDENTITY = np.eye(4)


def _transforms(chain: Chain, values: Array) -> Array:
    """The elements as homogeneous matrices (elements, 4, 4), rotations by Rodrigues' formula."""
    angles = np.where(chain.rotates, values, 0.0)[:, None, None]
    cross, square = chain.cross_matrices
    transforms = np.zeros((len(values), 4, 4))
    transforms[:, 3, 3] = 1.0
    transforms[:, :3, :3] = _IDENTITY[:3, :3] + np.sin(angles) * cross + (1.0 - np.cos(angles)) * square
    transforms[:, :3, 3] = chain.axes * np.where(chain.rotates, 0.0, values)[:, None]
    return transforms


def _screws(chain: Chain, before: Array) -> Array:
    """Twists (elements, 6) about the origins of the elements' frames: v = o x u and w = u, or v = u and w = 0."""
    axes = (before[:, :3, :3] @ chain.axes[:, :, None])[:, :, 0]
    moments = (skew(before[:, :3, 3]) @ axes[:, :, None])[:, :, 0]
    rotates = chain.rotates[:, None]
    screws = np.empty((len(axes), 6))
    screws[:, :3] = np.where(rotates, moments, axes)
    screws[:, 3:] = axes * rotates
    return screws
