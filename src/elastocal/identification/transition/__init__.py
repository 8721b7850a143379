"""Transition torques of steps and hinges, and fits that respect their sides."""

from elastocal.identification.transition.find import find_torques
from elastocal.identification.transition.genetic import GeneticSearch
from elastocal.identification.transition.likelihood import STEP_RISE, TorqueCurve, TorqueMap, allowed_rise
from elastocal.identification.transition.outcome import TransitionData, free_torques, transitions_of
from elastocal.identification.transition.request import (
    Transition,
    given_torques,
    searched_laws,
    with_known_torques,
    with_transition,
)
from elastocal.identification.transition.search import Search, linear_model, problem_of
from elastocal.identification.transition.trial import HINGE_STEPS, Problem, Trial, fit_anew

__all__ = [
    "HINGE_STEPS",
    "STEP_RISE",
    "GeneticSearch",
    "Problem",
    "Search",
    "TorqueCurve",
    "TorqueMap",
    "Transition",
    "TransitionData",
    "Trial",
    "allowed_rise",
    "find_torques",
    "fit_anew",
    "free_torques",
    "given_torques",
    "linear_model",
    "problem_of",
    "searched_laws",
    "transitions_of",
    "with_known_torques",
    "with_transition",
]
