"""How well the poses at hand tell the identified parameters: rank, condition and the observability indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from elastocal.chain import Array
from elastocal.identification.solver import Normal
from elastocal.identification.sums import Sums


@dataclass(frozen=True)
class Observability:
    """Of the Jacobian in metres per metre: each parameter counts by how far it moves the target at generic poses.

    Attributes:
        rank: how many directions of the parameters the data see.
        parameters: how many are identified.
        condition: largest over smallest singular value; inf below full rank.
        O1: (product of the singular values)^(1/parameters) / sqrt(poses) (Borm and Menq, 1989).
        O2: inverse of the condition number (Driels and Pathre, 1990).
        O3: smallest singular value (Nahvi and Hollerbach, 1994).
        O4: noise amplification, smallest singular value squared over the largest (Nahvi and Hollerbach, 1996).
        O5: 1 / sum(1 / singular values) (Sun and Hollerbach, 2008).
        singular_values: (parameters,) descending.
        weakest: of each parameter, its share in the direction that moves the targets least; the squares add up to 1.
    """

    rank: int
    parameters: int
    condition: float
    O1: float
    O2: float
    O3: float
    O4: float
    O5: float
    singular_values: tuple[float, ...] = ()
    weakest: Mapping[str, float] = field(default_factory=dict)


def observability(sums: Sums, scale: Array, poses: int, names: Sequence[str]) -> Observability:
    """Indices of the sums for parameters `names` whose unit moves the target by about `scale` (parameters,) [m]."""
    rank, parameters = int(Normal.of(sums).seen.sum()), len(scale)
    if not parameters:
        return Observability(0, 0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    unit = next(iter(sums.values())).variance
    gram = unit * sum(kind.gram[:-1, :-1] for kind in sums.values()) / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(gram)
    singular = np.sqrt(np.clip(values, 0.0, None))
    directions = tuple(singular[::-1].tolist()), dict(zip(names, vectors[:, 0].tolist(), strict=True))
    smallest, largest = float(singular[0]), float(singular[-1])
    if rank < parameters or smallest == 0.0:
        return Observability(rank, parameters, float("inf"), 0.0, 0.0, 0.0, 0.0, 0.0, *directions)
    return Observability(
        rank=rank,
        parameters=parameters,
        condition=largest / smallest,
        O1=float(np.exp(np.log(singular).mean()) / np.sqrt(poses)),
        O2=smallest / largest,
        O3=smallest,
        O4=smallest**2 / largest,
        O5=float(1.0 / (1.0 / singular).sum()),
        singular_values=directions[0],
        weakest=directions[1],
    )
