"""The isolation on scans that nobody simulated with this code."""

import json

import laspy
import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import azimuth_deg, rotation_site_scanner
from tasks.preprocessing import Shaft, StructurePrior
from tests.shared import SHARED, needs_shared
from tests.unit.preprocessing.scenes import ARCSEC, counts_of, isolated, lean_of

pytestmark = needs_shared

EVERY = 5
"""One point in so many of the campaign: 30 seconds of reading and fitting become 5."""


def las_points_m(name: str) -> NDArray[np.float64]:
    cloud = laspy.read(SHARED / "data" / name)
    return np.column_stack([cloud.x, cloud.y, cloud.z]).astype(np.float64)


@pytest.fixture(scope="module")
def pines_m() -> NDArray[np.float64]:
    return las_points_m("stems/LPine1_demo.laz")


@pytest.fixture(scope="module")
def campaign_m() -> NDArray[np.float64]:
    truth = json.loads((SHARED / "data/campaign/e1/truth.json").read_text(encoding="utf-8"))
    placed = []
    for station in truth["stations"]:
        # the file counts counter-clockwise from east to the x axis, we clockwise from north to the y axis
        rotation = rotation_site_scanner(-np.radians(station["true_heading_deg"]))
        points = las_points_m(f"campaign/e1/{station['file']}")[::EVERY]
        placed.append(points @ rotation.T + np.array(station["true_position"]))
    return np.vstack(placed)


@pytest.fixture(scope="module")
def chimney(campaign_m: NDArray[np.float64]) -> Shaft:
    return isolated(campaign_m, StructurePrior("chimney", (2.0, 102.0), (0.0, 0.0), (4.6, 2.7)))


def stem(points_m: NDArray[np.float64], east_m: float, north_m: float, radius_m: float = 0.15) -> Shaft:
    return isolated(points_m, StructurePrior("stem", (1.0, 6.0), (east_m, north_m), (radius_m, radius_m)))


def tilt_deg(shaft: Shaft) -> float:
    return float(np.degrees(np.arctan(np.hypot(*lean_of(shaft)))))


def azimuth_error_deg(shaft: Shaft, stated_deg: float) -> float:
    return abs((azimuth_deg(*lean_of(shaft)) - stated_deg + 180.0) % 360.0 - 180.0)


STEMS = [
    (11.03, 4.41, 1.62, 303.0),
    (3.06, 5.10, 1.39, 31.0),
    (3.83, 1.34, 0.83, 254.0),
    (7.14, 2.29, 1.28, 263.0),
    (8.67, 3.86, 3.18, 292.0),
    (5.02, 7.07, 3.49, 265.0),
    (0.78, 7.14, 4.33, 237.0),
]


def test_the_best_stem_leans_as_the_data_say(pines_m: NDArray[np.float64]) -> None:
    shaft = stem(pines_m, 11.03, 4.41)
    # the tolerance of the issue
    assert tilt_deg(shaft) == pytest.approx(1.62, abs=0.15)
    assert azimuth_error_deg(shaft, 303.0) < 8.0


@pytest.mark.parametrize(("east_m", "north_m", "stated_tilt_deg", "stated_azimuth_deg"), STEMS)
def test_every_stem_is_found_with_one_prior_radius(
    pines_m: NDArray[np.float64],
    east_m: float,
    north_m: float,
    stated_tilt_deg: float,
    stated_azimuth_deg: float,
) -> None:
    shaft = stem(pines_m, east_m, north_m)
    # the stated values are somebody's fits to crooked stems, half of them seen from one side: 0.2 deg, 26 mm at 5 m
    assert tilt_deg(shaft) == pytest.approx(stated_tilt_deg, abs=0.2)
    assert azimuth_error_deg(shaft, stated_azimuth_deg) < 8.0


