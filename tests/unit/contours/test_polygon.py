"""The contour of a section with straight faces: a line for each, the centre on the mid-lines."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.contours import Contour, Outline, Section, fit_contour
from tasks.geometry.faces import normals_of, tangents_of
from tasks.geometry.failure import FitFailure
from tests.unit.contours.rings import ring, section_of

CENTRE = np.array([12.0, -7.0])
AZIMUTH = 0.3
HALF = np.array([3.0, 2.5, 3.0, 2.5])
SIGMA = 0.006


def box(
    rng: np.random.Generator, faces: tuple[int, ...] = (0, 1, 2, 3), n: int = 400, sigma_m: float = SIGMA
) -> NDArray[np.float64]:
    """Points (n, 3) on some faces of a rectangle."""
    face = rng.choice(np.array(faces), n)
    azimuth = AZIMUTH + face * np.pi / 2
    out = HALF[face] + sigma_m * rng.standard_normal(n)
    along = HALF[(face + 1) % 4] * rng.uniform(-1.0, 1.0, n)
    xy = CENTRE + out[:, None] * normals_of(azimuth) + along[:, None] * tangents_of(azimuth)
    return np.column_stack([xy, np.zeros(n)])


def outline(sigma_m: float = np.inf, off_m: float = 0.02, turned_rad: float = 0.003) -> Outline:
    """What a model knows of the rectangle: a little off, and turned."""
    return Outline(
        center_m=CENTRE + off_m,
        azimuth_rad=AZIMUTH + turned_rad + np.arange(4) * np.pi / 2,
        half_m=HALF,
        taper=np.zeros(4),
        sigma_m=np.full(4, sigma_m),
    )


def polygon(points_m: NDArray[np.float64], known: Outline | None = None) -> Contour:
    fit = fit_contour("polygon", Section(points_m, 0.0, 0.2, outline=known))
    assert isinstance(fit, Contour), fit
    return fit


def off_centre(fit: Contour) -> NDArray[np.float64]:
    return np.array([fit.center_east_m, fit.center_north_m]) - CENTRE


@pytest.mark.parametrize("known", [None, outline()])
def test_a_rectangle_without_noise_gives_its_own_centre(known: Outline | None) -> None:
    fit = polygon(box(np.random.default_rng(1), sigma_m=0.0), known)
    assert off_centre(fit) == pytest.approx([0.0, 0.0], abs=1e-6)
    assert fit.radius_m == pytest.approx(2.75, abs=1e-6)  # half of the mean side


@pytest.mark.parametrize("known", [None, outline()])
def test_stated_covariance_matches_the_scatter_over_repeats(known: Outline | None) -> None:
    rng = np.random.default_rng(2)
    fits = [polygon(box(rng), known) for _ in range(150)]
    squares = [off_centre(fit) @ np.linalg.solve(fit.covariance_m2, off_centre(fit)) for fit in fits]
    # chi-square of 300: sd 8 %; 3 sd
    assert np.mean(squares) / 2.0 == pytest.approx(1.0, abs=0.25)


def test_centres_are_as_good_as_opposite_lines_allow() -> None:
    fit = polygon(box(np.random.default_rng(3), n=4_000), outline())
    # half the difference of two lines of 1000 points: sigma * sqrt(2 / 1000) / 2; the robust weights cost 5 %
    bound = SIGMA * np.sqrt(2.0 / 1000.0) / 2.0
    assert np.sqrt(np.trace(fit.covariance_m2) / 2.0) == pytest.approx(bound, rel=0.12)


def test_a_ladder_on_one_face_does_not_move_the_centre() -> None:
    rng = np.random.default_rng(4)
    plain = box(rng)
    n = 40
    ladder = CENTRE + np.outer(3.0 + rng.uniform(0.05, 0.25, n), normals_of(np.array(AZIMUTH)))
    ladder += np.outer(rng.uniform(-0.3, 0.3, n), tangents_of(np.array(AZIMUTH)))
    both = np.vstack([plain, np.column_stack([ladder, np.zeros(n)])])
    shift = off_centre(polygon(both, outline())) - off_centre(polygon(plain, outline()))
    assert np.abs(shift).max() < SIGMA * np.sqrt(2.0 / 100.0) / 2.0  # within its own sigma


def test_lean_and_taper_within_a_thick_slice_are_taken_out() -> None:
    rng = np.random.default_rng(5)
    points = box(rng, sigma_m=0.0)
    rise = rng.uniform(-1.0, 1.0, len(points))
    widened = CENTRE + (points[:, :2] - CENTRE) * (1.0 - 0.02 / 2.75 * rise)[:, None]
    leaning = np.column_stack([widened + np.outer(rise, [0.01, -0.02]), rise])
    known = outline()
    section = Section(
        leaning,
        0.0,
        2.0,
        lean_east=0.01,
        lean_north=-0.02,
        outline=Outline(known.center_m, known.azimuth_rad, HALF, -0.02 / 2.75 * HALF, known.sigma_m),
    )
    fit = fit_contour("polygon", section)
    assert isinstance(fit, Contour)
    assert off_centre(fit) == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("faces", [(0, 1), (0, 1, 2)])
def test_without_opposite_faces_there_is_no_centre(faces: tuple[int, ...]) -> None:
    fit = fit_contour("polygon", Section(box(np.random.default_rng(6), faces), 0.0, 0.2, outline=outline()))
    assert isinstance(fit, FitFailure)
    assert "centre not determined" in fit.reason


def test_a_side_that_is_known_stands_in_for_the_face_that_is_not_seen() -> None:
    fit = polygon(box(np.random.default_rng(7), (0, 1)), outline(sigma_m=0.002))
    # 2 mm of half a side, 0.6 mm of a line through 200 points and the little that a rotation adds; 4 sd
    assert off_centre(fit) == pytest.approx([0.0, 0.0], abs=0.004)
    assert np.sqrt(np.diag(fit.covariance_m2)) == pytest.approx([0.0021, 0.0021], rel=0.1)
    assert fit.reason is not None
    assert "6000 mm and 5000 mm of side taken from the model" in fit.reason


def test_the_faces_that_were_seen_are_named_in_a_failure() -> None:
    fit = fit_contour("polygon", Section(box(np.random.default_rng(8), (0, 1)), 0.0, 0.2, outline=outline()))
    assert isinstance(fit, FitFailure)
    assert "azimuths 17, 107 deg" in fit.reason  # 0.3 rad and a right angle more


def test_a_circle_is_not_taken_for_a_square() -> None:
    fit = fit_contour("polygon", section_of(ring(np.random.default_rng(9), 400)))
    assert isinstance(fit, FitFailure)
    assert "straight faces" in fit.reason


def test_coordinates_of_millions_of_metres_cost_a_micrometre_at_most() -> None:
    points = box(np.random.default_rng(10))
    far = np.array([500_000.0, 6_000_000.0, 0.0])
    here, there = polygon(points), polygon(points + far)
    assert off_centre(there) - far[:2] == pytest.approx(off_centre(here), abs=2e-6)
