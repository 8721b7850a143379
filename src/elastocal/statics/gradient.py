"""How loads change when the chain moves: the second derivatives of the potential energy.

A load's change under a twist (v, w) is a virtual power f . v + m . w, so each gradient is itself a wrench (f, m) on the
body that moves. A twist deep in the chain moves part of what presses on the element; one between the robot's base and
the element turns the element and all beyond it against gravity; one before the base turns gravity too and changes
nothing. An external wrench follows the tool, so that only twists between the element and the tool change its load.
"""

from __future__ import annotations

import numpy as np

from elastocal.chain import Array, cross
from elastocal.statics.loads import Statics, Wrench, twists


def mutual_gradients(statics: Statics) -> Array:
    """d(loads)/d(elastic elements' values), (elements, elements, n): row the load, column the element moved."""
    gradients = np.einsum("cln,cmn->lmn", _turned(statics), statics.moved)
    lower = statics.mechanism.below_diagonal
    gradients[lower] = gradients.swapaxes(0, 1)[lower]  # gravity has a potential
    if statics.wrench is not None:
        angular, linear = _twists(statics)
        force, moment = _follower(angular, linear, statics.wrench)
        follower = np.einsum("cln,cmn->lmn", force, linear) + np.einsum("cln,cmn->lmn", moment, angular)
        follower[lower] = 0.0
        gradients += follower
    return gradients


class WeightedGradients:
    """sum_l weights[k, l] d(load l)/d(value of an element of the chain), for weights (k, elements, n)."""

    def __init__(self, statics: Statics, weights: Array) -> None:
        self._statics = statics
        self._still = statics.mechanism.masses_before_bodies(statics.placement)
        self._turned = _sums_before(weights, _turned(statics))
        self._tipped = _sums_from(weights, cross(statics.moved, statics.gravity[:, None, None]))
        if statics.wrench is not None:
            self._angular, self._linear = (_sums_before(weights, part) for part in _twists(statics))

    def of_body(self, body: int, screws: Array) -> Array:
        """(k, p, n) for elements of one body, by their screws (p, 6)."""
        statics, chain = self._statics, self._statics.mechanism.chain
        frame = chain.body_frames[body]
        axes, origin = statics.frames.axes[:, frame], statics.frames.origins[:, frame]
        before = int(np.searchsorted(statics.mechanism.elastic_rows, frame))  # elements that do not move with the body
        linear, angular = screws[:, :3] @ axes, screws[:, 3:] @ axes
        gradients = np.zeros((self._turned.shape[2], len(screws), origin.shape[-1]))
        if before > 0:  # they feel what hangs beyond the body move
            arm = statics.moment[:, frame] - statics.mass[frame] * origin
            if self._still.mass[body] > 0.0:
                arm -= self._still.moment[body] @ axes
            moved = cross(angular, arm[:, None])
            moved += (statics.mass[frame] - self._still.mass[body]) * linear
            gradients += np.einsum("cpn,ckn->kpn", moved, self._turned[:, before])
        if before < len(statics.mechanism.elastic) and body > chain.mark_bodies[0]:  # the others turn against gravity
            gradients += np.einsum("cpn,ckn->kpn", angular, self._tipped[:, before])
        if statics.wrench is not None and before > 0 and body <= chain.mark_bodies[-1]:
            pull, turn = _follower(self._angular[:, before], self._linear[:, before], statics.wrench)
            gradients += np.einsum("cpn,ckn->kpn", linear, pull)
            gradients += np.einsum("cpn,ckn->kpn", angular, turn - cross(origin[:, None], pull))
        return gradients


def _twists(statics: Statics) -> tuple[Array, Array]:
    return twists(statics.axes, statics.origins, statics.mechanism.elastic_turns)


def _turned(statics: Statics) -> Array:
    """The elastic elements' g x a, (3, elements, n): what a change of the first moment beyond does to their loads."""
    turned = cross(statics.gravity[:, None, None], statics.axes)
    turned[:, ~statics.mechanism.elastic_turns] = 0.0
    return turned


def _follower(angular: Array, linear: Array, wrench: Wrench) -> tuple[Array, Array]:
    """The gradient (force, moment about the origin) of the load that a wrench on the tool puts on twists (3, k, n)."""
    force, moment = wrench.force[:, None], wrench.moment[:, None]
    return cross(force, angular), cross(moment, angular) + cross(force, linear)


def _sums_before(weights: Array, vectors: Array) -> Array:
    """Sums of weights (k, elements, n) x vectors (3, elements, n) over the elements before each.

    Returns:
        (3, elements + 1, k, n).
    """
    count, elements, n = weights.shape
    sums = np.zeros((3, elements + 1, count, n))
    for element in range(elements):
        np.multiply(vectors[:, element, None], weights[:, element], out=sums[:, element + 1])
        sums[:, element + 1] += sums[:, element]
    return sums


def _sums_from(weights: Array, vectors: Array) -> Array:
    """Likewise over each element and those after it."""
    return _sums_before(weights[:, ::-1], vectors[:, ::-1])[:, ::-1]
