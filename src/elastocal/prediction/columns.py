"""The identification Jacobian of one block: how the target moves with elements' values and law coefficients."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, cross, orientations, points, twist_columns
from elastocal.elasticity import Equilibrium, coupled_columns
from elastocal.statics import WeightedGradients


def target_position(state: Equilibrium) -> Array:
    """The measured target in the instrument's frame, (3, n)."""
    statics, position = state.statics, _target(state)
    if state.remainder.any():
        step, turns = statics.axes * state.remainder, statics.mechanism.elastic_turns
        arms = position[:, None] - statics.origins
        position += cross(step[:, turns], arms[:, turns]).sum(axis=1) + step[:, ~turns].sum(axis=1)
    return position


def _target(state: Equilibrium) -> Array:
    """The target short of equilibrium by the last step."""
    placement = state.statics.placement
    return points(state.statics.frames, len(placement.steps), placement.tip_origin)


def target_rotation(state: Equilibrium) -> Array:
    """The measured target's rotation into the instrument's frame, (3, 3, n)."""
    statics = state.statics
    rotation = orientations(statics.frames, len(statics.placement.steps), statics.placement.tip_rotation)
    step = (statics.axes * state.remainder)[:, statics.mechanism.elastic_turns].sum(axis=1)
    return rotation + cross(step[:, None], rotation)


def fill_jacobian(
    state: Equilibrium,
    elements: NDArray[np.intp],
    coefficients: list[tuple[int, int]],
    coupled: bool,
    out: Array,
) -> None:
    """Columns of the target for element values and for law coefficients.

    Args:
        state: the poses at rest.
        elements: indices of elements in the chain, ascending.
        coefficients: (elastic element, number of its coefficient) each; after the last one comes a transition torque.
        coupled: whether deflections answer to the loads that change with the elements; else they are held.
        out: (3 or 6, elements + coefficients, n) is filled: displacement and, if 6, rotation vector of the target, in
            the instrument's frame [m or rad, per unit of each].
    """
    statics = state.statics
    mechanism = statics.mechanism
    target = _target(state)  # as the frames have it: the last step to equilibrium would not fit them
    twists = twist_columns(statics.frames, target, orientation=len(out) == 6)
    answer = twists[:, mechanism.elastic_rows + 1, np.where(mechanism.elastic_turns, 5, 2)]
    coupled = coupled and len(mechanism.elastic) > 0
    if coupled:
        answer = coupled_columns(answer, state.slopes, state.mutual)
        gradients = WeightedGradients(statics, answer * state.slopes)

    screws = statics.placement.screws[elements]
    bodies, first = np.unique(mechanism.chain.body_of[elements], return_index=True)
    for body, start, end in zip(bodies, first, [*first, len(elements)][1:], strict=True):
        np.matmul(screws[start:end], twists[:, mechanism.chain.body_frames[body]], out=out[:, start:end])
        if coupled and mechanism.presses(body, wrench=statics.wrench is not None):
            out[:, start:end] += gradients.of_body(body, screws[start:end])
    for row, (spring, k) in enumerate(coefficients, start=len(elements)):
        np.multiply(answer[:, spring], state.partials[spring][k], out=out[:, row])
