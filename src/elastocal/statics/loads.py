"""Generalised loads: how gravity and an external wrench press on each elastic element.

Everything is in the instrument's frame and about its origin. An element is the twist (a, c): a = u, c = o x u for a
rotation about u through o; a = 0, c = u for a translation. Under total force F and moment M of all that hangs beyond
it, it carries a . M + c . F. Gravity's part comes from the mass m and the first moment S = sum(m r) beyond the element:
F = m g, M = S x g, so that this load is g . (a x S + m c), the work of gravity when the element moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, Frames, Placement, cross, orientations, points
from elastocal.statics.mechanism import Mechanism


@dataclass(frozen=True)
class Wrench:
    """An external wrench on the tool, about the instrument's origin: force [N] and moment [N m], (3, n) each."""

    force: Array
    moment: Array


@dataclass(frozen=True)
class Statics:
    """A block of poses under load; `elements` are the elastic ones, in chain order.

    Attributes:
        gravity: (3,) [m/s2] in the instrument's frame.
        mass: (frames,) [kg] all that hangs in each frame and beyond, and `moment` (3, frames, n) its first moment.
        wrench: the external wrench, if any.
        axes: (3, elements, n) the elements' axes u, and `origins` likewise o.
        moved: (3, elements, n) change of the first moment beyond the element per unit of its value, a x S + m c.
        loads: (elements, n) N m on a rotation, N on a translation.
    """

    mechanism: Mechanism
    placement: Placement
    frames: Frames
    gravity: Array
    mass: Array
    moment: Array
    wrench: Wrench | None
    axes: Array
    origins: Array
    moved: Array
    loads: Array


def load(mechanism: Mechanism, placement: Placement, frames: Frames, wrench: Array | None = None) -> Statics:
    """Load a placed chain by gravity and by a wrench (6, n) on the tool, force first, in the tool's frame."""
    gravity = placement.mark_rotations[0] @ mechanism.gravity
    mass, moment = _hanging(mechanism, placement, frames)
    at, turns = mechanism.elastic_rows + 1, mechanism.elastic_turns
    axes, origins = frames.axes[:, at, 2], frames.origins[:, at]
    moved = cross(axes, moment[:, at] - mass[at, None] * origins)  # u x (S - m o): one product for a x S + m c
    if not turns.all():
        moved = np.where(turns[:, None], moved, mass[at, None] * axes)
    loads = np.einsum("c,cln->ln", gravity, moved)
    external = None
    if wrench is not None:
        external = _tool_wrench(mechanism, placement, frames, wrench)
        angular, linear = twists(axes, origins, turns)
        loads += (angular * external.moment[:, None] + linear * external.force[:, None]).sum(axis=0)
    return Statics(mechanism, placement, frames, gravity, mass, moment, external, axes, origins, moved, loads)


def twists(axes: Array, origins: Array, turns: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Twists a and c about the instrument's origin, (3, k, n) each, of elements that turn, or slide, along axes."""
    return axes * turns[:, None], np.where(turns[:, None], cross(origins, axes), axes)


def _hanging(mechanism: Mechanism, placement: Placement, frames: Frames) -> tuple[Array, Array]:
    """Mass and first moment from each frame to the tip."""
    local = mechanism.masses_in_frames(placement)
    moment = (local.moment[:, None] @ frames.axes)[:, :, 0]
    moment += local.mass[:, None] * frames.origins
    for frame in range(len(local.mass) - 2, -1, -1):
        moment[:, frame] += moment[:, frame + 1]
    return np.cumsum(local.mass[::-1])[::-1], moment


def _tool_wrench(mechanism: Mechanism, placement: Placement, frames: Frames, wrench: Array) -> Wrench:
    frame = mechanism.chain.mark_frames[-1]
    axes = orientations(frames, frame, placement.mark_rotations[-1])
    force, moment = np.einsum("can,wan->wcn", axes, wrench.reshape(2, 3, -1))
    return Wrench(force, moment + cross(points(frames, frame, placement.mark_origins[-1]), force))