@pytest.mark.parametrize("offset_m", [(0.2, 0.0), (-0.14, 0.14), (0.0, -0.2)])
def test_a_position_off_by_a_stem_finds_the_same_stem(
    pines_m: NDArray[np.float64], offset_m: tuple[float, float]
) -> None:
    shaft = stem(pines_m, 11.03 + offset_m[0], 4.41 + offset_m[1])
    # the sample drawn is another one: 8 mm noise of 800 points a band over 5 m is below 0.02 deg
    assert tilt_deg(shaft) == pytest.approx(tilt_deg(stem(pines_m, 11.03, 4.41)), abs=0.02)


def test_the_model_of_the_campaign_leans_as_the_truth(chimney: Shaft) -> None:
    # true poses leave 0.8" (data/README.md); a fifth of the points adds 0.2"
    assert np.hypot(*(lean_of(chimney) - (0.00725, -0.00695))) * ARCSEC < 1.5


def test_slabs_of_the_kept_points_lean_as_the_truth(campaign_m: NDArray[np.float64], chimney: Shaft) -> None:
    centres = slab_centres_m(campaign_m[chimney.keep], chimney)
    lean = np.polyfit(centres[:, 2], centres[:, :2], 1)[0]
    assert np.hypot(*(lean - (0.00725, -0.00695))) * ARCSEC < 1.5


def test_the_counts_of_the_campaign_add_up(campaign_m: NDArray[np.float64], chimney: Shaft) -> None:
    assert sum(counts_of(chimney).values()) == len(campaign_m)


def test_the_ladder_and_platform_of_the_campaign_go(campaign_m: NDArray[np.float64], chimney: Shaft) -> None:
    ray = campaign_m[:, :2] - np.outer(campaign_m[:, 2], (0.00725, -0.00695))
    # radii of truth.json: 4.6 m at the ground and 2.7 m at 110 m; the ladder stands 0.2 m and more off
    off_m = np.hypot(ray[:, 0], ray[:, 1]) - (4.6 - 1.9 * campaign_m[:, 2] / 110.0)
    assert np.abs(off_m[chimney.keep]).max() < 0.08


def slab_centres_m(points_m: NDArray[np.float64], shaft: Shaft) -> NDArray[np.float64]:
    """Centres (k, 3) of robust circles in slabs of half a metre, an estimator of the test's own."""
    slab = (points_m[:, 2] // 0.5).astype(int)
    return np.array([circle_centre_m(points_m[slab == one], lean_of(shaft)) for one in np.unique(slab)])


def circle_centre_m(points_m: NDArray[np.float64], lean: NDArray[np.float64]) -> NDArray[np.float64]:
    z_m = points_m[:, 2].mean()
    xy = points_m[:, :2] - np.outer(points_m[:, 2] - z_m, lean)
    circle = np.append(xy.mean(axis=0), 3.5)
    for _ in range(12):
        ray = xy - circle[:2]
        distance = np.hypot(*ray.T)
        off = distance - circle[2]
        weight = np.clip(1.0 - (off / (4.685 * 1.4826 * np.median(np.abs(off)))) ** 2, 0.0, 1.0) ** 2
        design = np.column_stack([ray / distance[:, None], np.ones(len(ray))])
        circle += np.linalg.solve((design * weight[:, None]).T @ design, (design * weight[:, None]).T @ off)
    return np.append(circle[:2], z_m)


def test_the_arm_and_the_sign_of_a_lamppost_do_not_tilt_its_pole() -> None:
    # the file is text: eleven lines of header, then x y z
    points_m = np.loadtxt(SHARED / "data/pole/lamppost.pcd", skiprows=11)
    shaft = isolated(points_m, StructurePrior("mast", (-5.3, -0.2), (-9.85, 0.03), (0.08, 0.06)))
    # the middle of the pole's extent in slabs leans 2.2 deg to 261 deg; coordinates lie on a grid of 31 mm,
    # a plain principal axis gives 9.8 deg
    assert tilt_deg(shaft) == pytest.approx(2.2, abs=0.8)
    assert azimuth_error_deg(shaft, 261.0) < 10.0
