"""Deflections move the loads that cause them: the implicit function theorem in two small solves.

With slopes s = d(deflection)/d(load) and mutual gradients H = d(load)/d(deflection), a change of the loads by dt makes
the deflections change by (1 - s H)^-1 s dt. s H is of the order of the deflections themselves (1e-3 on a robot that is
worth calibrating), so that the geometric series converges in a few terms, on all poses at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastocal.chain import Array

PRECISION = 1e-8
MAX_TERMS = 200


def coupled_deflections(deflections: Array, slopes: Array, mutual: Array) -> Array:
    """(1 - s H)^-1 deflections, (elastic, n): what direct changes of the deflections amount to in the end.

    Infinite where there is no end: the element's load grows faster than it holds.
    """
    return _series(deflections, lambda x: slopes * np.einsum("lmn,mn->ln", mutual, x))


def coupled_columns(columns: Array, slopes: Array, mutual: Array) -> Array:
    """Columns times (1 - s H)^-1, (k, elastic, n): what a direct change of a deflection does, all answers included."""
    return _series(columns, lambda x: np.einsum("kln,lmn->kmn", x * slopes, mutual))


@np.errstate(over="ignore", invalid="ignore")
def _series(first: Array, apply: Callable[[Array], Array]) -> Array:
    total, previous = first, np.abs(first).max(initial=0.0)
    bound = PRECISION * previous
    for _ in range(MAX_TERMS):
        following = first + apply(total)
        change = np.abs(following - total).max(initial=0.0)
        if change * change <= bound * previous:  # the next term, as the last two foretell it
            return following
        total, previous = following, change
    return np.where(np.abs(following - total) <= bound, following, np.inf)
