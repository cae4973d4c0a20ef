"""Test what is stated of the poses against the scans, and give up the statements that are wrong, worst first."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.registration.adjustment import (
    Adjusted,
    Gates,
    Network,
    adjust,
    rotation_vector_from,
    stated_minus_present,
)
from tasks.registration.stated import PARTS, StatedPose
from tasks.registration.station import StationPose

SUSPECT_SIGMAS: Final = 4.5
"""A correction beyond this many of its own sigmas is no chance: that happens in one of 3,000 epochs of 8 stations.
Its sigma is that of Baarda's test, sqrt(stated - adjusted variance), because a held parameter hardly gives."""

TESTABLE: Final = 0.01
"""Share of the stated variance that the scans must take away before a correction can be tested."""

ONE_FOR_TWO: Final = 4.5 / 4.878
"""4.5 sigmas of one component are as rare as 4.878 of the length of two."""

CERTAIN: Final = 11.0
"""A statement is blamed alone if that explains the scans better than blaming any other station by so much in chi-square;
chance does so in one of a thousand cases."""

ADVICE: Final = {"level": "check its compensator and set it up again", "heading": "check heading_deg"}
FIRST_GATE_M: Final = 1.2
MOST_GATE_M: Final = 10.0
GNSS_SIGMAS: Final = 3.0
CLOSE_GATE_M: Final = 0.12
GATE_AGAIN_M: Final = 0.6
LEAST_LEFT: Final = 2
"""One station beside suspects has nobody who says that it is right."""

MOST_GIVEN_UP: Final = 0.5
"""Share of the stations that may have a wrong statement; beyond it nobody knows which half is right."""


@dataclass(frozen=True, slots=True)
class WrongStatement:
    """A part of a station's stated pose that the scans contradict; ``off`` says by how much in words."""

    index: int
    part: str
    sigmas: float
    off: str
    is_certain: bool

    @property
    def reason(self) -> str:
        """What to tell the crew."""
        what = f"stated {self.part} is {self.off} off ({self.sigmas:.0f} sigmas)"
        advice = ADVICE.get(self.part, "check position_m")
        if not self.is_certain:
            return f"{what}, or that of another station is: the scans cannot tell which; {advice}"
        return f"{what} and is not used; {advice}"


@dataclass(frozen=True, slots=True)
class Settled:
    """An adjustment after wrong statements were given up.

    ``is_contradictory`` where statements still contradict the scans, but too many were given up to know which are right.
    """

    network: Network
    adjusted: Adjusted
    wrong: tuple[WrongStatement, ...]
    is_contradictory: bool


def settle(network: Network, start: list[StationPose]) -> Settled:
    """Adjust, give up the wrong statements, worst first, and adjust again with the rest.

    The statements are tested while they are eased: held as they are stated, a wrong one would draw its station away from
    what contradicts it before anybody looks.
    """
    stated_sigmas = np.array([stated.information**-0.5 for stated in network.stated])
    first = _first_gate_m(network, stated_sigmas)
    eased = adjust(network, start, Gates(first, first))
    found = _give_up_wrong(_Findings(network, ()), eased)
    adjusted = adjust(found.network, list(eased.poses), Gates(CLOSE_GATE_M, 0.0))
    again = _give_up_wrong(found, adjusted)
    if again.network is not found.network:
        adjusted = adjust(again.network, list(adjusted.poses), Gates(GATE_AGAIN_M, 0.0))
    told = tuple(_told_anew(w, again.network, adjusted, stated_sigmas) for w in again.wrong)
    return Settled(again.network, adjusted, told, found.is_contradictory or again.is_contradictory)


def _first_gate_m(network: Network, stated_sigmas: NDArray[np.float64]) -> float:
    """Wide enough for positions as uncertain as they are stated."""
    is_stated = np.array([stated.is_stated for stated in network.stated])
    widest = float(np.max(stated_sigmas[:, 3:][is_stated[:, 3:]], initial=0.0))
    return float(np.clip(GNSS_SIGMAS * widest, FIRST_GATE_M, MOST_GATE_M))


