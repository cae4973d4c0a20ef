"""The shaft out of scans of any size: they are read twice, piece by piece, and only points of the shaft are kept.

An even sample finds the surface; then every point is looked at once and either goes, or is kept with its scan. The
result is that of ``isolate_shaft`` on the whole cloud where the sample holds all points and no more than
``most_points`` are on the surface.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.even_choice import one_of_every
from tasks.geometry.failure import FitFailure
from tasks.geometry.side_by_side import side_by_side
from tasks.geometry.variants import choose
from tasks.preprocessing.explaining import explain_failure
from tasks.preprocessing.finding import FoundSurface, find_surface
from tasks.preprocessing.kinds import KINDS, StructureKind
from tasks.preprocessing.model import ShaftModel
from tasks.preprocessing.prior import ShaftOptions, StructurePrior
from tasks.preprocessing.reasons import KEPT, NOT_NEEDED, REASONS, Removal, count_reasons, removals
from tasks.preprocessing.rising import from_bottom_up
from tasks.preprocessing.sorting import sort_among, sort_by_gate, sort_by_surface

SEARCH_POINTS: Final = 1 << 22
"""Points, of all scans together, among which the surface is looked for: the fit takes 1,500 a band."""

FEW_NEAR: Final = SEARCH_POINTS // 8
"""Where the sample has fewer points near the structure, points are sampled anew among those that are near alone."""

BLOCK_POINTS: Final = 1 << 17
"""Points for which room is made at once, a scan."""

CHUNK_POINTS: Final = 1 << 16
"""Points that are looked at in one go: what is made of them on the way stays in the processor's cache."""

THINNED: Final = REASONS.index(NOT_NEEDED)


