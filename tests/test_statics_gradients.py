"""How loads change when the chain moves: the potential's second derivatives, against differences of the loads."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from elastocal.chain import Placement, forward, place
from elastocal.robot import Assembly, assemble
from elastocal.statics import Statics, WeightedGradients, load, mutual_gradients
from support.differences import central_difference
from support.robots import random_dh_robot
from support.urdf import compliant, equipped

OTHERS = ("1.a", "2.alpha", "3.a", "4.b", "5.beta", "tool.rx", "tool.tz")
AGREES = 1e-9
STEP = 1e-3


@dataclass(frozen=True)
class Scene:
    """An assembly at given joint positions, whose elements and deflections can be moved."""

    assembly: Assembly
    q: np.ndarray
    wrench: np.ndarray | None

    @cached_property
    def values(self) -> np.ndarray:
        """The elements' own values."""
        return self.assembly.mechanism.chain.values

    def placement(self, element: int = 0, by: float = 0.0) -> Placement:
        """The chain's constants with one element moved."""
        return place(self.assembly.mechanism.chain, self.values + by * (np.arange(len(self.values)) == element))

    def statics(self, placement: Placement | None = None, row: int = 0, deflection: float = 0.0) -> Statics:
        """The loads, the elastic element `row` deflected."""
        mechanism = self.assembly.mechanism
        placement = placement or self.placement()
        motion = self.assembly.motion(self.q.T)
        motion[mechanism.elastic_rows[row]] += deflection
        return load(mechanism, placement, forward(placement, motion), None if self.wrench is None else self.wrench.T)


def scene(convention: str, seed: int, where: tuple, pulled: bool, prismatic: float = 0.35) -> Scene:
    rng = np.random.default_rng(seed)
    robot = compliant(equipped(random_dh_robot(rng, convention, prismatic=prismatic), rng), OTHERS, 0.0, 0.0)
    q = rng.uniform(-2.0, 2.0, (4, 6))
    return Scene(assemble(robot, *where), q, 50.0 * rng.normal(size=(4, 6)) if pulled else None)


SCENES = pytest.mark.parametrize(
    ("convention", "seed", "where", "pulled"),
    [
        ("modified-dh", 1, (None, None, None), False),
        ("modified-dh", 2, ("north", "near", "heavy"), True),
        ("standard-dh", 3, (None, "far", "heavy"), False),
        ("standard-dh", 4, (None, None, None), True),
    ],
    ids=["modified", "modified, pulled, all frames", "standard, all frames", "standard, pulled"],
)


@SCENES
def test_mutual_gradients_are_derivatives_of_the_loads(convention: str, seed: int, where: tuple, pulled: bool) -> None:
    it = scene(convention, seed, where, pulled)
    gradients = mutual_gradients(it.statics())
    size = np.abs(gradients).max()
    for row in range(len(it.assembly.springs)):
        difference = central_difference(lambda t, r=row: it.statics(row=r, deflection=t).loads, STEP)
        np.testing.assert_allclose(gradients[:, row], difference, rtol=0, atol=AGREES * size)


@SCENES
def test_weighted_gradients_are_derivatives_by_every_element_of_the_chain(
    convention: str, seed: int, where: tuple, pulled: bool
) -> None:
    it = scene(convention, seed, where, pulled)
    statics, chain = it.statics(), it.assembly.mechanism.chain
    weights = np.random.default_rng(seed).normal(size=(2, *statics.loads.shape))
    gradients = WeightedGradients(statics, weights)
    found, expected = [], []
    for element in range(len(chain.elements)):
        if chain.elements[element].name:
            screw = statics.placement.screws[element : element + 1]
            found.append(gradients.of_body(chain.body_of[element], screw)[:, 0])
            change = central_difference(lambda t, e=element: it.statics(it.placement(e, t)).loads, STEP)
            expected.append(np.einsum("kln,ln->kn", weights, change))
    assert len(found) == 48 + (6 if where[1] else 0)
    np.testing.assert_allclose(found, expected, rtol=0, atol=AGREES * np.abs(expected).max())


@SCENES
def test_a_body_that_does_not_press_changes_no_load(convention: str, seed: int, where: tuple, pulled: bool) -> None:
    it = scene(convention, seed, where, pulled)
    mechanism = it.assembly.mechanism
    still = [
        element
        for element, body in enumerate(mechanism.chain.body_of)
        if not mechanism.presses(int(body), wrench=pulled) and mechanism.chain.elements[element].name
    ]
    prefixes = {mechanism.chain.elements[element].name.rpartition(".")[0] for element in still}
    base = "base" if where[0] is None else f"station.{where[0]}"
    assert prefixes == {base} | ({"tool"} if not pulled else set()) | ({f"target.{where[1]}"} if where[1] else set())
    before = it.statics().loads
    for element in still:
        np.testing.assert_allclose(
            it.statics(it.placement(element, 0.1)).loads, before, rtol=0, atol=1e-12 * np.abs(before).max()
        )


@pytest.mark.parametrize("prismatic", [0.0, 0.5])
def test_mutual_gradients_of_gravity_are_symmetric(prismatic: float) -> None:
    gradients = mutual_gradients(scene("standard-dh", 9, (None, "near", "heavy"), False, prismatic).statics())
    np.testing.assert_array_equal(gradients, gradients.swapaxes(0, 1))
