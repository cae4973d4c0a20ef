"""A square tower from the cloud to the lean, and what the steps between make of plane faces."""

import numpy as np
import pytest

from tasks.coverage import count_coverage
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.level_check import NOT_CHECKED, check_levels
from tasks.measure import measure_lean
from tasks.methods import method_of, suited_to
from tasks.next_station import suggest_station
from tasks.preprocessing import KINDS, Shaft, isolate_shaft
from tasks.registration import InstrumentSigmas, registered_cloud
from tasks.slicing import SCHEMES, user_scheme
from tests.unit.preprocessing.square_scenes import SQUARE, SQUARE_LEAN, Square, square_cloud, square_epoch

EXACT = InstrumentSigmas((1e-6, 1e-6), 1e-9, 1e-9)
"""Poses without error: what is left is the noise of the points."""


def chi2_of(lean: Lean | FitFailure) -> float:
    assert isinstance(lean, Lean), lean
    off = lean.lean - SQUARE_LEAN
    return float(off @ np.linalg.solve(lean.covariance, off))


def test_the_lean_of_a_tower_is_found_within_its_sigma() -> None:
    squares = [
        chi2_of(measure_lean(square_epoch(np.random.default_rng(seed)), SQUARE, EXACT, "A", "robust"))
        for seed in range(3)
    ]
    # chi-square with 6 degrees of freedom: 0.5 % below 0.7 and above 18.5
    assert 0.7 < sum(squares) < 18.5


def test_the_paper_measures_circles_to_the_letter() -> None:
    scheme = suited_to(SCHEMES["A"], "square-tower")
    assert method_of(scheme, "paper").contour == "kasa"
    assert method_of(scheme, "robust").contour == "polygon"


@pytest.mark.parametrize("kind", sorted(name for name, kind in KINDS.items() if not kind.n_faces))
def test_round_kinds_keep_the_contour_of_the_scheme(kind: str) -> None:
    assert suited_to(SCHEMES["A"], kind) == SCHEMES["A"]


def test_a_users_own_scheme_gets_the_polygon_too() -> None:
    assert suited_to(user_scheme("G", interval_m=2.5), "square-tower").robust_contour == "polygon"


@pytest.fixture(scope="module")
def shaft() -> Shaft:
    found = isolate_shaft(square_cloud(np.random.default_rng(20), 8_000), SQUARE)
    assert isinstance(found, Shaft), found
    return found


def test_points_of_a_face_are_on_the_surface_in_the_coverage_too(shaft: Shaft) -> None:
    exact = square_cloud(np.random.default_rng(21), 6_000, square=Square(noise_m=0.0), z_m=(1.0, 41.0))
    coverage = count_coverage(exact, np.zeros(len(exact), dtype=np.uint16), shaft.model, (1.0, 41.0), 1)
    mean_m = coverage.off_sum_m[coverage.points > 0] / coverage.points[coverage.points > 0]
    # a circle of half the mean side would be off by up to 1.2 m at the corners
    assert np.abs(mean_m).max() < 0.01


def test_no_station_is_suggested_by_a_prediction_for_round_shafts(shaft: Shaft) -> None:
    points = square_cloud(np.random.default_rng(22), 2_000, z_m=(1.0, 41.0))
    coverage = count_coverage(points, np.zeros(len(points), dtype=np.uint16), shaft.model, (1.0, 41.0), 1)
    answer = suggest_station(coverage, shaft.model, registered_cloud("cloud", EXACT), EXACT)
    assert isinstance(answer, FitFailure)
    assert "round" in answer.reason


def test_levels_are_not_checked_against_plane_faces(shaft: Shaft) -> None:
    points = square_cloud(np.random.default_rng(23), 4_000)
    station = np.arange(len(points), dtype=np.uint16) % 2
    assert check_levels(points, station, shaft.model, [1e-5, 1e-5]) == (NOT_CHECKED, NOT_CHECKED)