class Scan(Protocol):
    """A scan in the site frame, metres, that is read piece by piece, as often as one wants."""

    def __len__(self) -> int:
        """Count its points."""
        ...

    def chunks(self, size: int) -> Iterator[NDArray[np.float64]]:
        """Give all points in order, as arrays (m, 3) of at most ``size``."""
        ...

    def sample(self, most: int) -> NDArray[np.float64]:
        """Give an even sample (m, 3) of at most ``most`` points; all, in order, where there are no more."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class ScannedShaft:
    """A shaft that was taken out of scans.

    Attributes
    ----------
    points_m : (n, 3) array
        Its points from the bottom up, site frame, metres; of equal heights in the order of the scans.
    scan_index : (n,) array
        Which scan each is of.
    model : ShaftModel
        Rough axis, radius and noise.
    removed : tuple of Removal
        Points by reason; they add up to ``n_points_in``, which is all points of the scans.
    """

    points_m: NDArray[np.float64]
    scan_index: NDArray[np.uint16]
    model: ShaftModel
    removed: tuple[Removal, ...]
    n_points_in: int


class _Kept:
    """What is kept of a scan: points (n, 3) and their arc lengths (n,) around the axis, in blocks that grow with them."""

    def __init__(self) -> None:
        self.points_m: list[NDArray[np.float64]] = []
        self.around_m: list[NDArray[np.float64]] = []
        self.count = 0

    def add(self, points_m: NDArray[np.float64], around_m: NDArray[np.float64]) -> None:
        done = 0
        while done < len(points_m):
            place = self.count % BLOCK_POINTS
            if place == 0:
                self.points_m.append(np.empty((BLOCK_POINTS, 3)))
                self.around_m.append(np.empty(BLOCK_POINTS))
            n = min(len(points_m) - done, BLOCK_POINTS - place)
            self.points_m[-1][place : place + n] = points_m[done : done + n]
            self.around_m[-1][place : place + n] = around_m[done : done + n]
            self.count, done = self.count + n, done + n


def _joined(scans: Sequence[_Kept]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """All points (n, 3) and arc lengths (n,), scan after scan; blocks go as they are taken over."""
    begins = np.cumsum([0, *(scan.count for scan in scans)])
    points_m, around_m = np.empty((begins[-1], 3)), np.empty(begins[-1])

    def take_over(number: int) -> None:
        scan, end = scans[number], int(begins[number])
        left = scan.count
        while scan.points_m:
            block_m, along_m, n = scan.points_m.pop(0), scan.around_m.pop(0), min(left, BLOCK_POINTS)
            points_m[end : end + n], around_m[end : end + n] = block_m[:n], along_m[:n]
            end, left = end + n, left - n

    side_by_side(take_over, range(len(scans)))
    return points_m, around_m


@dataclass(frozen=True, slots=True, eq=False)
class _Question:
    """What every point is asked: is it near, on the surface, and one of every ``step`` there."""

    prior: StructurePrior
    kind: StructureKind
    options: ShaftOptions
    surface: FoundSurface
    step: int

    @property
    def edges_m(self) -> NDArray[np.float64]:
        return np.array(self.surface.model.radius_z_m)


def isolate_scans(
    scans: Sequence[Scan], prior: StructurePrior, options: ShaftOptions
) -> ScannedShaft | FitFailure:
    """Separate the shaft of a structure from everything else in scans of any size.

    Memory is that of the sample (``SEARCH_POINTS``), and afterwards some 100 bytes for each point that is kept, of which
    there are about ``options.most_points`` at most.

    Raises
    ------
    InputError
        If the kind is unknown.
    """
    kind = choose(KINDS, prior.kind, "kind of structure")
    found = _find(scans, prior, kind, options)
    if isinstance(found, FitFailure):
        return found
    kept = [_Kept() for _ in scans]

    def of_scan(number: int) -> NDArray[np.int64]:
        return _look_at(scans[number], found, kept[number])

    counts = np.sum(side_by_side(of_scan, range(len(scans))), axis=0)
    return _cleaned(kept, counts, found)


def _find(
    scans: Sequence[Scan], prior: StructurePrior, kind: StructureKind, options: ShaftOptions
) -> _Question | FitFailure:
    """Find the surface in an even sample, and one of how many of the points on it is to be kept."""
    total = sum(len(scan) for scan in scans)
    share = min(1.0, SEARCH_POINTS / max(total, 1))

    def sample_of(scan: Scan) -> NDArray[np.float64]:
        return scan.sample(max(1, math.ceil(share * len(scan))))

    sample_m = np.concatenate(side_by_side(sample_of, scans))
    near_m = _taken(sample_m, np.flatnonzero(sort_by_gate(sample_m, prior, kind) == KEPT))
    one_of = total / max(len(sample_m), 1)
    if len(near_m) < FEW_NEAR and one_of > 1.0:
        # a small structure in a large cloud: the sample holds little of it
        step = max(1, math.ceil(one_of * len(near_m) / SEARCH_POINTS))
        near_m, one_of = _near(scans, prior, kind, step), float(step)
    found = find_surface(near_m, prior, kind, options.seed)
    if isinstance(found, FitFailure):
        return explain_failure(found, sample_m, prior, kind)
    expected = one_of * np.count_nonzero(sort_by_surface(near_m, found, options) == KEPT)
    return _Question(prior, kind, options, found, max(1, math.ceil(expected / options.most_points)))


def _near(
    scans: Sequence[Scan], prior: StructurePrior, kind: StructureKind, step: int
) -> NDArray[np.float64]:
    """One of every ``step`` points (m, 3) within the gates, of all scans."""

    def of_scan(scan: Scan) -> NDArray[np.float64]:
        pieces, seen = [np.empty((0, 3))], 0
        for chunk_m in scan.chunks(CHUNK_POINTS):
            near = np.flatnonzero(sort_by_gate(chunk_m, prior, kind) == KEPT)
            pieces.append(_taken(chunk_m, near[one_of_every(step, seen, len(near))]))
            seen += len(near)
        return np.concatenate(pieces)

    return np.concatenate(side_by_side(of_scan, scans))


def _look_at(scan: Scan, asked: _Question, kept: _Kept) -> NDArray[np.int64]:
    """Look at every point of a scan: what stays is kept, and how many went for what is given back."""
    counts = np.zeros(len(REASONS), dtype=np.int64)
    on_surface = 0
    for chunk_m in scan.chunks(CHUNK_POINTS):
        reason = sort_by_gate(chunk_m, asked.prior, asked.kind)
        near = np.flatnonzero(reason == KEPT)
        if len(near):
            near_m = _taken(chunk_m, near)
            of_near = sort_by_surface(near_m, asked.surface, asked.options)
            on = np.flatnonzero(of_near == KEPT)
            stay = on[one_of_every(asked.step, on_surface, len(on))]
            on_surface += len(on)
            of_near[on] = THINNED
            of_near[stay] = KEPT
            reason[near] = of_near
            stay_m = _taken(near_m, stay)
            kept.add(stay_m, asked.surface.unroll(stay_m))
        counts += count_reasons(reason)
    return counts


def _taken(points_m: NDArray[np.float64], rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Some of the points (n, 3), by ascending indices (m,); all of them as they are, not as a copy."""
    # take is three times as fast as an index for rows of three
    return points_m if len(rows) == len(points_m) else points_m.take(rows, axis=0)


def _cleaned(kept: Sequence[_Kept], counts: NDArray[np.int64], asked: _Question) -> ScannedShaft:
    """What is kept of the scans less isolated points and duplicates, from the bottom up."""
    counts_of_scans = [scan.count for scan in kept]
    points_m, around_m = _joined(kept)
    reason = sort_among(points_m, around_m, asked.edges_m, asked.options)
    del around_m
    n_points_in = int(counts.sum())
    counts[KEPT] = 0
    counts += count_reasons(reason)
    scan_index = np.repeat(np.arange(len(kept), dtype=np.uint16), counts_of_scans)
    sorted_m, sorted_index = from_bottom_up(points_m, scan_index, reason == KEPT)
    return ScannedShaft(sorted_m, sorted_index, asked.surface.model, removals(counts), n_points_in)
