"""Scheme S of a square tower: plane faces, all points at once."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.conventions import ARCSEC_RAD
from tasks.faces_lean import fit_face_axis
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.measure import measure_lean
from tasks.placing import PlacedCloud
from tasks.preprocessing import Shaft, ShaftModel, isolate_shaft
from tasks.registration import InstrumentSigmas, Registration
from tasks.whole_surface import SurfaceQuestion, lean_of_surface
from tests.unit.networks import MODEL, registration, sigmas
from tests.unit.preprocessing.square_scenes import SQUARE, SQUARE_LEAN, square_cloud, square_epoch

EXACT = InstrumentSigmas((1e-6, 1e-6), 1e-9, 1e-9)
"""Poses without error: what is left is the noise of the points."""

AZIMUTHS_DEG = tuple(60.0 * k for k in range(6))
STEADY = replace(registration(AZIMUTHS_DEG, sigmas()), covariance=1e-16 * np.eye(36))


def chi2_of(lean: Lean | FitFailure) -> float:
    assert isinstance(lean, Lean), lean
    off = lean.lean - SQUARE_LEAN
    return float(off @ np.linalg.solve(lean.covariance, off))


@pytest.fixture(scope="module")
def model() -> ShaftModel:
    found = isolate_shaft(square_cloud(np.random.default_rng(30), 8_000), SQUARE)
    assert isinstance(found, Shaft), found
    return found.model


def seen_by_six(seed: int, n: int = 16_000) -> PlacedCloud:
    """Points of all faces, seen by one of six stations each."""
    rng = np.random.default_rng(seed)
    return PlacedCloud(square_cloud(rng, n), rng.integers(0, 6, n).astype(np.uint16))


def of_faces(cloud: PlacedCloud, model: ShaftModel, stations: Registration = STEADY) -> Lean:
    found = fit_face_axis(cloud, model, stations, SQUARE.shaft_z_m)
    assert not isinstance(found, FitFailure), found
    return found[0]


def test_the_lean_of_a_tower_is_found_within_its_sigma() -> None:
    squares = [
        chi2_of(measure_lean(square_epoch(np.random.default_rng(seed)), SQUARE, EXACT)) for seed in range(2)
    ]
    # chi-square with 4 degrees of freedom: 0.5 % below 0.2 and above 14.9
    assert 0.2 < sum(squares) < 14.9


def test_all_points_at_once_are_no_worse_than_slices() -> None:
    cloud = square_epoch(np.random.default_rng(4))
    whole = measure_lean(cloud, SQUARE, EXACT)
    sliced = measure_lean(cloud, SQUARE, EXACT, "A", "robust")
    assert isinstance(whole, Lean)
    assert isinstance(sliced, Lean)
    assert np.trace(whole.point_covariance) < 1.1 * np.trace(sliced.point_covariance)
    assert np.abs(whole.lean - sliced.lean).max() < 4.0 * np.sqrt(np.trace(sliced.covariance))


def test_a_level_error_that_all_stations_share_is_in_the_lean(model: ShaftModel) -> None:
    level = np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]) * (10.0 * ARCSEC_RAD) ** 2
    shared = replace(STEADY, covariance=np.kron(np.ones((6, 6)), level) + STEADY.covariance)
    cloud = seen_by_six(5)
    more = of_faces(cloud, model, shared).propagated - of_faces(cloud, model).propagated
    assert np.sqrt(np.diag(more)) / ARCSEC_RAD == pytest.approx([10.0, 10.0], rel=0.02)


def test_stations_that_agree_keep_propagation_and_one_off_level_does_not(model: ShaftModel) -> None:
    cloud = seen_by_six(6)
    sound = of_faces(cloud, model)
    assert sound.jackknife is not None
    assert sound.source == "propagation"
    # six stations tell a variance to some 60 %
    assert 0.1 < np.trace(sound.jackknife) / np.trace(sound.propagated) < 4.0
    points, own = cloud.points_m.copy(), cloud.station_index == 1
    points[own] += np.cross([90.0 * ARCSEC_RAD, 0.0, 0.0], points[own] - STEADY.poses[1].position_m)
    tilted = of_faces(replace(cloud, points_m=points), model)
    assert tilted.source == "jackknife"
    assert np.trace(tilted.covariance) > 10.0 * np.trace(sound.covariance)


def test_bands_stand_on_the_axis(model: ShaftModel) -> None:
    found = fit_face_axis(seen_by_six(7), model, STEADY, SQUARE.shaft_z_m)
    assert not isinstance(found, FitFailure), found
    lean, bands = found
    assert len(bands) == lean.n_slices == 40
    assert lean.n_centres == 40
    assert [band.contour for band in bands] == ["polygon"] * 40
    # a band of 400 points of 6 mm: 0.4 mm a component; 40 of them, the largest at 4 sigmas
    assert lean.axis.residuals_m is not None
    assert lean.axis.residuals_m.max() < 0.003


def test_models_of_round_shafts_refuse_plane_faces_and_the_other_way_round(model: ShaftModel) -> None:
    cloud = seen_by_six(8, 500)
    on_round = lean_of_surface(cloud, MODEL, STEADY, SurfaceQuestion("faces", SQUARE.shaft_z_m, "horizontal"))
    assert isinstance(on_round, FitFailure)
    assert on_round.reason.startswith("needs a shaft with plane faces, got a round one")
    on_square = lean_of_surface(
        cloud, model, STEADY, SurfaceQuestion("shaft", SQUARE.shaft_z_m, "horizontal")
    )
    assert on_square == FitFailure("surface model shaft needs a round shaft, got one with plane faces")
