"""How far two epochs err alike by the form of one wall."""

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.change import SeenSurface, likeness

Z, AZIMUTH = (
    grid.ravel() for grid in np.meshgrid(np.arange(5.0, 100.0, 10.0), np.radians(np.arange(5, 360, 10)))
)
RING = np.full(len(Z), 400.0)
SOUTH = np.where(np.abs(AZIMUTH - np.pi) < np.radians(60.0), 400.0, 0.0)
NORTH = np.where(np.abs(AZIMUTH - np.pi) > np.radians(120.0), 400.0, 0.0)


def seen(n_points: np.ndarray) -> SeenSurface:
    return SeenSurface(Z, AZIMUTH, n_points)


def test_the_same_coverage_errs_alike_whatever_its_density() -> None:
    assert likeness(seen(RING), seen(RING)) == pytest.approx(1.0)
    assert likeness(seen(RING), seen(10.0 * RING)) == pytest.approx(1.0)


def test_opposite_sides_have_nothing_in_common() -> None:
    assert likeness(seen(SOUTH), seen(NORTH)) == 0.0


def test_likeness_predicts_the_correlation_of_simulated_leans() -> None:
    rng = np.random.default_rng(2)
    wall = rng.normal(size=(3000, len(Z)))
    leans = []
    for points in (RING, SOUTH):
        terms = np.column_stack(
            [np.sin(AZIMUTH), np.cos(AZIMUTH), np.sin(AZIMUTH) * Z, np.cos(AZIMUTH) * Z, np.ones(len(Z)), Z]
        )[points > 0.0]
        leans.append(wall[:, points > 0.0] @ np.linalg.pinv(terms)[2:4].T)
    found = np.sum(leans[0] * leans[1]) / np.sqrt(np.sum(leans[0] ** 2) * np.sum(leans[1] ** 2))
    assert likeness(seen(RING), seen(SOUTH)) == pytest.approx(found, abs=0.05)


def test_other_pieces_or_nothing_seen_is_nothing_in_common() -> None:
    lower = SeenSurface(Z[Z < 50.0], AZIMUTH[Z < 50.0], RING[Z < 50.0])
    assert likeness(lower, seen(RING)) == 0.0
    assert likeness(seen(0.0 * RING), seen(RING)) == 0.0
    none = SeenSurface(np.zeros(0), np.zeros(0), np.zeros(0))
    assert likeness(none, none) == 0.0


def test_arrays_of_different_lengths_are_refused() -> None:
    with pytest.raises(ShapeError, match="one length"):
        likeness(SeenSurface(Z, AZIMUTH[:-1], RING), seen(RING))