def corrections(adjusted: Adjusted, stated: tuple[StatedPose, ...]) -> NDArray[np.float64]:
    """Adjusted minus stated parameters (n, 6)."""
    return np.array(
        [
            np.r_[rotation_vector_from(pose, s.pose), pose.position_m - s.pose.position_m]
            for pose, s in zip(adjusted.poses, stated, strict=True)
        ]
    )


def normalised_corrections(network: Network, adjusted: Adjusted) -> NDArray[np.float64]:
    """Corrections (n, 6) in units of their own sigma; NaN where nothing is stated or nothing can be tested."""
    covariance = np.linalg.inv(adjusted.data_information + adjusted.prior_information)
    stated_variance = 1.0 / np.diag(adjusted.prior_information)
    taken = stated_variance - np.diag(covariance)
    is_stated = np.concatenate([stated.is_stated for stated in network.stated])
    testable = (taken > TESTABLE * stated_variance) & is_stated
    own_sigma = np.sqrt(np.where(testable, taken, np.nan))
    return np.asarray(corrections(adjusted, network.stated) / own_sigma.reshape(-1, SIX))


@dataclass(frozen=True, slots=True)
class _Findings:
    """The network with what is still believed, what was found wrong, and whether more is wrong than can be told."""

    network: Network
    wrong: tuple[WrongStatement, ...]
    is_contradictory: bool = False


@dataclass(frozen=True, slots=True)
class _Contradiction:
    """A part of a station's statement and how far it is off, in units of its own sigma.

    ``blunder`` (2,) or (1,) is the error of the statement that would explain it: a held parameter shows a part of it only.
    """

    size: float
    index: int
    part: str
    blunder: NDArray[np.float64]


def _give_up_wrong(found: _Findings, adjusted: Adjusted) -> _Findings:
    """Give up statements that the scans contradict, the worst first, with the matches that are there."""
    network, wrong = found.network, list(found.wrong)
    while True:
        off = _off_by_full_statements(network, adjusted)
        known = {(w.index, w.part) for w in wrong}
        ranked = [
            one for one in _contradictions(network, adjusted, off) if (one.index, one.part) not in known
        ]
        if not ranked or ranked[0].size <= SUSPECT_SIGMAS:
            return _Findings(network, tuple(wrong))
        alike = _alike(ranked)
        indices = {w.index for w in wrong} | {ranked[0].index}
        if len(indices) > MOST_GIVEN_UP * len(network.clouds):
            return _Findings(network, tuple(wrong), is_contradictory=True)
        is_certain = len(alike) == 1
        wrong += [
            WrongStatement(one.index, one.part, one.size, _in_words(one.blunder, one.part), is_certain)
            for one in alike
        ]
        if not is_certain:
            n_left = len(network.clouds) - len({w.index for w in wrong})
            is_alone = 0 < n_left < LEAST_LEFT
            return _Findings(network, tuple(wrong), is_alone or _more_is_wrong(network, adjusted, wrong))
        network = _without(network, wrong[-1])


def _more_is_wrong(network: Network, adjusted: Adjusted, wrong: list[WrongStatement]) -> bool:
    """Whether the scans contradict even more than one of several suspects, whichever of them it is."""
    rest = [_without(network, one) for one in wrong if not one.is_certain]
    known = {(one.index, one.part) for one in wrong}
    return all(
        any(
            one.size > SUSPECT_SIGMAS and (one.index, one.part) not in known
            for one in _contradictions(less, adjusted, _off_by_full_statements(less, adjusted))
        )
        for less in rest
    )


def _alike(ranked: list[_Contradiction]) -> list[_Contradiction]:
    """The worst contradiction, and those of other stations that explain the scans nearly as well."""
    worst = ranked[0]
    rivals: dict[int, _Contradiction] = {}
    for one in ranked[1:]:
        if (
            one.index != worst.index
            and one.size > SUSPECT_SIGMAS / 2.0
            and worst.size**2 - one.size**2 < CERTAIN
        ):
            rivals.setdefault(one.index, one)
    return [worst, *rivals.values()]


