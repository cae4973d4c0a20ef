"""Whether, when and how the movement of a structure changed: one step, or one turn of its rate."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.trend.change_dating import DatedChange, date_change
from tasks.trend.change_scan import likelihood_ratios, scan_of, scan_p_value
from tasks.trend.onsets import KINDS, Kind, Onsets, change_columns, onsets_between, thinned
from tasks.trend.series import LeanSeries
from tasks.trend.terms import Terms, choose_terms, design_columns
from tasks.trend.walk import WalkModel, build_model, rotate, walk_sigma

CHANGE_EPOCHS: Final = 7
"""Below, a line, a change and its onset leave too little over to test it."""

SCANNED: Final = 40
"""Onsets of each kind that a scan looks at; dating looks at all."""


@dataclass(frozen=True, slots=True)
class ChangePoint:
    """The change that explains a series best, and how often chance alone would do as well.

    ``first_epoch`` is the index of the first epoch at or after the onset. ``dated.change`` is the step, metres, or the rate
    after it less that before, metres a year.
    """

    kind: Kind
    first_epoch: int
    p_value: float
    dated: DatedChange


def find_change(
    series: LeanSeries,
    rng: np.random.Generator,
    terms: Terms | None = None,
    kinds: tuple[Kind, ...] = KINDS,
) -> ChangePoint | FitFailure:
    """Find the onset at which a step or a turn of the rate explains the movements best.

    The maximum of the likelihood ratio over all onsets and kinds, under the full covariance, each with its own best sigma of
    the random walk. Its p value is by simulation of series without change, so that having looked at every onset is
    paid for, and having had to estimate the random walk too.

    Parameters
    ----------
    series : LeanSeries
        Movements over the epochs.
    rng : numpy.random.Generator
        For the simulated series.
    terms : Terms or None
        What else moves the structure; None chooses by the epochs.
    kinds : tuple of "step", "rate"
        Changes to look for.

    Returns
    -------
    ChangePoint or FitFailure
        The best one, significant or not; the failure says why there is none to test.

    Raises
    ------
    ShapeError
        If no kind is given or an unknown one.
    """
    if not kinds or not set(kinds) <= set(KINDS):
        raise ShapeError(f"find_change needs one or more of {', '.join(KINDS)}; got {kinds!r}")
    chosen = choose_terms(series) if terms is None else terms
    if series.n_times < CHANGE_EPOCHS or not chosen.rate:
        return FitFailure(f"no change point: {series.n_times} epochs, needs {CHANGE_EPOCHS}")
    columns = design_columns(series, chosen)
    if columns.shape[1] + 2 >= series.n_times:
        return FitFailure(f"no change point: {columns.shape[1] + 1} unknowns of {series.n_times} epochs")
    onsets = [thinned(onsets_between(series, kind, 1), SCANNED) for kind in kinds]
    model = build_model(series, columns, chosen.random_walk)
    best = scan_onsets(model, series, onsets, rng)
    dated = date_change(series, columns, model, best.kind, best.time)
    first = int(np.searchsorted(series.times, dated.time))
    return ChangePoint(best.kind, first, best.p_value, dated)


@dataclass(frozen=True, slots=True)
class BestOnset:
    """The onset of a scan that gains most: ``gain`` is twice that in log-likelihood."""

    kind: Kind
    time: float
    gain: float
    p_value: float


def scan_onsets(
    model: WalkModel, series: LeanSeries, onsets: list[Onsets], rng: np.random.Generator
) -> BestOnset:
    """Look for the best of all onsets under the model of a series, and test it by simulated series without change."""
    left = rotate(model, series.movements.reshape(-1)).left
    walk = walk_sigma(model, left)
    scan = scan_of(model, np.concatenate([_left_of(model, series, one) for one in onsets]), walk)
    gains = likelihood_ratios(scan, left[:, None])[:, 0]
    best = int(np.argmax(gains))
    kinds = [one.kind for one in onsets for _ in one.times]
    times = np.concatenate([one.times for one in onsets])
    gain = float(gains[best])
    return BestOnset(kinds[best], float(times[best]), gain, scan_p_value(model, scan, walk, gain, rng))


def _left_of(model: WalkModel, series: LeanSeries, onsets: Onsets) -> NDArray[np.float64]:
    """Columns of onsets as residuals (k, 2, m) of the unknowns."""
    left = rotate(model, change_columns(series, onsets)).left
    return left.T.reshape(len(onsets.times), 2, -1)
