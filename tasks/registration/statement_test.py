"""Test what is stated of the poses against the scans, and give up the statements that are wrong, worst first."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.registration.adjustment import Adjusted, Network, adjust, rotation_vector_from
from tasks.registration.stated import PARTS, StatedPose
from tasks.registration.station import StationPose

SUSPECT_SIGMAS: Final = 4.5
"""A correction beyond this many of its own sigmas is no chance: that happens in one of 3,000 epochs of 8 stations.
Its sigma is that of Baarda's test, sqrt(stated - adjusted variance), because a held parameter hardly gives."""

TESTABLE: Final = 0.01
"""Share of the stated variance that the scans must take away before a correction can be tested."""

ONE_FOR_TWO: Final = 4.5 / 4.878
"""4.5 sigmas of one component are as rare as 4.878 of the length of two."""

AS_BAD: Final = 0.98
"""Two statements whose tests are nearer than this cannot be told apart: which one is wrong is then not known."""

GATE_AGAIN_M: Final = 0.6
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
        if not self.is_certain:
            return f"{what}, or that of another station is: the scans cannot tell which; check position_m and heading_deg"
        advice = {
            "level": "check its compensator and set it up again",
            "heading": "check heading_deg",
        }.get(self.part, "check position_m")
        return f"{what} and is not used; {advice}"


@dataclass(frozen=True, slots=True)
class Settled:
    """An adjustment after wrong statements were given up."""

    network: Network
    adjusted: Adjusted
    wrong: tuple[WrongStatement, ...]


def settle(network: Network, start: list[StationPose]) -> Settled:
    """Adjust, give up the worst of the wrong statements, and adjust again until none is left."""
    stated_sigmas = np.array([stated.information**-0.5 for stated in network.stated])
    adjusted = adjust(network, start)
    wrong: list[WrongStatement] = []
    while len({w.index for w in wrong}) < MOST_GIVEN_UP * len(network.clouds):
        found = _worst(network, adjusted, {(w.index, w.part) for w in wrong})
        wrong += found
        if len(found) != 1:
            break
        network = _without(network, found[0])
        adjusted = adjust(network, list(adjusted.poses), GATE_AGAIN_M)
    told = tuple(_told_anew(w, network, adjusted, stated_sigmas) for w in wrong)
    return Settled(network, adjusted, told)


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


def part_sizes(network: Network, adjusted: Adjusted) -> dict[str, NDArray[np.float64]]:
    """How far each part of every statement is off (n,), in units of its own sigma; zero where it cannot be tested.

    A part of two components is tested as a vector, so that its size does not depend on the axes; it is scaled to be as
    rare by chance as the same number of sigmas of one component.
    """
    covariance = np.linalg.inv(adjusted.data_information + adjusted.prior_information)
    off = corrections(adjusted, network.stated)
    sizes = {part: np.zeros(len(off)) for part in PARTS}
    for i, stated in enumerate(network.stated):
        own = covariance[SIX * i : SIX * i + SIX, SIX * i : SIX * i + SIX]
        for part, parameters in PARTS.items():
            rows = list(parameters)
            if stated.is_stated[rows].all():
                sigma = stated.information[rows] ** -0.5
                taken = np.eye(len(rows)) - own[np.ix_(rows, rows)] / np.outer(sigma, sigma)
                sizes[part][i] = _length(off[i, rows] / sigma, taken)
    return sizes


def _length(off: NDArray[np.float64], taken: NDArray[np.float64]) -> float:
    """Length of a vector of corrections in units of stated sigmas, whose covariance is ``taken``."""
    shares, directions = np.linalg.eigh(taken)
    testable = shares > TESTABLE
    squares = (directions.T @ off)[testable] ** 2 / shares[testable]
    as_one = 1.0 if np.count_nonzero(testable) < 2 else ONE_FOR_TWO
    return float(as_one * np.sqrt(squares.sum()))


def _worst(network: Network, adjusted: Adjusted, known: set[tuple[int, str]]) -> list[WrongStatement]:
    """The worst statement, with all that cannot be told apart from it; none if all are good."""
    sizes = part_sizes(network, adjusted)
    off = corrections(adjusted, network.stated)
    ranked = sorted(
        (
            (float(size), i, part)
            for part, of_part in sizes.items()
            for i, size in enumerate(of_part)
            if (i, part) not in known
        ),
        reverse=True,
    )
    size, _, part = ranked[0]
    if size <= SUSPECT_SIGMAS:
        return []
    alike = [(s, i) for s, i, p in ranked if p == part and s >= AS_BAD * size]
    return [WrongStatement(i, part, s, _in_words(off[i], part), is_certain=len(alike) == 1) for s, i in alike]


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
    return replace(wrong, sigmas=sigmas, off=_in_words(correction, wrong.part))


def _in_words(correction: NDArray[np.float64], part: str) -> str:
    size = float(np.linalg.norm(correction[list(PARTS[part])]))
    if part in {"position", "height"}:
        return f"{size:.2f} m"
    return (
        f"{np.degrees(size):.2f} deg" if size > 600 * ARCSEC_RAD else f"{size / ARCSEC_RAD:.0f} arc seconds"
    )


def _without(network: Network, wrong: WrongStatement) -> Network:
    stated = list(network.stated)
    stated[wrong.index] = stated[wrong.index].without(wrong.part)
    return replace(network, stated=tuple(stated))