def _off_by_full_statements(network: Network, adjusted: Adjusted) -> NDArray[np.float64]:
    """Adjusted minus stated parameters (n, 6) if the statements were held as stated; one linear step, the same matches."""
    held = np.diag(np.concatenate([stated.information for stated in network.stated]))
    right = adjusted.data_vector + held @ stated_minus_present(adjusted.poses, network.stated)
    step = np.linalg.solve(adjusted.data_matrix + held, right)
    return np.asarray(corrections(adjusted, network.stated) + step.reshape(-1, SIX))


def _contradictions(network: Network, adjusted: Adjusted, off: NDArray[np.float64]) -> list[_Contradiction]:
    """How far each part of every statement is off, the worst first; parts that cannot be tested are left out.

    A part of two components is tested as a vector, so that its size does not depend on the axes; it is scaled to be as
    rare by chance as the same number of sigmas of one component.
    """
    held = np.diag(np.concatenate([stated.information for stated in network.stated]))
    covariance = np.linalg.inv(adjusted.data_information + held)
    found = []
    for i, stated in enumerate(network.stated):
        own = covariance[SIX * i : SIX * i + SIX, SIX * i : SIX * i + SIX]
        for part, parameters in PARTS.items():
            rows = list(parameters)
            if stated.is_stated[rows].all():
                sigma = stated.information[rows] ** -0.5
                taken = np.eye(len(rows)) - own[np.ix_(rows, rows)] / np.outer(sigma, sigma)
                size, blunder = _length(off[i, rows] / sigma, taken), _blunder(off[i, rows] / sigma, taken)
                found.append(_Contradiction(size, i, part, sigma * blunder))
    return sorted(found, key=lambda one: -one.size)


def _length(off: NDArray[np.float64], taken: NDArray[np.float64]) -> float:
    """Length of a vector of corrections in units of stated sigmas, whose covariance is ``taken``."""
    shares, directions = np.linalg.eigh(taken)
    testable = shares > TESTABLE
    squares = (directions.T @ off)[testable] ** 2 / shares[testable]
    as_one = 1.0 if np.count_nonzero(testable) < 2 else ONE_FOR_TWO
    return float(as_one * np.sqrt(squares.sum()))


def _blunder(off: NDArray[np.float64], taken: NDArray[np.float64]) -> NDArray[np.float64]:
    """Error of a statement, in stated sigmas, that explains the corrections of it; nothing in directions not tested."""
    shares, directions = np.linalg.eigh(taken)
    testable = shares > TESTABLE
    return np.asarray(directions[:, testable] @ ((directions.T @ off)[testable] / shares[testable]))


def _told_anew(
    wrong: WrongStatement, network: Network, adjusted: Adjusted, stated_sigmas: NDArray[np.float64]
) -> WrongStatement:
    """Say how far off a statement is once it no longer holds its station."""
    if not wrong.is_certain:
        return wrong
    parameters = list(PARTS[wrong.part])
    correction = corrections(adjusted, network.stated)[wrong.index]
    variance = np.diag(np.linalg.inv(adjusted.data_information + adjusted.prior_information)).reshape(-1, SIX)
    sigma = np.sqrt(stated_sigmas[wrong.index] ** 2 + variance[wrong.index])
    sigmas = float(np.max(np.abs(correction / sigma)[parameters]))
    return replace(wrong, sigmas=sigmas, off=_in_words(correction[parameters], wrong.part))


def _in_words(correction: NDArray[np.float64], part: str) -> str:
    size = float(np.linalg.norm(correction))
    if part in {"position", "height"}:
        return f"{size:.2f} m"
    return (
        f"{np.degrees(size):.2f} deg" if size > 600 * ARCSEC_RAD else f"{size / ARCSEC_RAD:.0f} arc seconds"
    )


def _without(network: Network, wrong: WrongStatement) -> Network:
    stated = list(network.stated)
    stated[wrong.index] = stated[wrong.index].without(wrong.part)
    return replace(network, stated=tuple(stated))
