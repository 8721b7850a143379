"""Covariances in files: as a matrix while people may look at it, else packed."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from elastocal.chain import Array

MOST_SHOWN = 120
"""Parameters whose covariance is written as a matrix; that of more, as of joint maps, would take megabytes."""


def covariance_table(names: Sequence[str], covariance: Array) -> dict[str, Any]:
    """Names and covariance (names, names), exact in either form.

    More than MOST_SHOWN parameters have "lower" instead of "matrix": the lower triangle with its diagonal, row by row,
    as little-endian 64-bit floats in base 64.
    """
    if len(names) <= MOST_SHOWN:
        return {"names": list(names), "matrix": covariance.tolist()}
    lower = np.ascontiguousarray(covariance[np.tril_indices(len(names))], dtype="<f8")
    return {"names": list(names), "lower": b64encode(lower.tobytes()).decode("ascii")}


def covariance_from(table: Mapping[str, Any]) -> Array:
    """The covariance that covariance_table wrote, as it is; whoever reads it checks its shape.

    Raises:
        ValueError: it is neither form.
    """
    if "matrix" in table:
        return np.array(table["matrix"], dtype=float)
    count = len(table["names"])
    lower = np.frombuffer(b64decode(table.get("lower", ""), validate=True), dtype="<f8")
    if len(lower) != count * (count + 1) // 2:
        raise ValueError(f"expected the lower triangle of {count} rows, found {len(lower)} numbers")
    covariance = np.zeros((count, count))
    covariance[np.tril_indices(count)] = lower
    return covariance + np.tril(covariance, -1).T
