"""The misfit at all combinations at once: equal to dense least squares, and to full fits but for second order."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from elastocal.identification.transition.candidates import best_combinations
from elastocal.identification.transition.profile import Profile, profile_of
from elastocal.identification.transition.search import search_exactly
from elastocal.identification.transition.trial import Problem, fit_at
from elastocal.measurements import Measurements, concatenate
from elastocal.robot import Frame, Payload, Robot
from elastocal.simulation import random_poses, simulate
from support.calibrations import measured
from support.robots import arm
from support.transitions import actual_arm, dense_misfit, one_blas_thread, problem, springs

__all__ = ["one_blas_thread"]

LAWS = {
    "step": {"2": "step"},
    "hinge": {"3": "hinge"},
    "steps": {"2": "step", "3": "step"},
    "hinges": {"2": "hinge", "3": "hinge"},
    "step and hinge": {"3": "step", "2": "hinge"},
    "three": {"2": "step", "3": "hinge", "5": "step"},
}


def profiled(posed: Problem) -> Profile:
    """The profile about a problem's last fit."""
    model = posed.model(posed.torques)
    return profile_of(model, posed.start, posed.variances, posed.laws, posed.grids)


def drawn(profile: Profile, count: int) -> np.ndarray:
    """Combinations by chance, the first and the last torques among them."""
    counts = np.array(profile.counts)
    some = np.random.default_rng(0).integers(0, counts, (count, len(counts)))
    return np.vstack([np.zeros_like(counts), counts - 1, some])


def plain(laws: dict[str, str]) -> tuple[Robot, Measurements]:
    """One target's positions."""
    return arm(), measured(actual_arm(arm(), laws), 60, 1, noise=3e-5)


def rich(laws: dict[str, str]) -> tuple[Robot, Measurements]:
    """Payloads, targets, stated deviations, orientations of some rows and distances of others, in one mixed order."""
    nominal = replace(
        arm(),
        targets={"a": Frame((0.1, 0.0, 0.05)), "b": Frame((0.0, 0.12, 0.0))},
        loads={"heavy": Payload(15.0, (0.0, 0.05, 0.1))},
        base=Frame((1.0, -2.0, 0.3), (0.0, 0.1, 0.5)),
        tool=Frame(known=True),
    )
    actual = replace(nominal.displaced({"2.alpha": 1e-3, "3.a": 1e-3, "base.tx": 2e-3}), elastic=springs(laws))
    parts = []
    for i, (target, load, kinds) in enumerate(
        [("a", None, ("position",)), ("b", "heavy", ("position", "orientation")), ("a", "heavy", ("distance",))]
    ):
        q = random_poses(actual, 30, i)
        options = {"target": target, "load": load, "state_sigma": True, "seed": i}
        parts.append(simulate(actual, q, kinds=kinds, noise=3e-5, noise_angle=1e-4, **options))
    return nominal, concatenate(parts).take(np.random.default_rng(4).permutation(90))


@pytest.mark.parametrize("scene", [plain, rich])
@pytest.mark.parametrize("case", LAWS)
def test_the_profile_is_what_dense_least_squares_leaves(case: str, scene):
    """About the fit with linear laws, and about the best fit with transitions."""
    posed = problem(*scene(LAWS[case]), LAWS[case])
    for about in (posed, posed.after(search_exactly(posed)[0])):
        profile = profiled(about)
        indices = drawn(profile, 12)
        expected = [dense_misfit(about, about.torques_of(combination)) for combination in indices]
        np.testing.assert_allclose(profile.misfits(indices), expected, rtol=2e-8)


@pytest.mark.parametrize("case", ["step", "hinge", "steps", "hinges", "step and hinge"])
def test_all_misfits_are_those_of_each_combination(case: str):
    profile = profiled(problem(*plain(LAWS[case]), LAWS[case]))
    every = np.array(list(product(*map(range, profile.counts))))
    found = profile.all_misfits()
    assert found.shape == profile.counts
    np.testing.assert_allclose(found.ravel(), profile.misfits(every), rtol=1e-7)


@pytest.mark.parametrize("case", LAWS)
def test_the_misfit_of_the_linear_laws_is_that_of_their_fit_and_transitions_only_lower_it(case: str):
    posed = problem(*plain(LAWS[case]), LAWS[case])
    profile = profiled(posed)
    assert profile.misfit == pytest.approx(posed.misfit, rel=1e-8)
    assert (profile.misfits(drawn(profile, 200)) <= profile.misfit * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("case", LAWS)
def test_the_profile_about_the_linear_laws_foretells_full_fits_to_first_order(case: str):
    posed = problem(*plain(LAWS[case]), LAWS[case])
    profile = profiled(posed)
    indices = drawn(profile, 8)
    foretold = profile.misfits(indices)
    full = np.array([fit_at(posed, posed.torques_of(combination)).misfit for combination in indices])
    gained = posed.misfit - full
    np.testing.assert_array_less(np.abs(foretold - full), 0.01 * gained + 1e-3 * gained.max())


@pytest.mark.parametrize("laws", [LAWS["three"], {"2": "hinge", "3": "step", "5": "hinge"}])
@pytest.mark.parametrize("seed", range(4))
def test_exchange_finds_what_comparing_all_combinations_of_three_elements_finds(laws: dict[str, str], seed: int):
    data = measured(actual_arm(arm(), laws, seed), 40, seed, noise=(3e-5, 3e-4)[seed % 2])
    profile = profiled(problem(arm(), data, laws))
    every = np.stack(np.meshgrid(*map(np.arange, profile.counts), indexing="ij"), axis=-1).reshape(-1, 3)
    best = best_combinations(profile, 3, seed)
    assert profile.misfits(np.array(best[:1]))[0] == pytest.approx(profile.misfits(every).min(), rel=1e-12)
    expected = profile.misfits(np.array(best))
    assert (np.diff(expected) >= 0.0).all()


def test_the_best_combinations_are_apart_from_one_another():
    for case in ("step", "steps", "three"):
        profile = profiled(problem(*plain(LAWS[case]), LAWS[case]))
        best = best_combinations(profile, 3)
        for one, other in pairwise(best):
            shares = np.abs(np.subtract(one, other)) / profile.counts
            assert shares.max() > 0.05
