"""A request in words, as options of a command, cells of a table and files have it: "2:step,3", "exact", "auto"."""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.identification.transition import GeneticSearch, Transition


def laws_of(option: str, text: str | None) -> dict[str, str]:
    """Laws by element from "2:step,3:hinge,5": an element without a law is linear.

    Args:
        option: what the text was given to, "--elastic".
        text: the words; None: no element.

    Raises:
        InputError: an element is named twice, or none is.
    """
    laws: dict[str, str] = {}
    for item in (text or "").split(",") if text is not None else ():
        element, _, law = item.strip().partition(":")
        if not element:
            raise InputError(
                f"{option} {text}: expected elements as in 2,3 or 2:linear,3.alpha:linear, found an empty one"
            )
        if element in laws:
            raise InputError(f"{option} {text}: element {element!r} is named twice")
        laws[element] = law.strip() or "linear"
    return laws


def transition_of(
    option: str, text: str, population: int | None = None, generations: int | None = None, sizes: str = ""
) -> Transition:
    """How transition torques are found, from "exact", "ga" or "222,80".

    Args:
        option: what the text was given to, "--transition".
        text: the words.
        population: combinations in each generation of a genetic search.
        generations: how many there are.
        sizes: the sentence's subject if these are given without one, "--population and --generations".

    Raises:
        InputError: it is none of these, or the size of a genetic search is given without one.
    """
    if text == "ga":
        usual = GeneticSearch()
        return GeneticSearch(population or usual.population, generations or usual.generations)
    if population is not None or generations is not None:
        raise InputError(f"{sizes} go with {option} ga")
    if text == "exact":
        return text
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(
            f"{option} {text}: expected exact, ga, or torques in N m with commas between them, as 222,80"
        ) from None


def orders_of(option: str, text: str) -> int | str:
    """Orders of joint maps, from a number or "auto".

    Raises:
        InputError: it is neither.
    """
    if text == "auto":
        return text
    if not text.isdecimal():
        raise InputError(f"{option} {text}: expected a number of orders, as 60, or auto")
    return int(text)
