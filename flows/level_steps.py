"""A scanner out of level spoils the lean without any other sign: leave out the one that harms, or name it.

The level is held by the adjustment, so a wrong one stays in the pose. It shows in that station's side of the shaft, which
leans against the common one. Without that station the others must agree; if they do not, another one may be the bad one.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeGuard

from flows.epoch_work import EpochResult, EpochWork
from flows.placing_steps import (
    ask_for_registration,
    ask_for_shaft,
    leave_out_refused,
    levels_of,
    registration_of,
)
from tasks.conventions import ARCSEC_RAD
from tasks.level_check import LevelCheck, worst_suspect
from tasks.produced import Produced
from tasks.registration import RefusedStation

ADVICE: Final = "check its level (compensator) and set it up again"


@dataclass(frozen=True, slots=True)
class _Trial:
    """The epoch without some stations."""

    without: tuple[str, ...]
    registration: Produced
    refused: tuple[RefusedStation, ...]
    shaft: Produced
    levels: Mapping[str, LevelCheck]


def leave_out_unlevel(work: EpochWork, result: EpochResult) -> None:
    """Leave out the station whose side of the shaft leans against the common one, where the others then agree.

    Else the next worst, or the worst two. Those that are left must be more than half; where that is not so, or nothing
    helps, all are used and the worst is named (of two stations both: nobody can say which one is wrong).
    """
    worst = _worst(result.levels)
    if worst is None:
        return
    if not _outvoted(1, len(result.levels)):
        for station, check in result.levels.items():
            result.suspects[station] = f"{_leans(check)}; of two stations either may be out; {ADVICE}"
        return
    n_stations = len(result.levels)
    accepted = next((trial for trial in _trials(work, result, worst) if _helps(trial, n_stations)), None)
    if accepted is None:
        result.suspects[worst] = f"{_leans(result.levels[worst])}; {ADVICE}"
    else:
        _accept(result, accepted)


def _trials(work: EpochWork, result: EpochResult, worst: str) -> Iterator[_Trial | None]:
    """The epoch without the worst station, without the next worst, without the worst two; each made when asked for."""
    first = _try_without(work, result, worst)
    yield first
    others = {station: check for station, check in result.levels.items() if station != worst}
    next_worst = _worst(others)
    if next_worst is not None:
        yield _try_without(work, result, next_worst)
    still_worst = None if first is None else _worst(first.levels)
    if still_worst is not None and _outvoted(2, len(result.levels)):
        yield _try_without(work, result, worst, still_worst)


def _try_without(work: EpochWork, result: EpochResult, *without: str) -> _Trial | None:
    """Register and isolate the epoch without some stations; None where that is refused."""
    scans = [scan for scan in result.used if scan.plan.station not in without]
    less = f"without {', '.join(without)}"
    registration = ask_for_registration(work, scans, result.stable, f"registration {less}")
    if registration.refusal is not None:
        return None
    shaft = ask_for_shaft(work, scans, registration, f"preprocessing {less}")
    if shaft.refusal is not None:
        return None
    refused = registration_of(work, registration).refused
    return _Trial(without, registration, refused, shaft, levels_of(work, registration, shaft))


def _helps(trial: _Trial | None, n_stations: int) -> TypeGuard[_Trial]:
    """Whether those that are left are enough, and agree."""
    if trial is None:
        return False
    n_out = len(trial.without) + len(trial.refused)
    return _outvoted(n_out, n_stations) and _worst(trial.levels) is None


def _accept(result: EpochResult, trial: _Trial) -> None:
    for station in trial.without:
        result.leave_out(station, f"{_leans(result.levels[station])}; left out; {ADVICE}")
    leave_out_refused(result, trial.refused)
    result.registration, result.shaft = trial.registration, trial.shaft
    result.levels.update(trial.levels)


def _worst(levels: Mapping[str, LevelCheck]) -> str | None:
    worst = worst_suspect(list(levels.values()))
    return None if worst is None else list(levels)[worst]


def _outvoted(n_out: int, n_stations: int) -> bool:
    return n_stations - n_out > n_out


def _leans(check: LevelCheck) -> str:
    lean = math.hypot(check.lean_east or 0.0, check.lean_north or 0.0) / ARCSEC_RAD
    return f"its side of the shaft leans {lean:.0f} arc seconds against the common one"
