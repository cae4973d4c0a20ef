"""Clouds that are rare, and must not break the fit: no noise, exact poses, idle stations, points that fit nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.surface import SurfaceFit, SurfaceRequest, fit_surface
from tests.unit.surface.shafts import ARCSEC, LEAN, Shaft, request_of, scanned, stations_of

POSE_SIGMAS = np.array([1.4e-5, 1.4e-5, 1e-4, 0.002, 0.002, 0.002])


def asked(shaft: Shaft, seed: int = 1) -> SurfaceRequest:
    """A shaft, and stations with poses as good as a registration makes them."""
    covariance = np.diag(np.tile(POSE_SIGMAS**2, shaft.stations))
    poses = stations_of(shaft.stations, covariance)
    return replace(request_of(scanned(shaft, seed), shaft), poses=poses)


def fitted(request: SurfaceRequest, model: str = "shaft") -> SurfaceFit:
    """A fit that is one."""
    fit = fit_surface(model, request)
    assert isinstance(fit, SurfaceFit), fit
    return fit


def test_poses_without_any_error_are_poses() -> None:
    shaft = Shaft(points=6000)
    request = replace(asked(shaft), poses=stations_of(8, np.zeros((48, 48))))
    exact, nearly = fitted(request), fitted(request_of(request.cloud, shaft))
    assert exact.lean == pytest.approx(nearly.lean, abs=1e-9)


@pytest.mark.parametrize("model", ["shaft", "cone"])
def test_a_shaft_without_noise_has_its_lean_and_a_covariance(model: str) -> None:
    fit = fitted(asked(Shaft(points=6000, sigma_m=0.0)), model)
    assert fit.lean == pytest.approx(LEAN, abs=1e-9)
    # of a noise of 1e-7 radii, not of none
    variances = np.linalg.eigvalsh(fit.point_covariance)
    assert variances.min() > 0.0
    assert np.sqrt(variances.max()) < 1e-6


def test_stations_that_saw_nothing_do_not_count_among_those_left_out() -> None:
    shaft = Shaft(points=6000, stations=3)
    alone = fitted(asked(shaft))
    with_idle = asked(replace(shaft, stations=6))
    cloud = scanned(shaft, 1)
    # stations 0, 2 and 4 of six stand where the three stand
    moved = replace(cloud, station_index=(2 * cloud.station_index).astype(np.uint16), n_stations=6)
    idle = fitted(replace(with_idle, cloud=moved))
    assert alone.station_changes is not None
    assert idle.station_changes is not None
    assert idle.station_changes == pytest.approx(alone.station_changes, abs=1e-9)
    one = replace(cloud, station_index=np.zeros(len(cloud.points_m), dtype=np.uint16), n_stations=6)
    assert fitted(replace(with_idle, cloud=one)).station_changes is None


def test_points_that_fit_no_surface_are_refused_with_the_reason() -> None:
    reasons = set()
    for seed in (1, 3, 5):
        scatter = asked(Shaft(points=250, stations=1, sigma_m=0.2, half_view_rad=0.3), seed)
        fit = fit_surface("shaft", scatter)
        assert isinstance(fit, FitFailure)
        reasons.add(fit.reason)
    assert reasons <= {
        "needs bands of the shaft with a centre, got none among 27",
        "the surface ran away: needed points near it, got none",
        "the surface needed to settle within 12 passes, it did not",
    }


@pytest.mark.parametrize("seed", range(8))
def test_a_round_shaft_seen_on_a_quarter_is_not_taken_for_a_wavy_one(seed: int) -> None:
    """Bending and harmonics of such an arc undo each other in decimetres: neither may be judged beside the other."""
    shaft = Shaft(points=8000, stations=1, arc_deg=90.0, sigma_m=0.005)
    # exact poses: what is left is the surface
    fit = fitted(request_of(scanned(shaft, seed), shaft))
    assert fit.curve.model == "straight"
    assert float(np.abs(fit.lean - LEAN).max()) < 30 * ARCSEC
    assert float(np.sqrt(np.diag(fit.point_covariance)).max()) < 8 * ARCSEC


@pytest.mark.parametrize("seed", range(4))
def test_a_wavy_wall_seen_from_one_side_is_neither_bent_nor_more_certain_than_it_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    waves = rng.normal(0.0, 0.0023, (2, 5, 3))

    def wavy(z: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
        terms = np.polynomial.legendre.legvander((z - 52.0) / 50.0, 2)
        orders = range(2, 7)
        cosines = sum(terms @ waves[0, k - 2] * np.cos(k * turn) for k in orders)
        return np.asarray(cosines + sum(terms @ waves[1, k - 2] * np.sin(k * turn) for k in orders))

    shaft = Shaft(points=20_000, stations=1, arc_deg=160.0, sigma_m=0.005, wall=wavy)
    # exact poses: what is left is the surface
    fit = fitted(request_of(scanned(shaft, seed), shaft))
    assert fit.curve.model == "straight"
    off = fit.lean - LEAN
    assert float(off @ np.linalg.solve(fit.point_covariance + fit.form_covariance, off)) < 18.4
