"""One adjustment of all stations of an epoch: scans against each other, GNSS, heading and level held."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain, groupby, permutations, product
from operator import itemgetter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.rotations import nearest_rotation, rotation_from_vector
from tasks.geometry.side_by_side import side_by_side
from tasks.registration.pairs import Matches, feigned_information, match_partners, pair_equations
from tasks.registration.partners import Partners
from tasks.registration.planar import ScanPlanes
from tasks.registration.shaft_factor import ShaftEquations, ShaftPoints, shaft_equations
from tasks.registration.stated import StatedPose
from tasks.registration.station import StationPose

LAST_GATE_M: Final = 0.06
GATE_SHRINKS: Final = 0.7
GATE_SIGMAS: Final = 3.0
"""A gate is taken as so many standard deviations of what is still out of place."""

LEVER_M: Final = 150.0
"""What is compared lies about that far from a scanner."""

STEP_SIGMAS: Final = 0.02
"""Converged when no parameter moves by more than this share of its own standard deviation."""

MAX_ITERATIONS: Final = 40
FEIGNED_MARGIN: Final = 2.0
"""On round shafts noise feigns up to 1.5 times the information that is expected of it, because neighbouring normals share
their points; of what is truly known it feigns a thousandth."""

STABLE: Final = -1
"""Stands as index for the stable surroundings, which do not move."""

Pair = tuple[int, int]
Link = tuple[int, int, int]
"""Source, target and layer."""


@dataclass(frozen=True, slots=True)
class Network:
    """What is adjusted: planes and a stated pose each station.

    ``stable`` are surroundings that hold the frame, ``shaft`` what the stations see of the structure; both may be missing.
    ``partners`` is the memory of nearest planes, for these clouds alone: it goes with them from one adjustment to the next.
    """

    clouds: tuple[ScanPlanes, ...]
    stated: tuple[StatedPose, ...]
    stable: ScanPlanes | None = None
    shaft: ShaftPoints | None = None
    partners: dict[Link, Partners] = field(default_factory=dict)

    @property
    def links(self) -> list[Link]:
        """Ordered pairs of stations, and every station against the stable surroundings, each in both layers."""
        n = len(self.clouds)
        fixed = [(i, STABLE) for i in range(n)] if self.stable is not None else []
        return [(i, j, layer) for (i, j), layer in product([*permutations(range(n), 2), *fixed], range(2))]

    def planes(self, index: int) -> ScanPlanes:
        """Planes of a station, or the stable surroundings."""
        if index != STABLE:
            return self.clouds[index]
        if self.stable is None:
            raise IndexError("the network has no stable surroundings")
        return self.stable


@dataclass(frozen=True, slots=True)
class Adjusted:
    """Poses, normal matrices (6n, 6n) of scans and of statements, and the last matches of every pair.

    ``data_matrix`` (6n, 6n) and ``data_vector`` (6n,) are the equations of the scans at the poses; ``data_information`` is
    that matrix without what noise feigns, ``prior_information`` that of the statements.
    ``by_frame`` (6n, 6) is the normal matrix between the poses and a motion of the stable surroundings;
    ``n_on_shaft`` (n,) counts the points of each station on the common shaft, zero where that is not used.
    """

    poses: tuple[StationPose, ...]
    data_matrix: NDArray[np.float64]
    data_vector: NDArray[np.float64]
    data_information: NDArray[np.float64]
    prior_information: NDArray[np.float64]
    by_frame: NDArray[np.float64]
    n_on_shaft: NDArray[np.int64]
    matches: dict[Link, Matches]
    iterations: int
    converged: bool


@dataclass(frozen=True, slots=True)
class Gates:
    """How far a partner may lie along the normal at first, and how far statements are eased to the end; 0 is not at all."""

    first_m: float
    ease_to_m: float


def adjust(network: Network, start: Sequence[StationPose], gates: Gates) -> Adjusted:
    """Gauss-Newton over all poses, with a gate that shrinks to 6 cm."""
    stated = np.concatenate([stated.information for stated in network.stated])
    poses, gate, iteration, converged = list(start), gates.first_m, 0, False
    while not converged and iteration < MAX_ITERATIONS:
        iteration += 1
        matches = _match_all(network, poses, gate)
        prior = np.diag(_eased(stated, gate, gates.ease_to_m))
        data, right = _assemble(matches, poses)
        shaft = _shaft(network, poses)
        data, right = data + shaft.matrix, right + shaft.vector
        right = right + prior @ stated_minus_present(poses, network.stated)
        step = np.asarray(np.linalg.solve(data + prior, right), dtype=np.float64)
        poses = [_moved(pose, step[SIX * i : SIX * i + SIX]) for i, pose in enumerate(poses)]
        sigma = np.sqrt(np.diag(np.linalg.inv(data + prior)))
        converged = gate <= LAST_GATE_M and float(np.max(np.abs(step) / sigma)) < STEP_SIGMAS
        gate = max(gate * GATE_SHRINKS, LAST_GATE_M)
    data, right = _assemble(matches, poses)
    shaft = _shaft(network, poses)
    data, right = data + shaft.matrix, right + shaft.vector
    known = data - FEIGNED_MARGIN * _feigned(matches, poses)
    by_frame = _by_frame(matches, poses)
    return Adjusted(
        tuple(poses),
        data,
        right,
        _not_negative(known),
        np.diag(stated),
        by_frame,
        shaft.n_points,
        matches,
        iteration,
        converged,
    )


def _shaft(network: Network, poses: Sequence[StationPose]) -> ShaftEquations:
    if network.shaft is None:
        size = SIX * len(poses)
        return ShaftEquations(np.zeros((size, size)), np.zeros(size), np.zeros(len(poses), np.int64))
    return shaft_equations(network.shaft, poses)


def _eased(information: NDArray[np.float64], gate_m: float, ease_to_m: float) -> NDArray[np.float64]:
    """Statements (6n,) while the gate is wide: of where a scan stands and looks no more than the gate itself knows.

    A station that is stated half a metre off is so drawn to where it stood before the gate closes behind it. The level is
    held from the beginning: no scan may tell a scanner what is plumb.
    """
    if gate_m <= LAST_GATE_M and ease_to_m <= 0.0:
        return information
    across = max(gate_m, ease_to_m) / GATE_SIGMAS
    most = np.array([np.inf, np.inf, (LEVER_M / across) ** 2, *[across**-2] * 3])
    return np.asarray(np.minimum(information, np.tile(most, len(information) // SIX)))


def rotation_vector_from(pose: StationPose, reference: StationPose) -> NDArray[np.float64]:
    """Small rotation (3,), radians about east, north and up, that takes ``reference`` to ``pose``."""
    delta = pose.rotation @ reference.rotation.T
    sine = 0.5 * np.array([delta[2, 1] - delta[1, 2], delta[0, 2] - delta[2, 0], delta[1, 0] - delta[0, 1]])
    size = float(np.linalg.norm(sine))
    return np.asarray(
        sine if size < 1e-12 else sine * (np.arctan2(size, (np.trace(delta) - 1.0) / 2.0) / size)
    )


def fixed_pose() -> StationPose:
    """Pose of what lies in the site frame already."""
    return StationPose("", np.eye(3), np.zeros(3))


def _pose_at(poses: Sequence[StationPose], index: int) -> StationPose:
    return fixed_pose() if index == STABLE else poses[index]


def _match_all(network: Network, poses: Sequence[StationPose], gate_m: float) -> dict[Link, Matches]:
    """Match every link, those of different sources side by side."""

    def from_source(links: list[Link]) -> list[Matches]:
        return [_match(network, link, poses, gate_m) for link in links]

    by_source = [list(links) for _, links in groupby(network.links, key=itemgetter(0))]
    found = side_by_side(from_source, by_source)
    return dict(zip(chain(*by_source), chain(*found), strict=True))


def _match(network: Network, link: Link, poses: Sequence[StationPose], gate_m: float) -> Matches:
    i, j, layer = link
    source = network.clouds[i].layers[layer]
    if link not in network.partners:
        network.partners[link] = Partners(source, network.planes(j).layers[layer])
    return match_partners(network.partners[link], source, poses[i], _pose_at(poses, j), gate_m)


def _assemble(
    matches: dict[Link, Matches], poses: Sequence[StationPose]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    size = SIX * len(poses)
    matrix, vector = np.zeros((size, size)), np.zeros(size)
    for (i, j, _), found in matches.items():
        equations = pair_equations(found, _pose_at(poses, i), _pose_at(poses, j))
        _add_matrix(matrix, equations.matrix, i, j)
        for rows, kept in _rows(i, j):
            vector[rows] += equations.vector[kept]
    return matrix, vector


def _feigned(matches: dict[Link, Matches], poses: Sequence[StationPose]) -> NDArray[np.float64]:
    matrix = np.zeros((SIX * len(poses),) * 2)
    for (i, j, _), found in matches.items():
        feigned = feigned_information(found, _pose_at(poses, i), _pose_at(poses, j))
        _add_matrix(matrix, feigned, i, j)
    return matrix


def _by_frame(matches: dict[Link, Matches], poses: Sequence[StationPose]) -> NDArray[np.float64]:
    matrix = np.zeros((SIX * len(poses), SIX))
    for (i, j, _), found in matches.items():
        if j == STABLE:
            equations = pair_equations(found, poses[i], fixed_pose())
            matrix[SIX * i : SIX * i + SIX] += equations.matrix[:SIX, SIX:]
    return matrix


def _add_matrix(matrix: NDArray[np.float64], of_pair: NDArray[np.float64], i: int, j: int) -> None:
    """Add the matrix (12, 12) of a pair where it belongs."""
    for (rows, kept), (columns, kept_columns) in product(_rows(i, j), repeat=2):
        matrix[rows, columns] += of_pair[kept, kept_columns]


def _rows(i: int, j: int) -> list[tuple[slice, slice]]:
    """Where each of a pair's stations goes, and which of the pair's 12 parameters it is; what does not move is left out."""
    own = [(slice(SIX * i, SIX * i + SIX), slice(0, SIX))]
    return own if j == STABLE else [*own, (slice(SIX * j, SIX * j + SIX), slice(SIX, 2 * SIX))]


def _not_negative(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest information that knows nothing less than nothing, in units in which a radian is 100 m."""
    scale = np.tile(np.r_[np.full(3, 100.0), np.ones(3)], len(information) // SIX)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(kept * np.outer(scale, scale))


def stated_minus_present(poses: Sequence[StationPose], stated: Sequence[StatedPose]) -> NDArray[np.float64]:
    """Stated minus present parameters (6n,)."""
    parts = [
        np.r_[-rotation_vector_from(pose, prior.pose), prior.pose.position_m - pose.position_m]
        for pose, prior in zip(poses, stated, strict=True)
    ]
    return np.concatenate(parts)


def _moved(pose: StationPose, step: NDArray[np.float64]) -> StationPose:
    rotation = nearest_rotation(rotation_from_vector(step[:3]) @ pose.rotation)
    return StationPose(pose.station, rotation, pose.position_m + step[3:])
