"""A scan in pieces: the checks of ``read_scan``, made while the records go by, in memory that does not grow with them.

Scaling by a positive factor and shifting are monotone in float64, too: the box around the integers is the box around the
points, and what lies at zero is a range of integers. So most pieces need not be turned into coordinates at all.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from storage.integer_grid import IntegerGrid
from tasks.ingest.empty_returns import zero_cell
from tasks.ingest.levelling import level_scan
from tasks.ingest.scan import METRES_PER_UNIT, Bounds, RawStream, ScanFacts, ScanRequest, box_of
from tasks.ingest.soundness import (
    SAMPLE_POINTS,
    check_apart,
    check_bulk,
    check_possible,
    check_step,
    count_not_finite,
    is_possible,
    note_empty_returns,
    sample_step,
)


@dataclass(slots=True)
class EverySo:
    """Every ``step``-th of the rows (n, 3) that go by, from the first on."""

    step: int
    _seen: int = 0
    _taken: list[NDArray[np.int32]] = field(default_factory=list)

    def see(self, rows: NDArray[np.int32]) -> None:
        """Look at the next rows (m, 3)."""
        self._taken.append(rows[-self._seen % self.step :: self.step].copy())
        self._seen += len(rows)

    def rows(self) -> NDArray[np.int32]:
        """Give the rows that were taken, (k, 3)."""
        return np.concatenate(self._taken)


@dataclass(slots=True)
class _Tally:
    """What went by: ``box`` of all records and ``kept`` of those with a return, in integers; how many of each."""

    n_points: int = 0
    n_kept: int = 0
    n_bad: int = 0
    box: Bounds | None = None
    kept: Bounds | None = None


def grid_of_site(grid: IntegerGrid, request: ScanRequest) -> IntegerGrid:
    """Make a grid of metres, origin and axes as the campaign says, of that of a file."""
    return replace(
        grid, unit_m=METRES_PER_UNIT[request.unit], origin_m=request.origin_m, swap_axes=request.swap_axes
    )


def checked_pieces(
    path: Path, raw: RawStream, request: ScanRequest, tell: Callable[[ScanFacts], None]
) -> Iterator[NDArray[np.int32]]:
    """Give the records (m, 3) that have a return, in pieces; refuse and tell at the end as ``read_scan`` does."""
    zeros, sample = zero_cell(raw.grid), EverySo(sample_step(raw.n_points, SAMPLE_POINTS))
    tally = _Tally()
    for piece in raw.decode():
        box = box_of(piece)
        kept = zeros.without(piece, box)
        _count(tally, raw.grid, piece, box, kept)
        raw.watch.see(piece, box)
        if len(kept):
            sample.see(kept)
            yield kept
    # what a damaged header scales beyond float64 is refused here, and needs no warning
    with np.errstate(over="ignore", invalid="ignore"):
        tell(_facts(path, raw, request, tally, sample))


def _count(
    tally: _Tally, grid: IntegerGrid, piece: NDArray[np.int32], box: Bounds, kept: NDArray[np.int32]
) -> None:
    tally.n_points += len(piece)
    tally.n_kept += len(kept)
    tally.box = _around(tally.box, box)
    if len(kept):
        tally.kept = _around(tally.kept, box if len(kept) == len(piece) else box_of(kept))
    with np.errstate(over="ignore", invalid="ignore"):
        if not is_possible(_scaled(grid, box)):
            tally.n_bad += count_not_finite(grid.metres(piece))


def _facts(path: Path, raw: RawStream, request: ScanRequest, tally: _Tally, sample: EverySo) -> ScanFacts:
    if tally.box is not None:
        check_possible(path, _scaled(raw.grid, tally.box), tally.n_points, tally.n_bad)
    empty = note_empty_returns(path, tally.n_points - tally.n_kept, tally.n_points)
    step = sample_step(tally.n_kept, SAMPLE_POINTS)
    rows = sample.rows() if step == sample.step else _sampled_anew(raw, step)
    metric, site = replace(raw.grid, unit_m=METRES_PER_UNIT[request.unit]), grid_of_site(raw.grid, request)
    steps = check_step(path, metric.metres(rows), max(raw.grid.scale) * metric.unit_m)
    if tally.kept is not None:
        check_apart(path, _scaled(site, tally.kept), tally.n_kept)
    place = check_bulk(path, site.metres(rows))
    levelled = level_scan(path, np.empty((0, 3)), None, request.levelling)
    return ScanFacts(
        tally.n_points, raw.notes + raw.watch.notes() + empty + steps + place + levelled.notes, None
    )


def _sampled_anew(raw: RawStream, step: int) -> NDArray[np.int32]:
    """Sample what has a return in a second pass: how many there are is known only after the first."""
    zeros, sample = zero_cell(raw.grid), EverySo(step)
    for piece in raw.decode():
        kept = zeros.without(piece, box_of(piece))
        if len(kept):
            sample.see(kept)
    return sample.rows()


def _around(one: Bounds | None, other: Bounds) -> Bounds:
    if one is None:
        return other
    return Bounds(np.minimum(one.low, other.low), np.maximum(one.high, other.high))


def _scaled(grid: IntegerGrid, box: Bounds) -> Bounds:
    """Box in coordinates around a box in integers."""
    low, high = grid.metres(np.array([box.low, box.high]))
    return Bounds(low, high)
