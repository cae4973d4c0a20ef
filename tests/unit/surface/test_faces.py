"""Plane faces fitted to all points of a tower at once: lean, taper, twist, and what two or three faces can say."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.surface.faces import FacesFit, FacesStart, fit_faces
from tests.unit.preprocessing.scenes import ARCSEC
from tests.unit.preprocessing.square_scenes import (
    SQUARE_AZIMUTH_RAD,
    SQUARE_BASE,
    SQUARE_LEAN,
    Square,
    square_cloud,
    square_ladder,
)

# 4 mm and half a minute of arc off, 3 mm too wide
START = FacesStart(
    shaft_z_m=(1.0, 41.0),
    base_m=SQUARE_BASE + 0.004,
    lean=SQUARE_LEAN + 1.5e-4,
    azimuth_rad=SQUARE_AZIMUTH_RAD + 0.001 + np.arange(4) * np.pi / 2,
    twist_rad_per_m=0.0,
    half_m=np.array([[3.003] * 4, [2.203] * 4]),
)


def fitted(points_m: NDArray[np.float64], start: FacesStart = START) -> FacesFit:
    fit = fit_faces(points_m, start)
    assert isinstance(fit, FacesFit), fit
    return fit


def off_arcsec(fit: FacesFit) -> NDArray[np.float64]:
    return np.asarray((fit.lean - SQUARE_LEAN) * ARCSEC)


def test_a_tower_without_noise_gives_its_own_lean() -> None:
    fit = fitted(square_cloud(np.random.default_rng(1), 5_000, square=Square(noise_m=0.0)))
    assert fit.lean == pytest.approx(SQUARE_LEAN, abs=1e-9)
    assert fit.base_m == pytest.approx(SQUARE_BASE, abs=1e-7)
    assert [face.taper for face in fit.faces] == pytest.approx([-0.02] * 4, abs=1e-9)


def test_stated_sigmas_match_the_scatter_over_repeats() -> None:
    fits = [fitted(square_cloud(np.random.default_rng(100 + i), 1_500)) for i in range(80)]
    squares = [
        off_arcsec(f) @ np.linalg.solve(f.lean_covariance * ARCSEC**2, off_arcsec(f)) / 2.0 for f in fits
    ]
    # chi-square of 160: sd 11 %; 3 sd
    assert np.mean(squares) == pytest.approx(1.0, abs=0.34)
    twists = [fit.twist_rad_per_m / fit.twist_sigma_rad_per_m for fit in fits]
    assert np.std(twists) == pytest.approx(1.0, abs=0.24)  # 80 values: sd 8 %; 3 sd


def test_lean_is_as_good_as_the_points_allow() -> None:
    n = 20_000
    fit = fitted(square_cloud(np.random.default_rng(2), n, z_m=(1.0, 41.0)))
    # a face pulls along its normal only: n / 2 points a component over L / sqrt(12), 5 % for the robust weights
    bound = 0.006 / np.sqrt(n / 2) / (40.0 / np.sqrt(12.0))
    assert np.sqrt(np.diag(fit.lean_covariance)) == pytest.approx([bound, bound], rel=0.1)


def test_a_ladder_does_not_bias_the_lean() -> None:
    rng = np.random.default_rng(3)
    plain, ladder = square_cloud(rng), square_ladder(rng)
    shift = off_arcsec(fitted(np.vstack([plain, ladder]))) - off_arcsec(fitted(plain))
    assert np.abs(shift).max() < 0.5  # half of its sigma


def test_twist_is_the_turn_of_the_faces_with_height() -> None:
    fit = fitted(square_cloud(np.random.default_rng(4), square=Square(twist_rad_per_m=8e-4)))
    assert fit.twist_rad_per_m == pytest.approx(8e-4, abs=4 * fit.twist_sigma_rad_per_m)
    assert fit.twist_sigma_rad_per_m < 5e-6
    assert np.abs(off_arcsec(fit)).max() < 5.0  # sigma 1.1"


def test_the_lean_of_a_bent_tower_does_not_depend_on_where_points_are_dense() -> None:
    rng = np.random.default_rng(5)
    bent = Square(bend_m=0.2)
    dense_below = np.vstack([square_cloud(rng, square=bent), square_cloud(rng, square=bent, z_m=(0.0, 10.0))])
    fit = fitted(dense_below)
    # the best uniform line through a parabola of 0.2 m over 40 m rises by 0.2 / 40
    assert fit.lean[0] == pytest.approx(SQUARE_LEAN[0] + 0.2 / 40.0, abs=5.0 / ARCSEC)
    # its largest distance from that line, at the ends: a sixth of it
    assert fit.bending_m == pytest.approx(0.2 / 6.0, abs=0.001)


def test_a_straight_tower_is_not_called_bent() -> None:
    assert fitted(square_cloud(np.random.default_rng(6))).bending_m is None


def test_a_face_that_is_hidden_above_pulls_less() -> None:
    rng = np.random.default_rng(7)
    whole = square_cloud(rng, 16_000)
    above = whole[:, 2] > 21.0
    fit = fitted(np.vstack([whole[~above], square_cloud(rng, 4_000, (0, 1), z_m=(21.0, 42.0))]))
    full = fitted(whole)
    assert np.trace(fit.lean_covariance) > 1.5 * np.trace(full.lean_covariance)
    assert np.abs(off_arcsec(fit)).max() < 5.0 * np.sqrt(np.trace(fit.lean_covariance)) * ARCSEC


def test_three_faces_lean_on_an_assumption_that_is_stated_and_paid_for() -> None:
    fit = fitted(square_cloud(np.random.default_rng(8), faces=(0, 1, 2)))
    assert fit.assumption is not None
    assert "taper" in fit.assumption
    along_lone = np.array([np.cos(SQUARE_AZIMUTH_RAD), -np.sin(SQUARE_AZIMUTH_RAD)])
    # the second normal, 0.4 rad and a right angle, is the direction that only one face sees
    assert along_lone @ fit.lean_covariance @ along_lone == pytest.approx(5e-4**2, rel=0.01)


def test_two_faces_that_meet_cannot_tell_lean_from_taper() -> None:
    fit = fit_faces(square_cloud(np.random.default_rng(9), faces=(0, 1)), START)
    assert isinstance(fit, FitFailure)
    assert "lean and taper cannot be told apart" in fit.reason


def test_faces_without_points_are_a_failure() -> None:
    fit = fit_faces(np.empty((0, 3)), START)
    assert isinstance(fit, FitFailure)
    assert "got them on 0 of 4" in fit.reason


def test_points_in_pieces_are_points_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    points = square_cloud(np.random.default_rng(10), 6_000)
    at_once = fitted(points)
    monkeypatch.setattr("tasks.surface.face_equations.CHUNK", 500)
    assert fitted(points).lean == pytest.approx(at_once.lean, abs=1e-12)


def test_an_odd_number_of_faces_is_misuse() -> None:
    with pytest.raises(ShapeError, match="even number of at least 4 faces"):
        FacesStart((0.0, 1.0), np.zeros(2), np.zeros(2), np.zeros(5), 0.0, np.ones((2, 5)))


def rough_cloud(rng: np.random.Generator, wall: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of a tower whose faces are off their planes by ``wall`` (4, 50, 6), piece by piece of 0.8 m by about 1 m."""
    points_m = square_cloud(rng, 8_000, square=Square(first_m=(3.0, 3.0), second_m=(3.0, 3.0), noise_m=0.001))
    azimuth = SQUARE_AZIMUTH_RAD + np.arange(4) * np.pi / 2
    normals = np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    xy = points_m[:, :2] - SQUARE_BASE - points_m[:, 2:] * SQUARE_LEAN
    face = np.argmax(xy @ normals.T, axis=1)
    tangents = np.column_stack([np.cos(azimuth), -np.sin(azimuth)])
    along = np.clip((np.sum(xy * tangents[face], axis=1) / 3.0 + 1.0) / 2.0 * 6.0, 0, 5).astype(int)
    height = np.clip((points_m[:, 2] - 1.0) / 0.8, 0, 49).astype(int)
    points_m[:, :2] += wall[face, height, along, None] * normals[face]
    return points_m


