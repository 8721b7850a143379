"""What the scripts of all tools share: the arm that they are given, and what they hand back. NumPy only."""

from __future__ import annotations

import argparse
import json
import os
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tools import ENDED


@dataclass(frozen=True)
class Arm:
    """The files of one arm.

    Attributes:
        folder: with robot.toml, robot.urdf, mdh.csv, fit.csv, figaroh.csv and held_out.csv.
        scratch: an empty folder that the script may write into.
        notes: sentences of the tool about its fit, which are stored with its result.
    """

    folder: Path
    scratch: Path
    notes: list[str]

    def table(self, name: str) -> np.ndarray:
        """The numbers below a CSV file's header."""
        return np.loadtxt(self.folder / name, delimiter=",", skiprows=1)

    @property
    def instrument_T_base(self) -> np.ndarray:  # noqa: N802
        """(4, 4), where the nominal robot stands: given to the tools that need to be aligned."""
        return np.array(self._aligned["instrument_T_base"])

    @property
    def flange_p_target(self) -> np.ndarray:
        """(3,) [m], where the target sits on the nominal robot: given to the tools that need to be aligned."""
        return np.array(self._aligned["flange_p_target"])

    @property
    def _aligned(self) -> dict[str, list]:
        return json.loads((self.folder / "aligned.json").read_text(encoding="utf-8"))


Predict = Callable[[np.ndarray], np.ndarray]
"""Joint positions (poses, 6) to the target's positions (poses, 3) in the instrument's frame."""


REPEATED_BELOW = 1.0
"""A fit that took fewer seconds is timed once more, now that all libraries are loaded."""


def main(settings: Mapping[str, Callable[[Arm], Predict]]) -> None:
    """Run one setting on arms: SCRIPT SETTING SCRATCH SECONDS ARMS.

    Libraries are loaded once; then each arm is fitted by a process forked from this one, which is killed after SECONDS.
    It writes outcome.json or error.txt into SCRATCH/NAME, and NAME is printed when it has ended. Times are those of the
    processor, of one thread: what else runs on the machine lengthens them little.
    """
    loaded = time.process_time()
    parser = argparse.ArgumentParser()
    parser.add_argument("setting", choices=list(settings))
    parser.add_argument("scratch", type=Path)
    parser.add_argument("seconds", type=int)
    parser.add_argument("arms", type=Path, nargs="+")
    given = parser.parse_args()
    for folder in given.arms:
        arm = Arm(folder.resolve(), given.scratch.resolve() / folder.name, [])
        arm.scratch.mkdir()
        child = os.fork()
        if not child:
            signal.alarm(given.seconds)
            _in_child(settings[given.setting], arm, loaded)
        os.waitpid(child, 0)
        print(f"\n{ENDED}{folder.name}", flush=True)


def _in_child(fit: Callable[[Arm], Predict], arm: Arm, loaded: float) -> None:
    """Fit, write, end this process."""
    try:
        predict, seconds = _timed(fit, arm)
        predicted = np.asarray(predict(arm.table("held_out.csv")))
        outcome = {
            "process_seconds": loaded + time.process_time(),
            "notes": list(arm.notes),
            "predicted": predicted.tolist(),
            "fit_seconds": min(seconds, _timed(fit, arm)[1]) if seconds < REPEATED_BELOW else seconds,
        }
        (arm.scratch / "outcome.json").write_text(json.dumps(outcome), encoding="utf-8")
    except Exception as error:
        (arm.scratch / "error.txt").write_text(f"{type(error).__name__}: {error}", encoding="utf-8")
    finally:
        os._exit(0)


def _timed(fit: Callable[[Arm], Predict], arm: Arm) -> tuple[Predict, float]:
    began = time.process_time()
    predict = fit(arm)
    return predict, time.process_time() - began
