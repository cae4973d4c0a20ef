"""The prediction against what can be written down: bounds of full circles and arcs, levels of stations evenly around."""

import numpy as np
import pytest

from tasks.conventions import ARCSEC_RAD
from tasks.design import Errors, Prediction, Scanning, Shaft, Survey, predict_survey, sites_at, whole_surface
from tasks.design.normals import station_normals
from tasks.design.prediction import predict_lean
from tasks.design.shaft import CELL_DEG, cut_cells
from tasks.design.sight import Site, View

CYLINDER = Shaft((0.0, 100.0), (4.0, 4.0))
CHIMNEY = Shaft((2.0, 102.0), (4.6, 2.7))
SIGMA_M = 0.02


def ring(n: int, errors: Errors, shaft: Shaft = CHIMNEY, distance_m: float = 230.0) -> Prediction:
    sites = sites_at(shaft, [360.0 * i / n for i in range(n)], distance_m, 1.6)
    scanning = Scanning(float(np.radians(0.02)))
    found = predict_survey(Survey(shaft, whole_surface(shaft), sites, scanning, errors))
    assert isinstance(found, Prediction)
    return found


def test_a_shaft_seen_all_round_reaches_the_closed_form() -> None:
    """sigma^2 of a component = 24 sigma^2 / (N L^2) with N points evenly over the surface of a cylinder."""
    sites = sites_at(CYLINDER, [10.0 * i for i in range(36)], 5000.0, 50.0)
    errors = Errors(range_m=0.0, roughness_m=SIGMA_M)
    survey = Survey(
        CYLINDER, whole_surface(CYLINDER), sites, Scanning(1e-4), errors, points_per_station=1000.0
    )
    found = predict_survey(survey)
    assert isinstance(found, Prediction)
    # 40 bands instead of a continuum: 1 / 40^2; from 5 km the ends are as far away as the middle within 1e-4
    assert found.covariance == pytest.approx(24.0 * SIGMA_M**2 / (36_000 * 100.0**2) * np.eye(2), rel=2e-3)


@pytest.mark.parametrize(
    ("arc_deg", "along", "across"),
    [
        (360, 2.0, 2.0),
        (240, 4.43, 1.66),
        (180, 10.6, 2.0),
        (120, 43.8, 3.41),
        (90, 129.0, 5.50),
        (60, 623.0, 11.6),
    ],
)
def test_an_arc_reaches_the_factors_of_a_circle(arc_deg: float, along: float, across: float) -> None:
    """Variances of a centre in units of sigma^2 / N for points evenly on an arc about north; of the lean 12 / L^2 of it."""
    cells = cut_cells(CYLINDER, whole_surface(CYLINDER))
    off_north_deg = np.abs((np.degrees(cells.azimuth_rad) + 180.0) % 360.0 - 180.0)
    counts = np.tile(10.0 * (off_north_deg < arc_deg / 2.0), (len(cells.bands.z_m), 1))
    view = View(counts, np.full(counts.shape, SIGMA_M))
    part = station_normals(cells, Site("ST01", (0.0, 200.0, 1.6)), view)
    found = predict_lean(cells, [part], Errors())
    assert isinstance(found, Prediction)
    unit = SIGMA_M**2 / counts.sum() * 12.0 / 100.0**2
    # the table has three digits, and an arc is cut into cells of 2.5 degrees
    assert CELL_DEG <= 2.5
    assert np.diag(found.covariance) / unit == pytest.approx([across, along], rel=0.01)


@pytest.mark.parametrize("n", [3, 4, 8])
def test_levels_of_stations_evenly_around_come_in_by_the_root_of_their_number(n: int) -> None:
    level_rad = 10.0 * ARCSEC_RAD
    found = ring(n, Errors(angle_rad=1e-5, level_rad=level_rad))
    # across the sight a station pulls less than along it: 0.7 % beside equal shares
    assert np.sqrt(np.diag(found.level)) == pytest.approx(np.full(2, level_rad / np.sqrt(n)), rel=0.01)


def test_one_station_hands_its_level_on_whole() -> None:
    found = ring(1, Errors(level_rad=10.0 * ARCSEC_RAD))
    assert found.pull == pytest.approx([1.0], rel=1e-3)


def test_a_station_pulls_more_along_its_sight_than_across() -> None:
    """Three stations have more than a third each in their own direction: the shares are matrices."""
    found = ring(3, Errors(level_rad=10.0 * ARCSEC_RAD))
    assert (found.pull > 0.36).all()


def test_ten_seconds_of_level_on_one_station_are_five_millimetres_at_the_top() -> None:
    """10 seconds on 1 station = 4.9 mm at 102 m, 20 seconds on 8 stations = 3.5 mm per component."""
    one = ring(1, Errors(level_rad=10.0 * ARCSEC_RAD)).level
    eight = ring(8, Errors(level_rad=20.0 * ARCSEC_RAD)).level
    assert 102.0 * np.sqrt(one[0, 0]) == pytest.approx(0.0049, abs=1e-4)
    assert 102.0 * np.sqrt(eight[0, 0]) == pytest.approx(0.0035, abs=1e-4)


def test_positions_and_headings_nearly_cancel_over_the_height() -> None:
    errors = Errors(position_m=(0.015, 0.0225), heading_rad=float(np.radians(0.15)))
    found = ring(8, errors)
    assert found.shares["position"] + found.shares["heading"] < 0.01
    assert found.sigma_worst == pytest.approx(ring(8, Errors()).sigma_worst, rel=0.01)