def test_stated_sigmas_hold_on_walls_that_are_not_plane() -> None:
    """Of brickwork 3 mm off its planes the points alone would state a tenth of the error."""
    start = FacesStart(
        START.shaft_z_m, START.base_m, START.lean, START.azimuth_rad, 0.0, np.array([[3.003] * 4] * 2)
    )
    squares, points_only = [], []
    for seed in range(40):
        rng = np.random.default_rng(400 + seed)
        fit = fitted(rough_cloud(rng, rng.normal(0.0, 0.003, (4, 50, 6))), start)
        off = fit.lean - SQUARE_LEAN
        squares.append(off @ np.linalg.solve(fit.lean_covariance + fit.form_covariance, off) / 2.0)
        points_only.append(off @ np.linalg.solve(fit.lean_covariance, off) / 2.0)
    # chi-square of 80: sd 16 %; 3 sd, and what the estimate of the form scatters
    assert 0.5 < np.mean(squares) < 1.6
    assert np.mean(points_only) > 5.0


def test_plane_faces_have_no_form_beyond_their_noise() -> None:
    fits = [fitted(square_cloud(np.random.default_rng(500 + seed), 3_000)) for seed in range(10)]
    shares = [np.trace(fit.form_covariance) / np.trace(fit.lean_covariance) for fit in fits]
    # noise looks like form at two sigmas in one of forty, for each of three sizes
    assert np.median(shares) == 0.0
    assert np.mean(shares) < 1.0
