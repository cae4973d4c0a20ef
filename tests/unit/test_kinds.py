"""Every kind of structure from its scans to its lean: simulated with known truth, measured without hand work."""

from dataclasses import replace
from typing import Final

import numpy as np
import pytest

from tasks.accuracy import lean_difference
from tasks.level_check import worst_suspect
from tasks.preprocessing import KINDS
from tasks.simulation.kinds import CASES, request_of_kind
from tests.unit.simulated_kinds import MeasuredKind, chi2_of, measured_epochs

CHI2_999: Final = 13.8
"""One of a thousand chi-squares with 2 degrees of freedom is above it: seeds are fixed, so a test fails always or never."""

POINTS: Final = {"mast": 30_000}
"""Points of a station: a thin mast leaves few of 12,000, and the site around it too few to tie some stations."""

QUICK = ("silo", "square-tower", "stem")
"""Kinds at which every run of the tests looks; the slow ones look at all."""

every_kind = pytest.mark.parametrize(
    "kind",
    [
        kind if kind in QUICK else pytest.param(kind, marks=pytest.mark.slow)
        for kind in sorted(set(CASES) - {"chimney"})
    ],
    scope="module",
)
"""Chimneys have the tests of the demo."""


@pytest.fixture(scope="module")
def epochs(kind: str) -> tuple[MeasuredKind, ...]:
    """The first epoch and the last of four, five stations."""
    request = request_of_kind(kind, epochs=2, stations=5, points=POINTS.get(kind, 12_000), seed=3)
    last = request.movement.lean_arcsec[-1]
    moved = replace(request, movement=replace(request.movement, lean_arcsec=(0.0, last)))
    return tuple(measured_epochs(moved))


def test_every_kind_has_a_case_of_its_own() -> None:
    assert set(CASES) == set(KINDS)


@every_kind
def test_the_lean_is_the_true_one_within_its_stated_sigma(epochs: tuple[MeasuredKind, ...]) -> None:
    for epoch in epochs:
        lean = epoch.whole
        assert chi2_of(lean.lean - epoch.truth, lean.covariance) < CHI2_999


@every_kind
def test_what_is_stated_is_useful(kind: str, epochs: tuple[MeasuredKind, ...]) -> None:
    """A sigma without bound would hold every truth: a tenth of the last movement is asked of it."""
    sigma = np.sqrt(np.trace(epochs[0].whole.covariance) / 2.0)
    step = np.linalg.norm(epochs[1].truth - epochs[0].truth)
    assert sigma < 0.1 * step, kind


@every_kind
def test_the_movement_between_two_epochs_is_found(epochs: tuple[MeasuredKind, ...]) -> None:
    first, last = (epoch.whole for epoch in epochs)
    found = lean_difference(last.lean - first.lean, first.covariance + last.covariance)
    moved = epochs[1].truth - epochs[0].truth
    assert found.significant
    assert chi2_of(found.difference - moved, first.covariance + last.covariance) < CHI2_999


@every_kind
def test_slices_agree_with_the_whole_surface(epochs: tuple[MeasuredKind, ...]) -> None:
    whole, sliced = epochs[0].whole, epochs[0].sliced
    # both see the same points, so the covariance of their difference is at most the sum
    assert chi2_of(sliced.lean - whole.lean, sliced.covariance + whole.covariance) < CHI2_999


@every_kind
def test_no_sound_station_is_suspect_by_its_level(epochs: tuple[MeasuredKind, ...]) -> None:
    for epoch in epochs:
        assert worst_suspect(epoch.shaft.levels) is None
